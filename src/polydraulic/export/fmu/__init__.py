"""FMUs: `description` says what there is, `xml` and `package` write it; `networks` makes one of models, `run` of dynamic ones, `machine` of a machine.

The C of both versions of FMI stands in ``sources``; it knows nothing of networks or machines.
"""
