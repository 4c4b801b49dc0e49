"""Kernels in C: the same values, the same types as numba infers, and a clear no where there is no counterpart."""

import ctypes
import inspect
import math
import shutil
import subprocess
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core import compiler, registry, typed_passes, types

from helpers.c_machine import STRICT
from polydraulic import elementary
from polydraulic.errors import InputError
from polydraulic.export.machine import machine_advance, outputs, prepared
from polydraulic.export.translate.program import Program
from polydraulic.export.translate.types import BOOL, FLOAT, INT, NOTHING, Array, Struct
from polydraulic.flow import FLOW_KINDS
from polydraulic.flow.dispatch import flow_step

INCLUDES = "".join(f"#include <{name}.h>\n" for name in ("math", "stdbool", "stddef", "stdint", "string"))
LIMIT, _SHIFT = 3, 0.25


class Pair(NamedTuple):
    """Two numbers."""

    a: float  # first
    static: float


class Large(NamedTuple):
    """Goes by pointer."""

    one: Pair
    two: Pair
    n: int
    rows: np.ndarray


def library(folder, *kernels):
    """Shared library of the kernels, each with its example arguments."""
    program = Program()
    for kernel, examples in kernels:
        program.entry(kernel.__name__, kernel, examples)
    prototypes = "".join(f"{f.prototype};\n" for f in program.functions.values() if "static" not in f.prototype)
    text = f"{INCLUDES}\n{program.scope.structs()}\n{prototypes}\n{program.code()}"
    (folder / "k.c").write_text(text)
    command = ["gcc", *STRICT, "-O2", "-ffp-contract=off", "-shared", "-fPIC", "k.c", "-lm", "-o", "k.so"]
    subprocess.run(command, check=True, cwd=folder)
    loaded = ctypes.CDLL(str(folder / "k.so"))
    for kernel, examples in kernels:
        function = getattr(loaded, kernel.__name__)
        function.restype = ctypes.c_double
        kinds = {float: ctypes.c_double, int: ctypes.c_int64, np.ndarray: ctypes.c_void_p}
        function.argtypes = [kinds[type(example)] for example in examples]
    return loaded, text


def _helper(x: Pair, n: int) -> Pair:
    """Adds up."""
    for _ in range(n):
        x = Pair(x.a + x.static, x.static)
    return x


def _write(v, x):
    v[0], v[1] = x, 2.0 * x
    v[2] += _SHIFT
    return v[0] * v[1]


def many_things(x: float, n: int, v: np.ndarray) -> float:
    """Everything a kernel may do: */ even this."""
    # a comment above
    total = 0.0  # and one behind
    if x > 1.0:
        sign = 1.0
    elif x < -1.0 and n > 0:
        sign = -1.0
    else:
        return min(max(x, -0.0), 0.5, _SHIFT) - 1 / n
    for i in range(n):
        if i == LIMIT:
            continue
        if (i & 1) | (i >> 2):
            total += i * x - (x - i)
            half = total / 2
        elif not (i < n - 2):
            break
        else:
            half = -(-1.0 * x)
        total = total + (half if half > 0.0 else abs(half - 2)) * sign
    pair = _helper(Pair(total, sign), n)
    written = 1.0 - max(_write(v, pair.a), x) * 2.0  # alone among what reads no arrays
    return written - (pair.a - (pair.static - math.sqrt(abs(x))) - 1.0) - float(n) / (2 + n)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_statements_and_expressions_mean_the_same(tmp_path):
    c, text = library(tmp_path, (many_things, [0.0, 1, np.zeros(3)]))
    assert "/* Everything a kernel may do: * / even this. */" in text
    assert "    /* a comment above */\n    double total = 0.0; /* and one behind */" in text
    assert "} else if (x < -1.0 && n > 0) {" in text
    for x in (-7.3, -1.0, -0.2, 0.0, 0.3, 1.1, 5.0):
        for n in range(1, 9):
            ours, theirs = np.array([1.5, 2.5, x]), np.array([1.5, 2.5, x])
            assert c.many_things(x, n, ours.ctypes.data) == many_things(x, n, theirs)
            assert np.array_equal(ours, theirs)


