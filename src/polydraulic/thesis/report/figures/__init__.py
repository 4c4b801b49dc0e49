"""The figures: `draw` (panels), `schematic`, `volumes`, and by chapter."""
