"""What a network can answer anywhere in a box of inputs: a proof, not a sample.

Enclosures of `taylor`, sharpened by `branch_and_bound`. The values that users see are meant: the rounding of the compiled
evaluation is part of every bound.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.partition import EVERYWHERE
from polydraulic.networks.model.rows_table import evaluate_rows
from polydraulic.networks.model.table import Network, pack, used_slots
from polydraulic.networks.proof.branch_and_bound import Ends, Goal, close_to_found, search
from polydraulic.networks.proof.taylor import enclose_output, enclose_slopes


class Bounds(NamedTuple):
    """Proved range of a network over a box.

    Attributes
    ----------
    low, high : float
        No output leaves this range, after unitizer and output clamps, the rounding of the evaluation included.
    attained_low, attained_high : float
        Smallest and largest output found, infinite the wrong way round if all were NaN; the true range lies between
        the attained and the proved one.
    slopes : (n_input, 2) array
        Proved ranges of dy/dx_i, in units of the output over those of the input, of the polynomial before its output
        is clamped. They hold 0 for an input whose box reaches out of the domain, where it is clamped.
    where_low, where_high : (n_input,) array
        Points of the box with the attained outputs.
    n_boxes : int
        Sub-boxes enclosed, for the output and for the slopes.
    converged : bool
        Whether `low` and `high` are as close to the attained values as asked.
    """

    low: float
    high: float
    attained_low: float
    attained_high: float
    slopes: np.ndarray
    where_low: np.ndarray
    where_high: np.ndarray
    n_boxes: int
    converged: bool


class ModelBounds(NamedTuple):
    """Proved range of a model; `regions` has one entry per network, None where the box does not meet its region."""

    low: float
    high: float
    regions: tuple[Bounds | None, ...]


class Leaving(NamedTuple):
    """A point at which a model leaves a range: region in words, inputs, output of the compiled model."""

    region: str
    point: np.ndarray
    value: float


class RangeCheck(NamedTuple):
    """Whether a model stays in a range; ``str()`` says it in a sentence.

    Attributes
    ----------
    holds : bool or None
        None if it could not be decided within the budget.
    low, high : float
        Proved range of the model; not tighter than the question needs.
    asked : (float, float)
        The range.
    leaving : tuple of Leaving
        One counterexample for each region that leaves the range.
    undecided : tuple of str
        Regions for which the budget of `max_boxes` sub-boxes did not do.
    max_boxes : int
    sentence : str
    """

    holds: bool | None
    low: float
    high: float
    asked: tuple[float, float]
    leaving: tuple[Leaving, ...]
    undecided: tuple[str, ...]
    max_boxes: int
    sentence: str

    def __str__(self) -> str:
        return self.sentence


def network_bounds(
    network: Network, box: np.ndarray | None = None, *, tolerance: float = 0.01, max_boxes: int = 20000
) -> Bounds:
    """Proved range of outputs and slopes of a network over a box.

    Parameters
    ----------
    network : Network
    box : (n_input, 2) array-like, optional
        Low and high of each input in the user's units, infinite ones included; the network's domain if not given. A box
        may reach out of the domain: inputs are clamped to it.
    tolerance : float, default=0.01
        Allowed distance of the proved from the attained output, and of the slopes likewise, as a part of the width of
        the attained range.
    max_boxes : int, default=20000
        Maximum number of sub-boxes, for the output and once more for the slopes.

    Raises
    ------
    InputError
        If the box has another shape, holds NaN or a low above its high, or the tolerance or budget makes no sense.

    Notes
    -----
    Where an intermediate value exceeds what a float can hold, the range is infinite in spite of output clamps, as the
    evaluation may give NaN there.

    Examples
    --------
    >>> from polydraulic.networks import Node
    >>> product = Node(1, (0, 1), (0, 0, 0, 0, 0, 1, 0, 0))
    >>> found = network_bounds(Network((product,), (0, 0), (1, 1), (-1, -2), (1, 2), 0, 1))
    >>> round(found.low, 9), round(found.high, 9)
    (-2.0, 2.0)
    """
    names = [f"input {i}" for i in range(network.n_inputs)]
    domain = np.sort([network.x_low, network.x_high], axis=0).T
    asked = _checked_box(domain if box is None else box, names)
    _check_effort(tolerance, max_boxes)
    inside = _clamped(network, asked)
    output, n_output, converged = _output_range(network, inside, close_to_found(tolerance), max_boxes)
    slopes, n_slopes = _slope_ranges(network, inside, tolerance, max_boxes)
    reaches_out = (asked[:, 0] < network.x_low) | (asked[:, 1] > network.x_high)
    slopes[reaches_out, 0] = np.minimum(slopes[reaches_out, 0], 0.0)
    slopes[reaches_out, 1] = np.maximum(slopes[reaches_out, 1], 0.0)
    return Bounds(
        low=float(output.low[0]) + 0.0,  # no negative zeros
        high=float(output.high[0]) + 0.0,
        attained_low=float(output.inner_low[0]) + 0.0,
        attained_high=float(output.inner_high[0]) + 0.0,
        slopes=slopes + 0.0,
        where_low=np.clip(output.at_low[0], *asked.T),
        where_high=np.clip(output.at_high[0], *asked.T),
        n_boxes=n_output + n_slopes,
        converged=converged,
    )


def model_bounds(
    model: Model, box: np.ndarray | None = None, *, tolerance: float = 0.01, max_boxes: int = 20000
) -> ModelBounds:
    """Proved range of a model over a box, region by region.

    Parameters
    ----------
    model : Model
    box : (n_input, 2) array-like, optional
        As for `network_bounds`; the model's domain if not given.
    tolerance, max_boxes
        As for `network_bounds`, for each region.

    Raises
    ------
    InputError
        As `network_bounds`.
    """
    regions = [
        None if part is None else network_bounds(network, part, tolerance=tolerance, max_boxes=max_boxes)
        for network, part in zip(model.networks, _parts(model, box), strict=True)
    ]
    met = [found for found in regions if found is not None]
    return ModelBounds(min(found.low for found in met), max(found.high for found in met), tuple(regions))


def check_range(
    model: Model, low: float, high: float, box: np.ndarray | None = None, *, max_boxes: int = 20000
) -> RangeCheck:
    """Prove that a model stays in [low, high] anywhere in a box, or find points where it does not.

    Parameters
    ----------
    model : Model
    low, high : float
        In the unit of the output; may be infinite.
    box : (n_input, 2) array-like, optional
        As for `network_bounds`; the model's domain if not given.
    max_boxes : int, default=20000
        Maximum number of sub-boxes, for each region.

    Raises
    ------
    InputError
        As `network_bounds`, and if `low` exceeds `high` or one of them is NaN.
    """
    if not low <= high:
        raise InputError(f"range [{low}, {high}]: must be two numbers, the first not above the second")
    _check_effort(0.0, max_boxes)
    leaving: list[Leaving] = []
    open_regions: list[str] = []
    proved = [np.inf, -np.inf]
    for k, part in enumerate(_parts(model, box)):
        if part is None:
            continue
        network = model.networks[k]
        found, _, kept = _output_range(network, _clamped(network, part), lambda *_: (low, high), max_boxes)
        proved = [min(proved[0], float(found.low[0])), max(proved[1], float(found.high[0]))]
        if kept:
            continue
        name = model.region_names()[k]
        below = low - found.inner_low[0] >= found.inner_high[0] - high
        point = np.clip((found.at_low if below else found.at_high)[0], *part.T)
        value = float(model.predict(point[None])[0])
        if low <= value <= high:
            open_regions.append(name)
        else:
            leaving.append(Leaving(name, point, value))
    holds = False if leaving else None if open_regions else True
    answer = RangeCheck(holds, proved[0], proved[1], (low, high), tuple(leaving), tuple(open_regions), max_boxes, "")
    return answer._replace(sentence=range_sentence(model, answer))


def range_sentence(model: Model, answer: RangeCheck) -> str:
    """Whether a model stays in a range, in words; numbers are taken to be in the model's units."""

    def span(ends: tuple[float, float]) -> str:
        return f"[{ends[0]:.6g}, {ends[1]:.6g}]" + (f" {model.output.unit}" if model.output.unit else "")

    name, asked, proved = model.output.name, span(answer.asked), span((answer.low, answer.high))
    if answer.leaving:
        points = []
        for found in answer.leaving:
            at = ", ".join(
                f"{variable.name} = {value:.6g} {variable.unit}".rstrip()
                for variable, value in zip(model.inputs, found.point, strict=True)
            )
            points.append(f"{found.value:.6g} {model.output.unit}".rstrip() + f" at {at} ({found.region})")
        return f"{name} leaves {asked}: it is {'; '.join(points)}"
    if answer.undecided:
        return (
            f"{name}: not decided with {answer.max_boxes} boxes per region whether it stays in {asked}; it is proved to stay "
            f"in {proved}, and no point outside was found; open: {'; '.join(answer.undecided)}"
        )
    return f"{name} cannot leave {asked}: it is proved to stay in {proved} for all inputs of the box, and may use less of it"


