"""Why computed numbers differ from the printed ones: one thing is changed at a time, and the number computed again."""
