"""MAT logs of both versions: `mat_log` opens them."""
