"""How far a machine is from tipping: all of it as one body, and the margins of that body over the edges of what it stands on."""
