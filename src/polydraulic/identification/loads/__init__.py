"""What hangs and pushes at the tip of a machine that is known, from its log."""
