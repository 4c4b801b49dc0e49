"""The model of a joint as a network: play and ramps of its lagged command, then nodes of its polynomial, and the last angle added."""

from collections.abc import Mapping, Sequence

import numpy as np

from polydraulic.networks.dynamic.command_response import Response
from polydraulic.networks.dynamic.lagged_terms import Frame, Terms
from polydraulic.networks.dynamic.refine_free_run import spread
from polydraulic.networks.dynamic.spans import Span, rows_of
from polydraulic.networks.dynamic.term_network import by_slots, places_read, term_nodes
from polydraulic.networks.model.nodes import LINEAR, RAMP
from polydraulic.networks.model.table import Network, Node

Read = tuple[int, float, float]  # slot of a lagged command, its mean and its scale


def joint_network(
    frame: Frame, terms: Terms, ramps: Sequence[tuple[int, Response, int]], n_own: int, signals: np.ndarray, columns: Sequence[int],
    spans: Sequence[Span],
) -> tuple[Network, list[tuple[int, int]]]:  # fmt: skip
    """Network of one joint, and what it reads: pairs of a column of `signals` and how many rows ago.

    Parameters
    ----------
    frame : Frame
        Its first signals are the joint's own ramps, and where there are others their sum; then come `columns` of the log, one row ago, the
        joint's own as the last.
    terms : Terms
    ramps : sequence of (column, Response, side)
        Command, and which of its edges; the joint's own first.
    n_own : int
        How many of them are its own.
    signals : (n_row, n_signal) array
        The log, in its own units.
    columns : sequence of int
    spans : sequence of (start, stop)
        Rows that were learnt from.
    """
    used = places_read(terms)
    n_raw = n_own + (len(ramps) > n_own)
    opened = [place for place in used if place < n_own]
    others = [*range(n_own, len(ramps))] if n_own < n_raw and n_own in used else []
    reads = sorted(
        {(column, ago) for column, response, _ in (ramps[p] for p in opened + others) for ago in response.reads}
    )
    n_command = len(reads)
    reads += [(columns[place - n_raw], 1) for place in used if place >= n_raw]
    rows = rows_of(spans)
    command = signals[rows][:, [column for column, _ in reads[:n_command]]]
    mean, scale, low, high = command.mean(axis=0), spread(command), command.min(axis=0), command.max(axis=0)
    at = {read: (slot, float(mean[slot]), float(scale[slot])) for slot, read in enumerate(reads[:n_command])}
    nodes: list[Node] = []
    plays: dict[int, dict[int, int]] = {}
    openings = []
    for column, response, side in (ramps[place] for place in opened + others):
        if column not in plays:
            chain = _play_nodes(column, response, at, len(reads) + len(nodes))
            plays[column] = {ago: len(reads) + len(nodes) + n for n, ago in enumerate(chain)}
            nodes += chain.values()
        openings.append(len(reads) + len(nodes))
        nodes.append(_ramp_node(column, response, side, at, plays[column]))
    slot = {place + 1: node for place, node in zip(opened, openings, strict=False)}
    if others:
        slot[n_own + 1] = len(reads) + len(nodes)
        nodes.append(Node(LINEAR, tuple(openings[len(opened) :]), (1.0,) * len(others)))
    behind = [place for place in used if place >= n_raw]
    slot |= {place + 1: n_command + n for n, place in enumerate(behind)}
    own = [*frame.column[behind]]
    nodes += term_nodes(by_slots(terms, 0, slot), len(reads) + len(nodes))
    ends = (frame.mean[own] + frame.scale[own] * end[behind] for end in (frame.low, frame.high))
    x_low, x_high = (np.concatenate(pair) for pair in zip((low, high), ends, strict=True))
    y_mean, y_scale = float(frame.mean[-1]), float(frame.scale[-1])
    network = Network(
        tuple(nodes),
        tuple(np.concatenate([mean, frame.mean[own]]).tolist()),
        tuple(np.concatenate([scale, frame.scale[own]]).tolist()),
        tuple(x_low.tolist()), tuple(x_high.tolist()), y_mean, y_scale,
        y_mean + y_scale * float(frame.y_low[0]), y_mean + y_scale * float(frame.y_high[0]),
    )  # fmt: skip
    return network, reads


def _play_nodes(column: int, response: Response, at: Mapping[tuple[int, int], Read], first: int) -> dict[int, Node]:
    """Where the valve is within its play, 0 for half of it below the command and 1 for half of it above; by how many rows ago.

    The oldest comes first, in slot `first`; it counts as having come from rest. Each of the others goes by the one before it.
    """
    found: dict[int, Node] = {}
    if not response.play:
        return found
    play, older = response.play, 0
    for ago in reversed(response.reads):
        slot, mean, scale = at[column, ago]
        if not older:
            found[ago] = Node(RAMP, (slot,), ((response.rest - mean) / play + 0.5, -scale / play))
        else:
            before, mean_before, scale_before = at[column, older]
            coef = (mean_before - mean) / play, scale_before / play, -scale / play, 1.0
            found[ago] = Node(RAMP, (before, slot, first + len(found) - 1), coef)
        older = ago
    return found


def _ramp_node(
    column: int, response: Response, side: int, at: Mapping[tuple[int, int], Read], plays: Mapping[int, int]
) -> Node:
    """The opening to one side, from the command as it follows within its play."""
    edge, full = response.edges[side]
    slots, coef, constant = [], [], -edge
    for ago in (1 + np.flatnonzero(response.weights)).tolist():
        weight = float(response.weights[ago - 1])
        slot, mean, scale = at[column, ago]
        constant += weight * (mean - 0.5 * response.play)
        slots.append(slot)
        coef.append(weight * scale / (full - edge))
        if plays:
            slots.append(plays[ago])
            coef.append(weight * response.play / (full - edge))
    return Node(RAMP, tuple(slots), (constant / (full - edge), *coef))
