"""From tables and logs to models, and how far they can be trusted."""
