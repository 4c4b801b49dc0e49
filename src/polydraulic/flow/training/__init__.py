"""How the networks that come with the package are learnt from the exact circuits.

`circuit_models` (outlets, and inlets in all modes at once), `mode_models` (inlets by the mode of the pump), `train` (the command).
"""
