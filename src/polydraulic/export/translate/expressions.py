"""Expressions: operation by operation in the order of Python, so that the bits agree."""

import ast
import builtins
import inspect
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

import polydraulic
from polydraulic.errors import InputError
from polydraulic.export.translate.file_scope import FileScope
from polydraulic.export.translate.names import field_name
from polydraulic.export.translate.signatures import Function
from polydraulic.export.translate.types import BOOL, FLOAT, INT, NOTHING, Array, Struct, Type, is_named_tuple
from polydraulic.export.translate.values import (
    AND,
    BITS,
    CHOICE,
    EQUAL,
    OR,
    ORDER,
    POSTFIX,
    PRODUCT,
    SHIFT,
    SUM,
    UNARY,
    WORD,
    Value,
    as_float,
    literal_value,
    plain,
    shown,
)
from polydraulic.flow.layout.text_module import written_name

_ROOT = Path(polydraulic.__file__).parent.parent
# Finds the translation of a kernel for types of arguments; None while it is being translated.
Kernels = Callable[[Any, tuple[Type, ...]], Function | None]
_OPERATORS: dict[type[ast.operator], tuple[str, int]] = {
    ast.Add: ("+", SUM),
    ast.Sub: ("-", SUM),
    ast.Mult: ("*", PRODUCT),
    ast.Div: ("/", PRODUCT),
    ast.BitAnd: ("&", BITS),
    ast.BitOr: ("|", BITS),
    ast.LShift: ("<<", SHIFT),
    ast.RShift: (">>", SHIFT),
}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, int]] = {
    ast.Eq: ("==", EQUAL),
    ast.NotEq: ("!=", EQUAL),
    ast.Lt: ("<", ORDER),
    ast.LtE: ("<=", ORDER),
    ast.Gt: (">", ORDER),
    ast.GtE: (">=", ORDER),
}
_WHY = {
    ast.Pow: "write x * x: a compiler may multiply where C calls pow, with other bits",
    ast.FloorDiv: "Python rounds down, C towards zero; use a shift of a number that is not negative",
    ast.Mod: "Python and C disagree for negative numbers; use & of a number that is not negative",
}