def _checked_box(box: np.ndarray, names: list[str]) -> np.ndarray:
    try:
        box = np.array(box, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"box = {box!r}: must hold low and high of each of the {len(names)} inputs") from error
    if box.shape != (len(names), 2):
        raise InputError(f"box has shape {box.shape}; it must be ({len(names)}, 2): low and high of each input")
    for name, (low, high) in zip(names, box.tolist(), strict=True):
        # An infinite end is allowed, a box without any finite number is not.
        if not low <= high or low == np.inf or high == -np.inf:
            raise InputError(f"box of {name} = [{low}, {high}]: must be two numbers, the first not above the second")
    return box


def _check_effort(tolerance: float, max_boxes: int) -> None:
    if not tolerance >= 0.0:
        raise InputError(f"tolerance = {tolerance!r}: must be at least 0")
    if not isinstance(max_boxes, int | np.integer) or max_boxes < 1:
        raise InputError(f"max_boxes = {max_boxes!r}: must be a whole number, at least 1")


def _parts(model: Model, box: np.ndarray | None) -> list[np.ndarray | None]:
    """What the box has in common with each region; None if nothing."""
    box = _checked_box(model.domain() if box is None else box, [variable.name for variable in model.inputs])
    parts: list[np.ndarray | None] = []
    for low, high in (region.T for region in model.region_boxes()):
        # A region is open below: its first number is the one after the edge.
        part = np.column_stack([np.maximum(box[:, 0], np.nextafter(low, np.inf)), np.minimum(box[:, 1], high)])
        parts.append(part if np.all(part[:, 0] <= part[:, 1]) else None)
    return parts


