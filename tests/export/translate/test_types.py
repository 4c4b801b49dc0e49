"""Types: the same as numba infers."""

import numba
import numpy as np
import pytest
from numba.core import compiler, registry, typed_passes, types
from polydraulic.export.excavator import machine_advance, outputs, prepared

from polydraulic.export.translate.program import Program
from polydraulic.export.translate.types import BOOL, FLOAT, INT, NOTHING, Array, Struct
from polydraulic.flow import FLOW_KINDS
from polydraulic.flow.dispatch import flow_step


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
    program.entry("f", machine_advance, [parts, memory, np.zeros(len(outputs())), np.zeros(3)])
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
