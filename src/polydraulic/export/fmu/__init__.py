"""FMUs: `description` says what there is, `xml` and `package` write it; `networks` makes one of models, `machine` of a machine.

The C of both versions of FMI stands in ``sources``; it knows nothing of networks or machines.
"""

from polydraulic.export.fmu.description import FmuDescription, FmuVariable
from polydraulic.export.fmu.machine import export_machine_fmu
from polydraulic.export.fmu.networks import describe_networks, export_fmu
from polydraulic.export.fmu.package import WrittenFmu, write_fmu

__all__ = [
    "FmuDescription",
    "FmuVariable",
    "WrittenFmu",
    "describe_networks",
    "export_fmu",
    "export_machine_fmu",
    "write_fmu",
]
