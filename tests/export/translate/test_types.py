"""Types: the same as numba infers; comments of fields, wherever a class stands."""

import ast
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core import compiler, registry, typed_passes, types

from polydraulic.export.machine import machine_parts
from polydraulic.export.translate.program import Program
from polydraulic.export.translate.types import BOOL, FLOAT, INT, NOTHING, Array, Struct, field_comments


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
    parts, program = machine_parts(machine, flow), Program()
    arguments = [parts.numbers, np.zeros(parts.n_memory), np.zeros(len(parts.outputs)), np.zeros(len(parts.inputs))]
    program.entry("f", parts.advance, arguments)
    target = registry.cpu_target
    compared = 0
    for function in program.functions.values():
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


class Above(NamedTuple):
    x: float  # m, along the boom
    n: int = 0


class Below(NamedTuple):
    x: float  # m, across it


def test_comments_of_fields_are_those_of_their_class(monkeypatch):
    parsed = []
    parse = ast.parse
    monkeypatch.setattr(ast, "parse", lambda *given, **options: parsed.append(given) or parse(*given, **options))
    assert field_comments(Above) == {"x": "m, along the boom"}
    assert field_comments(Below) == {"x": "m, across it"}
    assert len(parsed) == 1  # a module, however many of its classes are asked for
