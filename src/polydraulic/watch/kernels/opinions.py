"""What abductive networks take a fault for: the evidence of each kind of fault as they read it, their outputs, and probabilities of these."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.elementary import exp, log
from polydraulic.networks.model.table import NetworkTable, evaluate
from polydraulic.watch.kernels.evidence import KEPT, best_evidence
from polydraulic.watch.kernels.numbers import (
    BLOCKS,
    CERTAINTY,
    FAMILIAR,
    FIRST,
    KIND,
    STUCK,
    TOLD,
    WatchNumbers,
)

_LEAST, _LEAST_SCATTER = 1e-9, 1e-3
_LOG10 = 0.4342944819032518  # of e


class KindNumbers(NamedTuple):
    """Networks that name kinds of faults, as kernels read them."""

    networks: NetworkTable  # one for each kind that was learnt
    link: np.ndarray  # from their outputs to logarithms of probabilities: for each kind factors, and a constant last
    kind: np.ndarray  # of each direction, by number in the order of the directions
    known: int  # kinds that were learnt
    watched: int  # kinds of directions
    inputs: int  # that networks read


class KindOpinion(NamedTuple):
    """What networks take a fault for: the number of a kind, its probability, and whether the evidence is like that which was learnt from."""

    kind: int
    certainty: float
    familiar: bool


@driver
def ask_networks(
    numbers: WatchNumbers,
    kinds: KindNumbers,
    work: np.ndarray,
    live: np.ndarray,
    marks: np.ndarray,
    room: np.ndarray,
    slots: np.ndarray,
) -> None:
    """Ask networks about a block that was diagnosed: what they say stays until another one is, or a sensor that stays is named."""
    if marks[STUCK] > 0:
        marks[KIND] = 0
    elif marks[TOLD] == marks[BLOCKS]:
        seen = numbers.in_work + 3 * numbers.directions + numbers.directions * numbers.directions
        blocks = min(marks[BLOCKS] - marks[FIRST], KEPT)
        said = opinion_of(kinds, work, seen, blocks, numbers.common, numbers.down, room, slots)
        marks[KIND] = 1 + said.kind
        marks[FAMILIAR] = 1 if said.familiar else 0
        live[CERTAINTY] = said.certainty


@driver
def opinion_of(
    kinds: KindNumbers,
    seen: np.ndarray,
    at_seen: int,
    blocks: int,
    together: float,
    down: np.ndarray,
    room: np.ndarray,
    slots: np.ndarray,
) -> KindOpinion:
    """What networks take for what was seen of all directions; `room` gets what they read, and behind it what they say, `slots` their nodes."""
    read_evidence(kinds.kind, kinds.watched, seen, at_seen, blocks, together, down, room)
    said = kinds.inputs
    for k in range(kinds.known):
        for i in range(kinds.inputs):
            slots[i] = room[i]
        output = evaluate(kinds.networks, k, slots)
        room[said + k] = output
    best, most = 0, 0.0
    for k in range(kinds.known):
        likely = 0.0
        for other in range(kinds.known):
            likely += kinds.link[k, other] * room[said + other]
        likely += kinds.link[k, kinds.known]
        room[said + kinds.known + k] = likely
        best = k if k == 0 or likely > most else best
        most = likely if k == 0 or likely > most else most
    total = 0.0
    for k in range(kinds.known):
        total += exp(room[said + kinds.known + k] - most)
    familiar = True
    for i in range(kinds.inputs):
        familiar = familiar and kinds.networks.x_low[best, i] <= room[i] and room[i] <= kinds.networks.x_high[best, i]
    return KindOpinion(best, 1.0 / total, familiar)


@driver
def read_evidence(
    kind: np.ndarray,
    watched: int,
    seen: np.ndarray,
    at_seen: int,
    blocks: int,
    together: float,
    down: np.ndarray,
    found: np.ndarray,
) -> None:
    """What networks read of pull, information and squares of all directions, of which each has a kind, in so many blocks.

    Of the strongest direction of each kind the square root of its share in the most evidence; the logarithm of that; and of each kind's again the
    logarithm of the scatter of blocks about it, which is large where it explains one block and not the next.
    """
    n = kind.shape[0]
    for j in range(watched):
        found[j] = -1.0
    most = _LEAST
    for k in range(n):
        pull, information, squares = seen[at_seen + k], seen[at_seen + n + k], seen[at_seen + 2 * n + k]
        evidence = max(best_evidence(pull, information, together, down[k]), 0.0)
        if evidence > found[kind[k]]:
            scatter = (squares - pull * pull / max(information, 1e-300)) / float(max(blocks - 1, 1))
            found[kind[k]] = evidence
            found[watched + 1 + kind[k]] = max(scatter, _LEAST_SCATTER * together) / together
        most = max(most, evidence)
    for j in range(watched):
        found[j] = sqrt(found[j] / most)
        found[watched + 1 + j] = _LOG10 * log(found[watched + 1 + j])
    found[watched] = _LOG10 * log(most)
