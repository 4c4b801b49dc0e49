"""Every target by its name, for the command line and for scripts."""

import ast
from collections.abc import Sequence
from pathlib import Path

from polydraulic.errors import InputError
from polydraulic.export.c.source import export_c
from polydraulic.export.c.text import one_line
from polydraulic.export.exported import Exported
from polydraulic.export.fmu.networks import export_fmu
from polydraulic.export.formula import to_latex, to_python, to_sympy
from polydraulic.export.model_bundle import Bundle, bundle
from polydraulic.export.onnx.model import export_onnx
from polydraulic.files import write_text
from polydraulic.networks.model.lag_words import dynamic_notes
from polydraulic.networks.model.model import Model
from polydraulic.progress import Progress, quiet

ENDINGS = {
    "c": "", "fmi2": ".fmu", "fmi3": ".fmu", "onnx": ".onnx", "python": ".py", "sympy": ".py", "latex": ".tex",
}  # fmt: skip
TARGETS = tuple(ENDINGS)
_PAIR = "ExprCondPair"  # in no public module of SymPy
_FILES = {*ENDINGS.values(), ".c", ".h", ".zip", ".json"} - {""}  # endings that are not those of folders


def export_models(
    models: Sequence[Model],
    to: str,
    out: str | Path,
    *,
    name: str | None = None,
    real: str = "double",
    cross: bool = False,
    progress: Progress = quiet,
) -> Exported:
    """Write models for a target.

    Parameters
    ----------
    models : sequence of Model
        One per output.
    to : str
        "c", "fmi2", "fmi3", "onnx", "python", "sympy" or "latex".
    out : str or Path
        A file with the ending of the target, or a folder.
    name : str, optional
        Name of the export, made a C identifier; else the name of the file, of the one output, or "model".
    real : str
        "double" or "float": precision of C and ONNX.
    cross : bool
        Whether FMUs get binaries for other platforms too; needs the package ziglang.
    progress : Progress, optional
        Told of proofs of C in single precision, output by output.

    Returns
    -------
    Exported

    Raises
    ------
    InputError
        Unknown target or option, models that do not go together, or a place that cannot be written.
    """
    if to not in TARGETS:
        raise InputError(f"unknown target {to!r}; choose one of {list(TARGETS)}")
    if real != "double" and to not in ("c", "onnx"):
        raise InputError(f"real = {real!r} goes with the targets c and onnx, not with {to}")
    if cross and to not in ("fmi2", "fmi3"):
        raise InputError(f"binaries for other platforms go with the targets fmi2 and fmi3, not with {to}")
    out = Path(out)
    as_file = is_file(to, out)
    if not as_file and out.suffix in _FILES:
        raise InputError(f"{out}: {to} writes {ENDINGS[to] or 'two files'}; give {_place(to)}")
    whole = bundle(models, name=out.stem if as_file and name is None else name)
    path = out if as_file else out / f"{whole.name}{ENDINGS[to]}"
    if to == "c":
        return export_c(models, out, name=whole.name, real=real, progress=progress)
    if to in ("fmi2", "fmi3"):
        return export_fmu(models, path, version=int(to[-1]), name=whole.name, cross=cross)
    if to == "onnx":
        return export_onnx(models, path, name=whole.name, real=real)
    write_text(path, {"python": _python, "sympy": _sympy, "latex": _latex}[to](whole))
    names = whole.name_notes() if to in ("python", "sympy") else []
    return Exported((path,), (*names, *dynamic_notes(models)))


def _place(to: str) -> str:
    return f"a folder or a name that ends in {ENDINGS[to]}" if ENDINGS[to] else "a folder"


def is_file(to: str, out: str | Path) -> bool:
    """Whether `out` is the file to write for target `to`, not the folder to write it to."""
    return bool(ENDINGS.get(to)) and Path(out).suffix == ENDINGS[to]


def _python(whole: Bundle) -> str:
    """A function per output, without dependencies."""
    functions = zip(whole.models, whole.identifiers()[1], strict=True)
    notes = "".join(f"# {one_line(note)}\n" for note in dynamic_notes(whole.models))
    return "\n\n".join([*([notes] if notes else []), *(to_python(model, name) for model, name in functions)])


def _sympy(whole: Bundle) -> str:
    """A module that builds the expressions, in a function: an output may be called S or Add."""
    from sympy import srepr

    texts = [srepr(to_sympy(model)) for model in whole.models]
    used = {node.id for text in texts for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    lines = [f'"""{whole.name} as SymPy expressions, valid inside the domain."""', ""]
    lines += [f"# {line}" for m in whole.models for line in (_about(m), *map(one_line, dynamic_notes([m])))]
    lines += ["", "", "def own_expressions():", f"    from sympy import {', '.join(sorted(used - {_PAIR}))}"]
    lines += ["    from sympy.core.parameters import distribute"]
    lines += [f"    from sympy.functions.elementary.piecewise import {_PAIR}"] if _PAIR in used else []
    lines += ["", "    with distribute(False):  # else numbers would be multiplied into sums and lose digits"]
    lines += ["        return (", *(f"            {text}," for text in texts), "        )", "", ""]
    lines += [f"{', '.join(whole.identifiers()[1])}{',' if len(texts) == 1 else ''} = own_expressions()"]
    return "\n".join(lines) + "\n"


def _about(model: Model) -> str:
    return one_line(f"{model.output} from {', '.join(map(str, model.inputs))}")


def _latex(whole: Bundle) -> str:
    """Display mathematics, for a document with amsmath."""
    parts = []
    for model in whole.models:
        notes = "".join(f"% {one_line(note)}\n" for note in dynamic_notes([model]))
        parts.append(f"% {_about(model)}; needs \\usepackage{{amsmath}}\n{notes}\\[\n{to_latex(model)}\\]\n")
    return "\n".join(parts)
