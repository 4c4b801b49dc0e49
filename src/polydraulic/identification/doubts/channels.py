"""What the channels of a log say of each other, put together: which contradict each other, and how."""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.doubts.levers import lever_doubts, lever_votes
from polydraulic.identification.doubts.torques import beyond_relief, torque_doubts
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.tables import Table


class ChannelDoubt(NamedTuple):
    """A contradiction between channels of a log.

    Attributes
    ----------
    columns : tuple of str
        That cannot all be right, the one least to be trusted first.
    text : str
        What contradicts what, by how much, and what to do.
    """

    columns: tuple[str, ...]
    text: str


def channel_doubts(machine: LayoutMachine, table: Table) -> list[ChannelDoubt]:
    """Contradictions between the channels of a log, whatever each says alone.

    A joint goes the way its valve is open for, and what the oil pushes with is what motion, weight and friction ask for. Both hold of every
    machine that is near to its file, whatever its valves are like; a turned sign, exchanged channels, a factor of ten show far beyond what a
    fault or a wrong guess does. Where a log has too few moves to tell, nothing is said.

    Parameters
    ----------
    machine : LayoutMachine
    table : Table
        The log, in SI, with times that rise.

    Returns
    -------
    list of ChannelDoubt
    """
    if len(table) < 3 or not np.all(np.diff(table["time"]) > 0.0):
        return []
    votes = lever_votes(machine, table)
    found = list(lever_doubts(machine, table, votes))
    places = {f.name: position_column(machine, f) for f in machine.functions}
    if not any(set(places.values()).intersection(columns) for columns, _ in found):
        # torques need positions that are right
        right = [places[name] for name, of in votes.items() if any(v.sure and not v.turned for v in of.values())]
        found += list(beyond_relief(machine, table)) or torque_doubts(machine, table, right).named
    return [ChannelDoubt(*doubt) for doubt in found]
