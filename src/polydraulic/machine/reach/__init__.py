"""Where the tip of a machine is and how it moves with the joints (`tip`), how far these go (`travels`), and what it reaches: `poses`, level `lines`."""