def extremes(a: float, b: float) -> float:
    return 1.0 / min(a, b) + 3.0 / max(a, b)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_minimum_and_maximum_choose_as_python_does(tmp_path):
    c, _ = library(tmp_path, (extremes, [0.0, 0.0]))
    values = (1.0, -2.0, math.inf, -math.inf, math.nan)
    for a in values:
        for b in values:
            assert np.array_equal(c.extremes(a, b), extremes(a, b), equal_nan=True)
    assert c.extremes(0.0, -0.0) == math.inf  # the first of two equal ones, as in Python
    assert c.extremes(-0.0, 0.0) == -math.inf


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_elementary_functions_have_the_same_bits(tmp_path):
    functions = (elementary.exp, elementary.log, elementary.tanh)
    c, _ = library(tmp_path, *((getattr(f, "py_func", f), [0.0]) for f in functions))
    rng = np.random.default_rng(4)
    for x in [*rng.uniform(-30.0, 30.0, 500), 0.0, -0.0, 1e-300, 700.0, -800.0, 1e308]:
        assert c.exp(x) == elementary.exp(x)
        assert c.tanh(x) == elementary.tanh(x)
        if x > 0.0:
            assert c.log(x) == elementary.log(x)


def test_a_pointer_stands_for_a_copy_only_where_nothing_changes():
    program = Program()
    program.entry("f", _read, [Large(Pair(1.0, 2.0), Pair(3.0, 4.0), 5, np.ones((2, 3)))])
    assert "const Large *again = p;" in program.code()
    assert "double static_;" in program.scope.structs()
    assert "double a; /* first */" in program.scope.structs()


def _read(p: Large) -> float:
    again = p
    return again.one.a + again.rows[0, again.n - 4]


class Nested(NamedTuple):
    """A struct with a large part."""

    part: Pair
    x: float
    y: float
    z: float
    more: Pair


class Outer(NamedTuple):
    """Holds the struct."""

    inner: Nested


def _swapped(x: float) -> float:
    value = Outer(Nested(Pair(x, 1.0), 2.0, 3.0, 4.0, Pair(5.0, 6.0)))
    inner = value.inner
    value = Outer(Nested(Pair(0.0, 0.0), 0.0, 0.0, 0.0, Pair(0.0, 0.0)))
    return inner.part.a + value.inner.part.a


def swapped(x: float) -> float:
    return _swapped(x)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_a_part_of_what_changes_later_is_copied(tmp_path):
    c, text = library(tmp_path, (swapped, [0.0]))
    assert "const Nested inner = value.inner;" in text
    assert c.swapped(7.0) == 7.0


# What does not translate


def power(x: float) -> float:
    return x**2


def unbounded(x: float) -> float:
    while x < 1.0:
        x = 2.0 * x
    return x


def swap(x: float) -> float:
    a, b = x, 2.0
    a, b = b, a
    return a - b


def unpacks(x: float) -> float:
    a, b = _pair(x)
    return a + b


def _pair(x: float) -> Pair:
    return Pair(x, x)


def chained(x: float) -> float:
    return 1.0 if 0.0 < x < 1.0 else 0.0


def unassigned(x: float) -> float:
    if x > 0.0:
        y = 1.0
    return y


def two_types(x: float) -> float:
    y = 0
    y = x
    return y


def no_end(x: float) -> float:
    if x > 0.0:
        return x


def library_function(x: float) -> float:
    return math.exp(x)


def writes_inside(v: np.ndarray) -> float:
    return v[0] + _write(v, 2.0)


def writes_twice(v: np.ndarray) -> float:
    return min(_write(v, 2.0), _write(v, 3.0))


def writes_through_another_name(v: np.ndarray) -> float:
    w = v
    y = _write(w, 2.0)
    return y


def sliced(v: np.ndarray) -> float:
    return v[1:][0]


def backwards(v: np.ndarray) -> float:
    return v[-1]


def calls_itself(x: float) -> float:
    return x if x > 1.0 else calls_itself(x + 1.0)


def by_keyword(x: float) -> Pair:
    return Pair(a=x, static=1.0)


def steps_of_two(n: int) -> int:
    k = 0
    for i in range(0, n, 2):
        k += i
    return k


def bound_changes(v: np.ndarray, n: int) -> float:
    for i in range(n):
        n = n - 1
        v[i] = 0.0
    return v[0]


def read_after_loop(n: int) -> int:
    total = 0
    for i in range(n):
        total += i
    return i


def allocates(n: int) -> float:
    return np.zeros(n)[0]


def rounds_down(n: int) -> int:
    return n // 2


