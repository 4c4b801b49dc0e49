"""Effects that a machine file may declare of a function: friction that holds, backlash, hysteresis and flow force of the valve."""

from collections.abc import Mapping
from typing import Any

from polydraulic.parameters.entries import read_switch
from polydraulic.parameters.layout.parts import TRAVEL, TURN, Effects, FlowForce
from polydraulic.parameters.layout.reader import Reader


def read_effects(reader: Reader, data: Mapping[str, Any], where: str, slides: bool) -> Effects:
    """Effects of a function.

    Parameters
    ----------
    reader : Reader
    data : mapping
        Table of the function.
    where : str
        Its path in the file.
    slides : bool
        Whether its joint is prismatic.
    """
    friction, valve = _table(data, "friction"), _table(data, "valve")
    sticks, backlash, hysteresis = False, None, None
    if "sticks" in friction:
        sticks = reader.tried(lambda: read_switch(friction["sticks"], f"{where}.friction.sticks", reader.path), False)
    if "backlash" in data:
        backlash = reader.number(data, "backlash", TRAVEL if slides else TURN, where)
    if "hysteresis" in valve:
        hysteresis = reader.number(valve, "hysteresis", TRAVEL, f"{where}.valve")
    return Effects(sticks, backlash, hysteresis, reader.part(FlowForce, valve, "flow_force", f"{where}.valve"))


def _table(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    found = data.get(key)
    return found if isinstance(found, Mapping) else {}