class Expressions:
    """Expressions of one function.

    Attributes
    ----------
    scope : FileScope
    kernels : function (python, types) -> Function or None
    python : function
    variables : dict
        Parameters and locals by Python name.
    parameters, local_names, assigned : set of str
        Names of the parameters, of all variables, and of those that have a value by now.
    steps : dict
        Functions that a name stands for, chosen by the type of an argument.
    written : set of str
        Parameters that are arrays and written, here or by what is called.
    """

    def __init__(self, scope: FileScope, kernels: Kernels, python: Any) -> None:
        self.scope, self.kernels, self.python = scope, kernels, python
        self.variables: dict[str, Value] = {}
        self.parameters: set[str] = set()
        self.local_names: set[str] = set()
        self.assigned: set[str] = set()
        self.steps: dict[str, Any] = {}
        self.written: set[str] = set()

    def refuse(self, node: ast.AST, what: str) -> NoReturn:
        """Say where, what, and what to do."""
        raise InputError(f"{_shown_file(self.python)}:{getattr(node, 'lineno', 0)}: {self.python.__name__}: {what}")

    def number(self, node: ast.expr, *, whole: bool = False) -> Value:
        """Value that must be a float or an int."""
        value = self.value(node, whole=whole)
        if value.type not in (FLOAT, INT):
            self.refuse(node, f"{ast.unparse(node)} is no number but {value.type}")
        return value

    def condition(self, node: ast.expr) -> Value:
        """Value as a condition; numbers are compared with 0 as Python does."""
        value = self.value(node)
        if value.type == BOOL:
            return value
        if value.type == INT:
            return Value(f"{value.inside(ORDER)} != 0", BOOL, EQUAL)
        self.refuse(node, f"{ast.unparse(node)} is no condition; compare it with something")

    def value(self, node: ast.expr, *, whole: bool = False) -> Value:
        """Translate; `whole` says that nothing else in the same expression reads arrays, so that a call may write."""
        match node:
            case ast.Constant(value=bool() | int() | float()):
                return literal_value(node.value)
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.Attribute():
                return self._attribute(node)
            case ast.Subscript():
                return self._subscript(node)
            case ast.BinOp():
                return self._operation(node, whole)
            case ast.UnaryOp():
                return self._unary(node, whole)
            case ast.Compare():
                return self._comparison(node)
            case ast.BoolOp(op=op, values=parts):
                word, binds = ("&&", AND) if isinstance(op, ast.And) else ("||", OR)
                values = [self.value(part) for part in parts]
                if any(value.type != BOOL for value in values):
                    self.refuse(node, f"{ast.unparse(node)} joins what is no condition; compare each part")
                least = BITS if word == "&&" else AND + 1
                return Value(f" {word} ".join(value.inside(least) for value in values), BOOL, binds)
            case ast.IfExp():
                return self._choice(node, whole)
            case ast.Call():
                return self._call(node, whole)
        self.refuse(
            node, f"no C is known for {ast.unparse(node)!r}; docs/architecture.md lists the rules for kernel code"
        )

    def known(self, node: ast.expr) -> Any:
        """Object that a name or an attribute of a module stands for outside the function; None if it is a value."""
        if isinstance(node, ast.Name) and node.id not in self.local_names:
            if node.id in self.python.__globals__:
                return self.python.__globals__[node.id]
            return getattr(builtins, node.id, None)
        if isinstance(node, ast.Attribute):
            owner = self.known(node.value)
            return getattr(owner, node.attr, None) if inspect.ismodule(owner) else None
        return None

    def _name(self, node: ast.expr, name: str) -> Value:
        if name in self.local_names:
            if name not in self.assigned:
                self.refuse(node, f"{name} may be read before it is assigned; assign it on every path")
            return self.variables[name]
        constant = self.known(node)
        if isinstance(constant, bool | int | float):
            return self.scope.constant(name, constant, self.python)
        self.refuse(node, f"{name} is no parameter, variable or numerical constant")

    def _attribute(self, node: ast.Attribute) -> Value:
        constant = self.known(node)
        if isinstance(constant, int | float):
            return literal_value(constant)
        owner = self.value(node.value)
        if not isinstance(owner.type, Struct):
            self.refuse(node, f"{ast.unparse(node)}: {owner.type} has no fields")
        fields = self.scope.layouts.fields[owner.type.cls]
        if node.attr not in fields:
            self.refuse(node, f"{written_name(owner.type.cls)} has no field {node.attr!r}; methods do not translate")
        text = f"{owner.inside(POSTFIX)}{'->' if owner.pointer else '.'}{field_name(node.attr)}"
        return Value(text, fields[node.attr], POSTFIX, place=owner.pointer or owner.place)

    def _subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.value, ast.Attribute) and node.value.attr == "shape":
            array = self.value(node.value.value)
            if isinstance(array.type, Array) and isinstance(node.slice, ast.Constant) and type(node.slice.value) is int:
                length = array.type.shape[node.slice.value]
                if length is None:
                    self.refuse(
                        node, "the arrays in this field differ in length; keep the length in a field of its own"
                    )
                return literal_value(length)
        array = self.value(node.value)
        if not isinstance(array.type, Array):
            self.refuse(node, f"{ast.unparse(node.value)} is no array; give the fields of a named tuple by name")
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(places) > len(array.type.shape):
            self.refuse(node, f"{len(places)} subscripts for an array of {len(array.type.shape)} dimensions")
        text = array.inside(POSTFIX)
        for place in places:
            number = self.value(place) if not isinstance(place, ast.Slice) else None
            if number is None or number.type != INT or number.text.startswith("-"):
                self.refuse(node, f"subscript {ast.unparse(place)!r} must be a whole number, at least 0")
            text += f"[{number.text}]"
        rest = array.type.shape[len(places) :]
        return Value(text, Array(array.type.element, rest) if rest else array.type.element, POSTFIX)

    def _quiet(self, node: ast.expr) -> bool:
        """Whether an expression neither reads arrays nor calls kernels."""
        calls = [part for part in ast.walk(node) if isinstance(part, ast.Call)]
        plain_calls = all(self.known(call.func) in (min, max, abs, float, int, math.sqrt) for call in calls)
        return plain_calls and not any(isinstance(part, ast.Subscript) for part in ast.walk(node))

    def _whole(self, nodes: list[ast.expr], whole: bool) -> list[bool]:
        """Which of several parts may write: one may if all others are quiet, since C evaluates them in any order."""
        quiet = [self._quiet(node) for node in nodes]
        return [whole and all(quiet[:i] + quiet[i + 1 :]) for i in range(len(nodes))]

    def _operation(self, node: ast.BinOp, whole: bool) -> Value:
        if type(node.op) not in _OPERATORS:
            self.refuse(node, f"{ast.unparse(node)}: {_WHY.get(type(node.op), 'no C is known for this operator')}")
        sign, binds = _OPERATORS[type(node.op)]
        parts = [node.left, node.right]
        left, right = (self.number(part, whole=may) for part, may in zip(parts, self._whole(parts, whole), strict=True))
        if binds in (BITS, SHIFT):
            if (left.type, right.type) != (INT, INT):
                self.refuse(node, f"{ast.unparse(node)}: bits of what is no whole number")
            return Value(f"{left.inside(UNARY)} {sign} {right.inside(UNARY)}", INT, binds)
        if FLOAT in (left.type, right.type) or sign == "/":
            left, right = as_float(left), as_float(right)
        return Value(f"{left.inside(binds)} {sign} {right.inside(binds + 1)}", left.type, binds)

    def _unary(self, node: ast.UnaryOp, whole: bool) -> Value:
        if isinstance(node.op, ast.Not):
            return Value(f"!{self.condition(node.operand).inside(UNARY)}", BOOL, UNARY)
        value = self.number(node.operand, whole=whole)
        if not isinstance(node.op, ast.USub):
            self.refuse(node, f"no C is known for {ast.unparse(node)!r}")
        inner = value.inside(UNARY)
        return Value(f"-({inner})" if inner.startswith("-") else f"-{inner}", value.type, UNARY)

    def _comparison(self, node: ast.Compare) -> Value:
        if len(node.ops) > 1 or type(node.ops[0]) not in _COMPARISONS:
            self.refuse(node, f"{ast.unparse(node)}: write two comparisons joined by 'and', of numbers")
        left, right = self.value(node.left), self.value(node.comparators[0])
        sign, binds = _COMPARISONS[type(node.ops[0])]
        if left.type == right.type == BOOL and binds == EQUAL:
            return Value(f"{left.inside(ORDER)} {sign} {right.inside(ORDER)}", BOOL, binds)
        left, right = self.number(node.left), self.number(node.comparators[0])
        if left.type != right.type:
            left, right = as_float(left), as_float(right)
        return Value(f"{left.inside(SHIFT + 1)} {sign} {right.inside(SHIFT + 1)}", BOOL, binds)

    def _choice(self, node: ast.IfExp, whole: bool) -> Value:
        test = self.condition(node.test)
        body, other = self.value(node.body, whole=whole), self.value(node.orelse, whole=whole)
        if {body.type, other.type} == {INT, FLOAT}:
            body, other = as_float(body), as_float(other)
        if body.type != other.type or isinstance(body.type, Array):
            self.refuse(
                node, f"{ast.unparse(node)}: {body.type} or {other.type}; both sides must be of one kind of value"
            )
        text = f"{test.inside(POSTFIX)} ? {plain(body).inside(OR)} : {plain(other).inside(OR)}"
        return Value(text, body.type, CHOICE)

    # calls

    def _call(self, node: ast.Call, whole: bool) -> Value:
        if node.keywords or any(isinstance(arg, ast.Starred) for arg in node.args):
            self.refuse(node, f"{ast.unparse(node)}: give arguments by place, each on its own")
        if isinstance(node.func, ast.Attribute) and node.func.attr == "view" and len(node.args) == 1:
            return self._view(node)
        target = self.steps.get(node.func.id) if isinstance(node.func, ast.Name) else None
        target = target if target is not None else self.known(node.func)
        if is_named_tuple(target):
            return self._construct(node, target, whole)
        if target in (min, max):
            return self._extreme(node, "minimum" if target is min else "maximum", whole)
        if target in (abs, math.sqrt):
            value = self.number(node.args[0], whole=whole)
            if target is abs and value.type == INT:
                self.refuse(node, "abs of a whole number; write a comparison")
            return Value(f"{'fabs' if target is abs else 'sqrt'}({as_float(value).text})", FLOAT, POSTFIX)
        if target in (float, np.float64):
            value = self.number(node.args[0])
            return as_float(value)
        if target in (int, np.int64):
            value = self.number(node.args[0])
            return value if value.type == INT else Value(f"(int64_t){value.inside(UNARY)}", INT, UNARY)
        python = getattr(target, "py_func", target)
        if not inspect.isfunction(python):
            more = (
                "; use polydraulic.elementary, which gives the same bits everywhere"
                if inspect.isbuiltin(target)
                else ""
            )
            self.refuse(node, f"{ast.unparse(node.func)}(...) is no kernel{more}")
        return self._kernel_call(node, python, whole)

    def _view(self, node: ast.Call) -> Value:
        assert isinstance(node.func, ast.Attribute)
        value, wanted = self.number(node.func.value), self.known(node.args[0])
        if value.type == INT and wanted is np.float64:
            return Value(f"{self.scope.helper('from_bits')}({value.text})", FLOAT, POSTFIX)
        if value.type == FLOAT and wanted is np.int64:
            return Value(f"{self.scope.helper('bits_of')}({value.text})", INT, POSTFIX)
        self.refuse(node, f"{ast.unparse(node)}: bits of a float as int64, or the other way round")

    def _extreme(self, node: ast.Call, name: str, whole: bool) -> Value:
        may = self._whole(node.args, whole)
        values = [self.number(arg, whole=one) for arg, one in zip(node.args, may, strict=True)]
        if len(values) < 2:
            self.refuse(node, f"{ast.unparse(node)}: needs two numbers")
        kind = FLOAT if any(value.type == FLOAT for value in values) else INT
        values = [as_float(value) for value in values] if kind == FLOAT else values
        name = self.scope.helper(name if kind == FLOAT else f"{name}_int")
        found = values[0]
        for value in values[1:]:
            found = Value(f"{name}({found.text}, {value.text})", kind, POSTFIX)
        return found

    def _construct(self, node: ast.Call, cls: type, whole: bool) -> Value:
        layouts = self.scope.layouts
        layouts.of_annotation(cls, written_name(cls))
        fields = layouts.fields[cls]
        if len(node.args) != len(fields):
            self.refuse(node, f"{written_name(cls)} has {len(fields)} fields, {len(node.args)} are given")
        texts = [
            self.converted(arg, self.value(arg, whole=may), kind, f"{written_name(cls)}.{name}").text
            for arg, may, (name, kind) in zip(node.args, self._whole(node.args, whole), fields.items(), strict=True)
        ]
        return Value(f"({self.scope.struct_name(cls)}){{{', '.join(texts)}}}", Struct(cls), POSTFIX, place=True)

    def converted(self, node: ast.AST, value: Value, kind: Type, where: str) -> Value:
        """Value as a field, a variable or a result of type `kind`: whole numbers become floats where those are meant."""
        if value.type == INT and kind == FLOAT:
            return as_float(value)
        if isinstance(value.type, Array) and isinstance(kind, Array):
            if (value.type.element, value.type.shape[1:]) == (kind.element, kind.shape[1:]):
                return value
        elif value.type == kind:
            return plain(value)
        self.refuse(node, f"{where} is {shown(kind)}, but gets {shown(value.type)}")

    def _kernel_call(self, node: ast.Call, python: Any, whole: bool) -> Value:
        may = self._whole(node.args, whole)
        values = [self.value(arg, whole=one) for arg, one in zip(node.args, may, strict=True)]
        callee = self.kernels(python, tuple(value.type for value in values))
        if callee is None:
            self.refuse(node, f"{python.__name__} calls itself; write a loop with a bound")
        if callee.writes and not whole:
            self.refuse(
                node, f"{python.__name__} writes into an array; give its result a name first: C has no order here"
            )
        texts = []
        for arg, value, parameter in zip(node.args, values, callee.parameters, strict=True):
            if parameter.written:
                if not (isinstance(arg, ast.Name) and arg.id in self.parameters):
                    self.refuse(
                        arg, f"{python.__name__} writes into {ast.unparse(arg)}, which must be a parameter here"
                    )
                self.written.add(arg.id)
            if not parameter.pointer:
                texts.append(plain(value).text)
            elif value.pointer:
                texts.append(value.text)
            elif value.place:
                texts.append(f"&{value.inside(POSTFIX)}")
            else:
                self.refuse(arg, f"{ast.unparse(arg)} has many fields and goes by pointer; give it a name first")
        binds = POSTFIX if callee.result != NOTHING else WORD
        return Value(f"{callee.name}({', '.join(texts)})", callee.result, binds)


def _shown_file(python: Any) -> str:
    """File of a function, from the folder of the package if it belongs to it."""
    path = Path(inspect.getsourcefile(python) or "?")
    return path.relative_to(_ROOT).as_posix() if path.is_relative_to(_ROOT) else path.as_posix()
