"""Flow models of machines of any layout, circuit by circuit: `slots` and `networks`, exact circuits at points, `database`."""
