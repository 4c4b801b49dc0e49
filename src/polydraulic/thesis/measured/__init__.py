"""How much data of what quality buys what accuracy: networks, and the equations with identified curves, from the same log."""
