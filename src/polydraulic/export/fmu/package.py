"""An FMU as a file: sources, binary, description, documentation, in a zip that is the same whenever it is made."""

import hashlib
import uuid
import zipfile
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path

from polydraulic import __version__
from polydraulic.errors import InputError
from polydraulic.export.build import (
    COMPILERS,
    compile_library,
    cross_compilers,
    find_compiler,
    library_ending,
    platform_tuple,
)
from polydraulic.export.c.text import literal, string
from polydraulic.export.exported import Exported
from polydraulic.export.fmu.description import FmuDescription
from polydraulic.export.fmu.xml import build_description, model_description, terminals_and_icons
from polydraulic.files import replacing

_HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
_FMI2_FOLDER = {"x86_64-linux": "linux64", "x86_64-darwin": "darwin64", "x86_64-windows": "win64"}
# Only what FMI names is visible, and without prefix.
_FLAGS = ("-fvisibility=hidden", "-DFMI2_OVERRIDE_FUNCTION_PREFIX", "-DFMI3_OVERRIDE_FUNCTION_PREFIX")


def write_fmu(
    what: FmuDescription,
    sources: Mapping[str, str],
    path: str | Path,
    *,
    version: int,
    page: str,
    icon: str | None = None,
    extra: Mapping[str, str] | None = None,
    compiler: str | None = None,
    cross: bool = False,
    notes: Sequence[str] = (),
) -> Exported:
    """Write an FMU.

    Parameters
    ----------
    what : FmuDescription
    sources : mapping from file name to C
        ``equations.h``, which ``fmu.h`` includes and describes, and the files that it needs; those that end in .c are
        compiled.
    path : str or Path
    version : int
        2 or 3.
    page : str
        Documentation, HTML.
    icon : str, optional
        SVG, for FMI 3.0; one with the name if not given.
    extra : mapping from path in the FMU to text, optional
        Further files.
    compiler : str, optional
        Command, as for `find_compiler`. Without any the FMU holds sources only.
    cross : bool
        Whether to add binaries for other platforms: Windows, macOS, Linux on both processors; needs the package ziglang.
    notes : sequence of str
        To be told with it.

    Returns
    -------
    Exported
        Without a compiler its `binaries` are empty and a note says so: the FMU then holds sources, which the importer has to compile.

    Raises
    ------
    InputError
        A path that does not end in .fmu or cannot be written, another version, a compiler that is missing, or sources
        that do not compile.
    """
    path = Path(path)
    if path.suffix != ".fmu":
        raise InputError(f"{path}: an FMU ends in .fmu")
    main = f"fmi{version}.c"
    compiled = [main, *(name for name in sources if name.endswith(".c"))]
    tool = f"polydraulic {__version__}"
    unsigned = model_description(what, version, "", compiled, tool)
    own = [main, "fmu.h", "LICENSE-FMI.txt", *_HEADERS[version]]
    text = {name: files(__package__).joinpath("sources", name).read_text(encoding="utf-8") for name in own}
    text |= dict(sources)
    digest = hashlib.sha256(repr((unsigned, sorted(text.items()))).encode()).digest()[:16]
    token = f"{{{uuid.UUID(bytes=digest)}}}"
    text["config.h"] = _config(what, token)
    contents: dict[str, bytes] = {}

    def add(name: str, content: str) -> None:
        contents[name] = content.encode()

    add("modelDescription.xml", model_description(what, version, token, compiled, tool))
    for name, content in text.items():
        add(f"sources/{name}", content)
    add("documentation/licenses/LICENSE-FMI.txt", text["LICENSE-FMI.txt"])
    add("documentation/index.html", page)
    if version == 3:
        add("sources/buildDescription.xml", build_description(what, compiled))
        add("terminalsAndIcons/terminalsAndIcons.xml", terminals_and_icons())
        add("terminalsAndIcons/icon.svg", icon or _icon(what.name))
    contents[("terminalsAndIcons/icon.png" if version == 3 else "model.png")] = (
        files(__package__).joinpath("sources", "icon.png").read_bytes()
    )
    for name, content in (extra or {}).items():
        add(name, content)
    own_compiler = find_compiler(compiler)
    commands = {platform_tuple(): own_compiler} if own_compiler else {}
    commands |= cross_compilers() if cross else {}
    for machine, command in commands.items():
        contents[_binary_path(what.name, version, machine)] = compile_library(command, text, compiled, _FLAGS)
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in sorted(contents.items(), key=lambda item: (item[0] != "modelDescription.xml", item[0])):
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))  # no time of its own
            entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
            archive.writestr(entry, data)
    missing = f"no C compiler ({', '.join(COMPILERS)}) is installed: the FMU holds sources only, which the importer has to compile"
    return Exported((path,), (*([] if commands else [missing]), *notes), tuple(commands))


def _config(what: FmuDescription, token: str) -> str:
    kinds = {"parameter": "FMU_PARAMETER", "fixed parameter": "FMU_FIXED_PARAMETER", "input": "FMU_INPUT",
             "output": "FMU_OUTPUT"}  # fmt: skip
    seen = {kind: 0 for kind in kinds}
    places = []
    for variable in what.variables:
        places.append(str(seen[variable.kind]))
        seen[variable.kind] += 1

    def row(values: Sequence[str]) -> str:
        return f"{{{', '.join(values)}}}"

    return f"""#ifndef CONFIG_H
#define CONFIG_H

#define FMU_PREFIX {what.name}_
#define FMU_TOKEN {string(token)}
#define FMU_N_VARIABLES {len(what.variables)}
#define FMU_N_INPUTS {seen["input"]}
#define FMU_N_OUTPUTS {seen["output"]}
#define FMU_N_MEMORY {what.memory}
#define FMU_INTERNAL_STEP {literal(what.step or 0.0)} /* s; 0: there is none */
#define FMU_MODEL_EXCHANGE {int(what.model_exchange)}
#define FMU_DERIVATIVES {int(what.derivatives)}
#define FMU_KINDS {row([kinds[variable.kind] for variable in what.variables])}
#define FMU_PLACES {row(places)}
#define FMU_STARTS {row([literal(variable.start) for variable in what.variables])}

#endif
"""


def _binary_path(name: str, version: int, machine: str) -> str:
    """Where the binary for a platform stands in the FMU."""
    folder = machine if version == 3 else _FMI2_FOLDER.get(machine, machine)
    return f"binaries/{folder}/{name}{library_ending(machine)}"


def _icon(name: str) -> str:
    safe = name.replace("&", "&amp;").replace("<", "&lt;")
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="200" height="200" viewBox="0 0 200 200">\n'
        '<rect x="2" y="2" width="196" height="196" fill="#fff" stroke="#1f4e79" stroke-width="4"/>\n'
        '<path d="M20 140 C60 140 60 50 100 50 S140 110 180 110" fill="none" stroke="#c55a11" stroke-width="6"/>\n'
        f'<text x="100" y="182" font-family="sans-serif" font-size="18" text-anchor="middle">{safe}</text>\n</svg>\n'
    )
