"""Networks in place of the valves of one circuit: the records and kernels that the text of a machine is written around.

Networks have two forms. In a table they are plain arrays, which plain Python evaluates, and which leave as C. Compiled kernels get
machine code instead, and call it by the number of a model.
"""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from polydraulic._kernel import INLINED_OPTIONS, kernel
from polydraulic.machine.pump import Pump
from polydraulic.networks.model.machine_code import NetworkCode, answer_of, network_code
from polydraulic.networks.model.model import Model, pack_models
from polydraulic.networks.model.partition import Regions, choose
from polydraulic.networks.model.table import NetworkTable, evaluate

Networks = NetworkTable | NetworkCode
Which = Regions | int  # networks of one model: regions in a table, or the number of a model with machine code

_SMALLEST_ROOT = 1.0  # Pa^0.5; below it the outlet conductance no longer follows from flow / root


class ValveNetworks(NamedTuple):
    """Which networks stand for a valve, and how far they know their inputs; for a missing mode there is a constant, never the least.

    Attributes
    ----------
    q_in : Which
        At constant flow of the pump alone, or in all modes.
    relief, limited : Which
        With the relief valve open, and at the torque limit. `relief` is the conductance of a first inlet.
    shut : Which
        Of a first inlet at constant flow, if the check valve of the next is shut; `q_in` then may count that as open.
    k_out : Which
    cascade : bool
        Whether `q_in` reads what the valves before this one leave.
    by_root : bool
        Whether `k_out` gives a flow, of spool and root of the pressure drop.
    closes : float, m
        Travel beyond which the valve passes nothing on.
    travel_high, p_high, root_high : float
        Largest inputs for which the networks were trained.
    """

    q_in: Which
    relief: Which
    limited: Which
    shut: Which
    k_out: Which
    cascade: bool
    by_root: bool
    closes: float
    travel_high: float
    p_high: float
    root_high: float


class PassedNetworks(NamedTuple):
    """Which networks give what passes the first of several valves, where the pump does not deliver its full flow."""

    relief: Which
    limited: Which


class NumberedNetworks:
    """Networks of a flow model by the numbers of their models, and both forms of them.

    Parameters
    ----------
    models : sequence of Model
    parts : mapping
        Parts of the flow model, named tuples; where a field may be `Which`, it is the number of a model.
    """

    def __init__(self, models: Sequence[Model], parts: Mapping[str, Any]) -> None:
        self._models, self._parts = tuple(models), dict(parts)
        self._code: dict[str, Any] | None = None

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_code": None}  # which is of this process

    def in_table(self) -> dict[str, Any]:
        """Parts with networks in a table."""
        regions, table = pack_models(self._models)
        return {"table": table} | {name: _with_regions(part, regions) for name, part in self._parts.items()}

    def as_code(self) -> dict[str, Any]:
        """Parts with networks as machine code, which is compiled when it is first asked for."""
        if self._code is None:
            self._code = {"table": network_code(self._models)} | self._parts
        return self._code


def _with_regions(part: Any, regions: Sequence[Regions]) -> Any:
    which = [name for name, kind in type(part).__annotations__.items() if kind == Which]
    return part._replace(**{name: regions[getattr(part, name)] for name in which})


def network_value(table: Any, which: Any, memory: Any) -> Any:
    """Value of the network that answers for the inputs in the first places of `memory`, which is scratch.

    Parameters
    ----------
    table : Networks
    which : Which
    memory : array
    """
    return evaluate(table, choose(which, memory), memory)


@overload(network_value, jit_options=INLINED_OPTIONS)
def _compiled_value(table: Any, which: Any, memory: Any) -> Any:
    if table.instance_class is NetworkTable:  # of code that leaves as C, whose types are held to those of numba
        return network_value

    def called(table: Any, which: Any, memory: Any) -> Any:  # numba wants the same annotations
        return answer_of(table, which, memory)

    return called


@kernel
def or_less(q: float, table: Networks, which: Which, memory: np.ndarray) -> float:
    """The least of a flow and of that of another mode; where nothing flows in one, no other is less."""
    return min(q, network_value(table, which, memory)) if q > 0.0 else 0.0


@kernel
def entering(q: float, table: Networks, k_in: Which, memory: np.ndarray, p: float, pump: Pump) -> float:
    """Flow into the first line at pressure p: the least of q, of the flow with the relief valve open, and of the pump's."""
    k = network_value(table, k_in, memory) if q > 0.0 else 0.0
    return min(max(q, 0.0), min(k * sqrt(max(pump.relief - p, 0.0)), pump.flow))


@kernel
def root_drop(p: float, p_rest: float) -> float:
    """Root of a pressure difference, 0 where it is negative."""
    return sqrt(max(p - p_rest, 0.0))


@kernel
def leaving(table: Networks, valve: ValveNetworks, memory: np.ndarray, spool: float, root: float) -> float:
    """Conductance of an outlet."""
    memory[0] = spool
    memory[1] = root
    k = network_value(table, valve.k_out, memory)
    return max(k / max(root, _SMALLEST_ROOT) if valve.by_root else k, 0.0)