def truth_of_a_float(x: float) -> float:
    return 1.0 if x else 2.0


def with_default(x: float = 1.0) -> float:
    return x


def method(p: Pair) -> float:
    return p.count(1.0)


REFUSED = [
    (power, 1, "write x * x"),
    (unbounded, 1, "has no bound"),
    (swap, 2, "a is read after it has changed"),
    (unpacks, 1, "use its fields"),
    (chained, 1, "two comparisons"),
    (unassigned, 3, "y may be read before it is assigned"),
    (two_types, 2, "y is int and gets float"),
    (no_end, 0, "does not return on every path"),
    (library_function, 1, "use polydraulic.elementary"),
    (writes_inside, 1, "give its result a name first"),
    (writes_twice, 1, "give its result a name first"),
    (writes_through_another_name, 2, "must be a parameter"),
    (sliced, 1, "must be a whole number"),
    (backwards, 1, "at least 0"),
    (calls_itself, 1, "calls itself"),
    (by_keyword, 1, "by place"),
    (steps_of_two, 2, "steps of 1"),
    (bound_changes, 1, "may not change inside"),
    (read_after_loop, 4, "i may be read before"),
    (allocates, 1, "is no kernel"),
    (rounds_down, 1, "Python rounds down"),
    (truth_of_a_float, 1, "is no condition"),
    (with_default, 0, "without defaults"),
    (method, 1, "is no kernel"),
]
EXAMPLES = {"x": 1.0, "n": 3, "v": np.zeros(3), "p": Pair(1.0, 2.0)}


@pytest.mark.parametrize(("kernel", "line", "why"), REFUSED, ids=[kernel.__name__ for kernel, _, _ in REFUSED])
def test_what_has_no_counterpart_is_refused_with_file_and_line(kernel, line, why):
    examples = [EXAMPLES[name] for name in inspect.signature(kernel).parameters]
    with pytest.raises(InputError) as error:
        Program().entry("f", kernel, examples)
    where = f"{__file__}:{inspect.getsourcelines(kernel)[1] + line}: "
    assert str(error.value).startswith(where)
    assert why in str(error.value)


def test_examples_without_counterpart_are_named():
    with pytest.raises(InputError, match="argument 0.one.a: a str, which has no counterpart"):
        Program().entry("f", _read, [Large(Pair("a", 1.0), Pair(1.0, 1.0), 1, np.zeros((2, 2)))])
    with pytest.raises(InputError, match="x_a is not a number"):
        Program().scope.data(Pair(math.nan, 1.0), "x")


# Types


def numba_type(kind, layouts):
    """Our type as numba's."""
    simple = {FLOAT: types.float64, INT: types.int64, BOOL: types.boolean, NOTHING: types.none}
    if isinstance(kind, Array):
        return types.Array(simple[kind.element], len(kind.shape), "C")
    if isinstance(kind, Struct):
        fields = [numba_type(field, layouts) for field in layouts.fields[kind.cls].values()]
        return types.BaseTuple.from_types(fields, kind.cls)
    return simple[kind]


@pytest.mark.slow
@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")
@pytest.mark.parametrize("flow", ["exact", "polynomial", "neural", "iterative", "stiff", "tlm"])
def test_types_are_those_that_numba_infers(machine, flow):
    parts = prepared(machine, flow)
    memory = np.zeros(FLOW_KINDS[flow].n_memory(parts.model))
    program = Program()
    program.entry("f", machine_advance, [parts, memory, np.zeros(len(outputs())), 0.0, 0.0, 0.0])
    target = registry.cpu_target
    compared = 0
    for function in program.functions.values():
        if function.python is flow_step:  # numba has an overload in its place
            continue
        arguments = tuple(numba_type(p.type, program.scope.layouts) for p in function.parameters)
        ir = compiler.run_frontend(function.python)
        target.typing_context.refresh()
        found = typed_passes.type_inference_stage(target.typing_context, target.target_context, ir, arguments, None)
        assert types.unliteral(found.return_type) == numba_type(function.result, program.scope.layouts), function.name
        inferred = {name.split(".")[0]: types.unliteral(kind) for name, kind in found.typemap.items()}
        for name, kind in function.locals.items():
            if name in inferred and name != "_":
                assert numba_type(kind, program.scope.layouts) == inferred[name], f"{function.name}: {name}"
                compared += 1
    assert compared > 300
