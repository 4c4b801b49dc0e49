"""A pump that feeds the last valve of another pump's two as well, through a check valve."""
