"""The model of a joint as a network: ramps of its lagged command first, then nodes of its polynomial, and the last angle added."""

from collections.abc import Sequence

import numpy as np

from polydraulic.networks.dynamic.command_response import Response
from polydraulic.networks.dynamic.lagged_terms import Frame, Terms
from polydraulic.networks.dynamic.refine_free_run import spread
from polydraulic.networks.dynamic.spans import Span, rows_of
from polydraulic.networks.dynamic.term_network import by_slots, places_read, term_nodes
from polydraulic.networks.model.nodes import RAMP
from polydraulic.networks.model.table import Network, Node


def joint_network(
    frame: Frame, terms: Terms, ramps: Sequence[tuple[int, Response, int]], signals: np.ndarray, columns: Sequence[int], spans: Sequence[Span]
) -> tuple[Network, list[tuple[int, int]]]:  # fmt: skip
    """Network of one joint, and what it reads: pairs of a column of `signals` and how many rows ago.

    Parameters
    ----------
    frame : Frame
        Its first signals are `ramps`, the others `columns` of the log, one row ago; the joint's own is the last.
    terms : Terms
    ramps : sequence of (column, Response, side)
        Command, and which of its edges.
    signals : (n_row, n_signal) array
        The log, in its own units.
    columns : sequence of int
    spans : sequence of (start, stop)
        Rows that were learnt from.
    """
    used = places_read(terms)
    opened = [place for place in used if place < len(ramps)]
    reads = sorted(
        {
            (column, 1 + int(row))
            for column, response, _ in (ramps[p] for p in opened)
            for row in np.flatnonzero(response.weights)
        }
    )
    n_command = len(reads)
    reads += [(columns[place - len(ramps)], 1) for place in used if place >= len(ramps)]
    rows = rows_of(spans)
    command = signals[rows][:, [column for column, _ in reads[:n_command]]]
    mean, scale, low, high = command.mean(axis=0), spread(command), command.min(axis=0), command.max(axis=0)
    nodes = []
    for column, response, side in (ramps[place] for place in opened):
        first, full = response.edges[side]
        slots = [slot for slot, (read, _) in enumerate(reads[:n_command]) if read == column]
        weights = response.weights[[reads[slot][1] - 1 for slot in slots]]
        constant = float(weights @ mean[slots] - first) / (full - first)
        nodes.append(Node(RAMP, tuple(slots), (constant, *(weights * scale[slots] / (full - first)).tolist())))
    slot = {place + 1: len(reads) + n for n, place in enumerate(opened)}
    behind = [place for place in used if place >= len(ramps)]
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
