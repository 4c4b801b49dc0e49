"""Text of constants: products of parameters that functions read as fields, and what fills them before a run."""

from collections.abc import Sequence

from polydraulic.machine.tree.shapes import Shape
from polydraulic.machine.tree.statements import Constants, body, call
from polydraulic.machine.tree.terms import Term


def shapes_text(shapes: Sequence[Shape]) -> str:
    """The shapes that a text is written for."""
    lines = ["_SHAPES = ("]
    for shape in shapes:
        fields = [f"        {field}={_quoted(value)}," for field, value in shape._asdict().items()]
        lines += ["    Shape(", *fields, "    ),"]
    return "\n".join([*lines, ")"])


def _quoted(value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_quoted, value)) + ("," if len(value) == 1 else "") + ")"
    return repr(value)


def constants_text(constants: Constants, name: str) -> str:
    """A named tuple of constants."""
    fields = "\n".join(f"    {node.name}: float" for node in constants.nodes)
    return f'class {name}(NamedTuple):\n    """Masses and lengths, multiplied out; SI."""\n\n{fields}'


def prepare_text(constants: Constants, name: str, function: str) -> str:
    """A function, plain Python, that fills the named tuple `name` of constants."""
    roots = [Term(1.0, node) for node in constants.nodes]
    return f'''def {function}(links, gravity):
    """Constants of the equations of motion from the numbers of the links, and gravity in m/s2."""
    links, gravity = links_of_shape(links, _SHAPES), float(gravity)
{body(roots, lambda texts: call(name, texts))}'''
