"""Logs of a CAN bus: frames, and the databases that say what is in them."""
