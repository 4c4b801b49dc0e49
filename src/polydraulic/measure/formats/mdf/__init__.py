"""MDF logs: `mdf_log` opens them, `conversion` and `formula` say what their raw values are, `links` what is damaged."""
