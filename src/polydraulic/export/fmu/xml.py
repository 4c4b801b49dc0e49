"""The XML of an FMU: `modelDescription.xml` of both versions, and what FMI 3.0 says of sources and icons."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from polydraulic.errors import InputError
from polydraulic.export.c.text import one_line
from polydraulic.export.fmu.description import FmuDescription, FmuVariable, free_name
from polydraulic.export.fmu.units import display_unit, unit_element

VERSIONS = (2, 3)
_CAUSALITY = {"fixed parameter": "parameter"}
_VARIABILITY = {"parameter": "tunable", "fixed parameter": "fixed"}


def model_description(what: FmuDescription, version: int, token: str, sources: Sequence[str], tool: str) -> str:
    """`modelDescription.xml`.

    Parameters
    ----------
    what : FmuDescription
    version : int
        2 or 3.
    token : str
        Ties the XML to the binaries.
    sources : sequence of str
        Files that are to be compiled.
    tool : str
        Name and version of the tool that made it.

    Raises
    ------
    InputError
        Another version.
    """
    if version not in VERSIONS:
        raise InputError(f"FMI version {version!r}: must be one of {list(VERSIONS)}")
    token_name = "guid" if version == 2 else "instantiationToken"
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{version}.0",
            "modelName": what.name,
            token_name: token,
            "description": one_line(what.description),
            "generationTool": tool,
            "variableNamingConvention": "flat",
        },
    )
    if version == 2:
        root.set("numberOfEventIndicators", "0")
    _interfaces(root, what, version, sources)
    units = sorted({v.unit for v in what.variables if v.unit} | ({"s"} if version == 3 else set()))
    if units:
        SubElement(root, "UnitDefinitions").extend(unit_element(unit) for unit in units)
    SubElement(SubElement(root, "LogCategories"), "Category", name="logStatusError", description="What went wrong")
    experiment = {"startTime": "0", "stopTime": repr(what.stop)}
    SubElement(root, "DefaultExperiment", experiment | ({"stepSize": repr(what.step)} if what.step else {}))
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(what.variables):
        _variable(variables, variable, reference, version)
    if version == 3:
        time = free_name("time", [variable.name for variable in what.variables])
        SubElement(variables, "Float64", name=time, valueReference=str(len(what.variables)), causality="independent",
                   variability="continuous", unit="s")  # fmt: skip
    _structure(root, what, version)
    return _text(root)


def build_description(what: FmuDescription, sources: Sequence[str]) -> str:
    """`sources/buildDescription.xml` of FMI 3.0."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    files = SubElement(
        SubElement(root, "BuildConfiguration", modelIdentifier=what.name), "SourceFileSet", language="C99"
    )
    for name in sources:
        SubElement(files, "SourceFile", name=name)
    SubElement(files, "PreprocessorDefinition", name="FMI3_OVERRIDE_FUNCTION_PREFIX", optional="true", value="1",
               description="Define it to build a shared library")  # fmt: skip
    return _text(root)


def terminals_and_icons() -> str:
    """`terminalsAndIcons/terminalsAndIcons.xml` of FMI 3.0: where the icon is drawn."""
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    drawn = SubElement(root, "GraphicalRepresentation")
    corners = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    SubElement(drawn, "CoordinateSystem", corners, suggestedScalingFactorTo_mm="0.1")
    SubElement(drawn, "Icon", corners)
    return _text(root)


def _interfaces(root: Element, what: FmuDescription, version: int, sources: Sequence[str]) -> None:
    state = "FMUstate" if version == 2 else "FMUState"
    common = {"modelIdentifier": what.name, f"canGetAndSet{state}": "true", f"canSerialize{state}": "true"}
    if what.derivatives:
        names = ("Directional",) if version == 2 else ("Directional", "Adjoint")
        common |= {f"provides{name}Derivative{'' if version == 2 else 's'}": "true" for name in names}
    step = {"canHandleVariableCommunicationStepSize": "true"}
    if version == 3 and what.step:
        step["fixedInternalStepSize"] = repr(what.step)
    exchange = {"completedIntegratorStepNotNeeded": "true"} if version == 2 else {}
    found = [("ModelExchange", exchange)] if what.model_exchange else []
    for name, own in [*found, ("CoSimulation", step)]:
        element = SubElement(root, name, common | own)
        if version == 2:
            files = SubElement(element, "SourceFiles")
            for source in sources:
                SubElement(files, "File", name=source)


def _variable(parent: Element, variable: FmuVariable, reference: int, version: int) -> None:
    about = {
        "name": one_line(variable.name),
        "valueReference": str(reference),
        "description": one_line(variable.description),
        "causality": _CAUSALITY.get(variable.kind, variable.kind),
        "variability": _VARIABILITY.get(variable.kind, "continuous"),
    }
    if variable.kind != "input":
        about["initial"] = "calculated" if variable.kind == "output" else "exact"
    numbers = {"unit": variable.unit, "displayUnit": display_unit(variable.unit)}
    numbers |= {"min": _real(variable.low), "max": _real(variable.high), "nominal": _real(variable.nominal)}
    numbers["start"] = None if variable.kind == "output" else _real(variable.start)
    given = {name: value for name, value in numbers.items() if value}
    if version == 2:
        SubElement(SubElement(parent, "ScalarVariable", about), "Real", given)
    else:
        SubElement(parent, "Float64", about | given)


def _structure(root: Element, what: FmuDescription, version: int) -> None:
    structure, outputs = SubElement(root, "ModelStructure"), what.of_kind("output")
    parameters = [*what.of_kind("parameter"), *what.of_kind("fixed parameter")]

    def known(output: int, others: Sequence[int]) -> str:
        return " ".join(str(i + (version == 2)) for i in sorted([*what.depends_on(output), *others]))

    if version == 2:
        for name, others in (("Outputs", ()), ("InitialUnknowns", parameters)):
            if outputs:
                unknowns = SubElement(structure, name)
            for output in outputs:
                SubElement(unknowns, "Unknown", index=str(output + 1), dependencies=known(output, others))
        return
    for name, others in (("Output", ()), ("InitialUnknown", parameters)):
        for output in outputs:
            SubElement(structure, name, valueReference=str(output), dependencies=known(output, others))


def _real(value: float | None) -> str | None:
    return None if value is None else repr(float(value))


def _text(root: Element) -> str:
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"