def _clamped(network: Network, box: np.ndarray) -> np.ndarray:
    """The box as the network sees it, in the order of operations of `evaluate`."""
    low, high = (np.reshape(end, (-1, 1)) for end in (network.x_low, network.x_high))
    return np.minimum(np.maximum(box, low), high)


def _output_range(network: Network, inside: np.ndarray, goal: Goal, max_boxes: int) -> tuple[Ends, int, bool]:
    """Search for the range of the clamped output; points have all inputs."""
    used = used_slots(network)[0]
    table = pack([network])

    def evaluated(points: np.ndarray) -> np.ndarray:
        X = np.tile(inside[:, 0], (points.shape[1], 1))
        X[:, used] = points.T
        return evaluate_rows(table, EVERYWHERE, X)

    def enclose(low: np.ndarray, high: np.ndarray) -> Ends:
        form = enclose_output(network, low, high)
        (least, e_least), (most, e_most) = form.lower(), form.upper()
        # An infinite bound may stand for NaN, which no clamp mends.
        bounds = [np.where(np.isinf(end), end, np.clip(end, network.y_low, network.y_high)) for end in (least, most)]
        one, other = _point(low, high, e_least), _point(low, high, e_most)
        y, z = evaluated(one), evaluated(other)
        # Where the error is large, the polynomial may mistake one end for the other.
        found = np.fmin(y, z), np.fmax(y, z)
        at = np.where(found[0] == z, other, one), np.where(found[1] == y, one, other)
        parts = *bounds, *_known(*found), *at
        return Ends(*(part[None] for part in parts))

    ends, n_boxes, converged = search(enclose, inside[used], goal, max_boxes)
    points = np.tile(inside[:, 0], (2, 1, 1))
    points[:, :, used] = ends.at_low, ends.at_high
    return ends._replace(at_low=points[0], at_high=points[1]), n_boxes, converged


def _slope_ranges(network: Network, inside: np.ndarray, tolerance: float, max_boxes: int) -> tuple[np.ndarray, int]:
    """Ranges of all slopes (n_input, 2), and how many boxes they took."""
    used = used_slots(network)[0]
    slopes = np.zeros((network.n_inputs, 2))
    if not used:
        return slopes, 0

    def enclose(low: np.ndarray, high: np.ndarray) -> Ends:
        rows = []
        for form in enclose_slopes(network, low, high):
            (least, e_least), (most, e_most) = form.lower(), form.upper()
            inner = _known(form.polynomial(e_least) + form.error, form.polynomial(e_most) - form.error)
            rows.append((least, most, *inner, _point(low, high, e_least), _point(low, high, e_most)))
        return Ends(*(np.array(part) for part in zip(*rows, strict=True)))

    ends, n_boxes, _ = search(enclose, inside[used], close_to_found(tolerance), max_boxes)
    slopes[used] = np.column_stack([ends.low, ends.high])
    return slopes, n_boxes


def _known(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values found; where they are NaN, nothing is."""
    return np.where(np.isnan(low), np.inf, low), np.where(np.isnan(high), -np.inf, high)


def _point(low: np.ndarray, high: np.ndarray, e: np.ndarray) -> np.ndarray:
    return np.clip(0.5 * low + 0.5 * high + 0.5 * (high - low) * e, low, high)
