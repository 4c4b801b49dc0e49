"""The network of one output: grown, chosen among its layers, refined, and kept if it says more than chance would.

If what was found is no more than a search so wide finds in any target, the search is repeated with a penalty that counts what there is
to choose from: each coefficient costs ln(p) times as much, p being the number of terms (the risk inflation criterion; Foster and George,
1994). What is left of a relation that is weak, or hidden among many inputs, is found by that. If there is nothing, the network is a constant.
"""

import logging
from collections.abc import Callable
from dataclasses import replace
from math import log
from typing import NamedTuple

import numpy as np

from polydraulic.networks.growth.prescreen import promising_inputs
from polydraulic.networks.growth.refine import refine
from polydraulic.networks.growth.synthesis import SMALLEST_VARIANCE, Settings, synthesize
from polydraulic.networks.growth.training_rows import TrainingRows, sample_of
from polydraulic.networks.growth.unseen.chance import effective_rows, log_chance, log_terms
from polydraulic.networks.growth.unseen.choice import KeptLayer, best_on_blocks, best_on_rows, last_layer
from polydraulic.networks.growth.unseen.evidence import helps_on_others
from polydraulic.networks.model.history import GrowthStep
from polydraulic.networks.model.table import Node

_log = logging.getLogger(__name__)
_MAX_REFINEMENTS = 100  # passes over the rows
# rows above which a sample of so many does what no row decides: scores, steps of refinement but the last
_MANY, _SAMPLE = 150_000, 65_536
_LAST_REFINEMENTS = 2  # with all rows, after those with a sample
_CHANCE = log(0.05)  # probability at which agreement no longer counts as chance


class LearntOutput(NamedTuple):
    """Nodes on normalized inputs, none for a constant; layers tried; mean squared error as a share of the target's variance."""

    nodes: list[Node]
    history: list[GrowthStep]
    fse: float


def learn_output(
    rows: TrainingRows,
    settings: Settings,
    bounds: tuple[float, float],
    *,
    max_inputs: int,
    polish: bool,
    leave_one_out: bool,
    apart: TrainingRows | None = None,
) -> LearntOutput:
    """Learn one output.

    Parameters
    ----------
    rows : TrainingRows
    settings : Settings
    bounds : (low, high)
        Of the normalized output.
    max_inputs : int
        Of more inputs the most promising are searched.
    polish : bool
        Whether coefficients are refined together.
    leave_one_out : bool
        Whether rows left out choose the layer, and chance is ruled out; the last accepted layer if not.
    apart : TrainingRows, optional
        The same rows with a block for all that depends on each other.
    """
    s = rows.scaling
    few = rows  # of weighted rows a few may decide
    if s.n_row > _MANY and s.weight == s.n_row:
        few = sample_of(rows, _SAMPLE)

    def searched(part: TrainingRows) -> np.ndarray:
        n_input = len(s.x_mean)
        inputs = np.arange(n_input) if n_input <= max_inputs else promising_inputs(part, max_inputs)
        return np.asarray(inputs[s.varies[inputs]])

    inputs = searched(rows)

    def learnt(settings: Settings) -> tuple[KeptLayer, list[GrowthStep]]:
        grown, history = synthesize(rows, inputs, settings, few)
        for h in history:
            _log.info("layer %d: K %d, PSE %.6g, %d tried", h.layer, h.n_coefficients, h.pse, h.n_candidates)
        variance = max(s.y_scale**2, SMALLEST_VARIANCE)
        errors = [step.fse / variance for step in history[: len(grown)]]
        refined = _refinement(rows, few, bounds, grown, errors) if polish else None
        if not leave_one_out:
            chosen = last_layer(grown, errors, refined)
        elif apart is None:
            chosen = best_on_rows(grown, errors, refined, few, bounds, s.weight)
        else:
            chosen = best_on_blocks(grown, errors, refined, apart, bounds)
        history[: len(grown)] = [
            replace(step, leave_one_out=error * s.y_scale**2)
            for step, error in zip(history, chosen.unseen, strict=False)
        ]
        return chosen, history

    chosen, history = learnt(settings)
    if not leave_one_out or not chosen.nodes:
        return LearntOutput(chosen.nodes, history, chosen.fse)
    n_input = int(np.count_nonzero(s.varies))
    counting = replace(settings, cpm=settings.cpm * log_terms(settings.kinds, n_input))

    def by_chance(found: KeptLayer, n_row: float) -> bool:
        return not found.nodes or log_chance(found.nodes, n_input, n_row, found.fse) > _CHANCE

    if by_chance(chosen, s.weight):
        _log.info("no more than chance: searched again with a penalty for the terms to choose from")
        chosen, history = learnt(counting)
    sure = not by_chance(chosen, s.weight)
    if sure and (
        apart is not None or by_chance(chosen, effective_rows(chosen.nodes, few) * s.weight / few.scaling.weight)
    ):
        sure = helps_on_others(few if apart is None else apart, counting, searched, apart=apart is not None)
    if sure:
        return LearntOutput(chosen.nodes, history, chosen.fse)
    _log.info("nothing found beyond chance: a constant")
    return LearntOutput([], history, history[0].fse / max(s.y_scale**2, SMALLEST_VARIANCE))


def _refinement(
    rows: TrainingRows, few: TrainingRows, bounds: tuple[float, float], grown: list[list[Node]], errors: list[float]
) -> Callable[[list[Node]], tuple[list[Node], float]]:
    """Refinement of one of the grown networks: on a sample where there is one, and at last on all rows."""
    variance = rows.scaling.y_scale**2

    def watch(i: int, loss: float) -> None:
        _log.debug("refinement %d: FSE %.6g", i, loss * variance)

    def refined(nodes: list[Node]) -> tuple[list[Node], float]:
        found, fse = refine(nodes, few, bounds, max_iterations=_MAX_REFINEMENTS, watch=watch)
        if few is rows:
            return found, fse
        found, fse = refine(found, rows, bounds, max_iterations=_LAST_REFINEMENTS, watch=watch)
        if fse <= errors[grown.index(nodes)]:
            return found, fse
        return refine(nodes, rows, bounds, max_iterations=_MAX_REFINEMENTS, watch=watch)

    return refined
