from .c.source import export_c, to_c
from .controller import controller_c, export_controller
from .exported import Exported
from .fmu.description import FmuDescription, FmuVariable
from .fmu.machine import export_machine_fmu
from .fmu.networks import export_fmu
from .fmu.package import write_fmu
from .formula import to_latex, to_python, to_sympy, to_text
from .machine import export_machine, machine_c
from .model_bundle import Bundle, bundle
from .names import c_name
from .onnx.model import export_onnx, to_onnx
from .targets import TARGETS, export_models
from .verify import Agreement, agreement_table, verify_models
from .watch.fmu import export_watch_fmu
from .watch.source import export_watch, watch_c

__all__ = [
    "TARGETS",
    "Agreement",
    "Bundle",
    "Exported",
    "FmuDescription",
    "FmuVariable",
    "agreement_table",
    "bundle",
    "c_name",
    "controller_c",
    "export_c",
    "export_controller",
    "export_fmu",
    "export_machine",
    "export_machine_fmu",
    "export_models",
    "export_onnx",
    "export_watch",
    "export_watch_fmu",
    "machine_c",
    "to_c",
    "to_latex",
    "to_onnx",
    "to_python",
    "to_sympy",
    "to_text",
    "verify_models",
    "watch_c",
    "write_fmu",
]
