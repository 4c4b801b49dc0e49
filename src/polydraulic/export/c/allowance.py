"""How far `float` code can be from the network in double precision, and the range that it cannot leave: proved, not sampled.

Forms of `proof.taylor` enclose exact and computed values of every slot, and the derivatives of nodes between them; `rounded` adds what the
operations of a node do, in the order of the code; `branch_and_bound` halves boxes until both are close to what some point needs.
"""

from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.c.network import input_limits, offset, output_limits
from polydraulic.export.c.rounded import Rounded, constant, given
from polydraulic.export.c.text import FLOAT, held_in, rounded_down
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import LINEAR, RAMP, SIGMOID
from polydraulic.networks.model.partition import Partition, region_boxes
from polydraulic.networks.model.table import Network, used_slots
from polydraulic.networks.proof.branch_and_bound import Ends, search
from polydraulic.networks.proof.taylor import Form, enclose_gains, enclose_slots, node_value
from polydraulic.progress import Progress

_BOXES = (500, 4000)  # for each region, at most: more for those that fewer do not do for
_ALL_BOXES = 20000  # for all regions of a model
_CLOSE = 0.1  # of what a point needs: what the proof may lie above it
# covers the rounding of the package's own double precision, which the same analysis bounds by 2^-29 of this
_UP = 1.0 + 2.0**-20


class Allowance(NamedTuple):
    """What is proved of the `float` code of one output, for inputs that are numbers and, where a processor flushes them, not subnormal.

    Attributes
    ----------
    error : float
        In the domain, the output is no further from that of the network, be it computed exactly or by the package. Outside of it,
        this is so for the input that is moved to the border. Infinite if nothing could be proved.
    low, high : float
        The output lies between them, wherever the inputs are.
    """

    error: float
    low: float
    high: float


def model_allowance(model: Model) -> Allowance:
    """Proved allowance of `float` code.

    Parameters
    ----------
    model : Model

    Raises
    ------
    InputError
        If a number of the model, or a value that it computes, does not fit into a float.
    """
    found = _allowance(model.networks, model.partition)
    if found is None:
        raise InputError(
            f"values of {model.output.name!r} exceed what a float can hold, 3.4e38: fit in other units, or export as double"
        )
    return found


def prove_allowances(models: Sequence[Model], progress: Progress) -> None:
    """Prove what `model_allowance` says of each model, once and for all who ask for it.

    Parameters
    ----------
    models : sequence of Model
    progress : Progress
        Told the output, and how many are done.

    Raises
    ------
    InputError
        As `model_allowance`.
    """
    for done, model in enumerate(models):
        progress(f"{model.output.name}: how far float can be off, {_ALL_BOXES} boxes at most", done, len(models))
        model_allowance(model)


def allowance_lines(models: Sequence[Model]) -> list[str]:
    """The same in words, one line for each model; numbers are rounded outward.

    Parameters
    ----------
    models : sequence of Model

    Raises
    ------
    InputError
        As `model_allowance`.
    """
    lines = []
    for model in models:
        error, low, high = model_allowance(model)
        unit = f" {model.output.unit}" if model.output.unit else ""
        if np.isfinite(error):
            ends = _outward(low, 7, ROUND_FLOOR), _outward(high, 7, ROUND_CEILING), _outward(error, 2, ROUND_CEILING)
            lines.append(
                "{}: in float from {} to {}{unit}, within {}{unit} of double".format(
                    model.output.name, *ends, unit=unit
                )
            )
        else:
            lines.append(f"{model.output.name}: no proved allowance in float: {_ALL_BOXES} boxes did not do")
    return lines


def _outward(value: float, digits: int, rounding: str) -> str:
    return str(float(Context(prec=digits, rounding=rounding).create_decimal_from_float(value)))


@lru_cache(maxsize=256)
def _allowance(networks: tuple[Network, ...], partition: Partition) -> Allowance | None:
    """None where a value overflows at a point that was looked at."""
    boxes = region_boxes(partition, networks[0].n_inputs)
    places = [(network, _floats(boxes[k])) for k, network in enumerate(networks)]
    regions = [_Region(network, box) for network, box in places if np.all(box[:, 0] <= box[:, 1])]
    # What any region needs, none has to stay below: a first look at all of them saves most of the work.
    ends = [_search(region, [], 1)[0] for region in regions]
    if np.isinf(np.max([one.inner_high[0] for one in ends])):
        return None
    waiting, left = set(range(len(regions))), _ALL_BOXES
    for most in _BOXES:
        for k in sorted(waiting, key=lambda k: -ends[k].high[0]):
            if left >= most:
                ends[k], n_boxes, converged = _search(regions[k], ends, most)
                left -= n_boxes
                waiting -= {k} if converged else set()
    error = max(region.clamped_error(float(one.high[0])) for region, one in zip(regions, ends, strict=True))
    return Allowance(error * _UP, min(float(one.low[1]) for one in ends), max(float(one.high[1]) for one in ends))


def _floats(box: np.ndarray) -> np.ndarray:
    """The floats of a region: the first one above its lower end, and the last one that is not above its upper end."""
    low = [float(np.nextafter(np.float32(rounded_down(end, FLOAT)), np.float32(np.inf))) for end in box[:, 0]]
    return np.column_stack([low, [rounded_down(end, FLOAT) for end in box[:, 1]]])


class _Region:
    """A network, and the inputs that reach it once they are in its domain.

    Attributes
    ----------
    network : Network
    box : (n_used, 2) array
        Of the inputs that `used_slots` names.
    off : list of float
        By input: how far what the code reads is from what the network reads; not zero where the domain holds no float.
    """

    def __init__(self, network: Network, floats: np.ndarray) -> None:
        domain = np.array(input_limits(network, FLOAT)).reshape(-1, 2)
        self.network, self.used = network, used_slots(network)[0]
        self.box = np.clip(floats, domain[:, :1], domain[:, 1:])[self.used]
        self.off = [
            0.0 if low <= at <= high else max(abs(at - low), abs(at - high))
            for at, low, high in zip(domain[:, 0].tolist(), network.x_low, network.x_high, strict=True)
        ]

    def clamped_error(self, error: float) -> float:
        """`error`, or less: outputs of both precisions lie between the bounds."""
        ends = [*output_limits(self.network, FLOAT), self.network.y_low, self.network.y_high]
        return min(error, max(ends) - min(ends)) if np.isfinite(error) else error

    def enclose(self, low: np.ndarray, high: np.ndarray) -> Ends:
        """Error and output over boxes; and at the corner of each that is furthest from the mean, which no proof can beat."""
        mean = np.array(self.network.x_mean)[self.used][:, None]
        corner = np.where(high - mean > mean - low, high, low)
        found = _errors(self.network, self.off, np.hstack([low, corner]), np.hstack([high, corner]))
        (error, error_there), (least, least_there), (most, most_there) = (np.split(part, 2) for part in found)
        nothing = np.zeros_like(error)
        return Ends(
            np.array([nothing, least]),
            np.array([error, most]),
            np.array([nothing, most_there]),
            np.array([error_there, least_there]),
            np.array([corner, corner]),
            np.array([corner, corner]),
        )


def _search(region: _Region, others: Sequence[Ends], max_boxes: int) -> tuple[Ends, int, bool]:
    """`search` for error and range over a region, as close as needed to what a point of it or of `others` needs."""
    known = np.array([[one.inner_low, one.inner_high] for one in others]).reshape(-1, 2, 2)

    def goal(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        low, high = np.min([low, *known[:, 0]], axis=0), np.max([high, *known[:, 1]], axis=0)
        allowed = _CLOSE * np.array([high[0], max(high[1] - low[1], high[0])])
        return low - allowed, high + allowed

    return search(region.enclose, region.box, goal, max_boxes)


def _errors(
    network: Network, off: list[float], low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Error (m,) of the output over m boxes of used inputs (n_used, m), and its range."""
    rows = {i: row for row, i in enumerate(used_slots(network)[0])}
    errors: dict[int, np.ndarray] = {}  # of each slot, and what its own operations add to it
    own: dict[int, np.ndarray] = {}
    bounds: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def ranges(slots: tuple[int, ...], values: dict[int, Form], exact: bool) -> dict[int, Rounded]:
        for slot in slots:
            if slot not in bounds:
                bounds[slot] = values[slot].lower()[0], values[slot].upper()[0]
        return {slot: Rounded(*bounds[slot], np.zeros_like(errors[slot]) if exact else errors[slot]) for slot in slots}

    def widen(slot: int, values: dict[int, Form], partials: list[Form]) -> np.ndarray:
        if slot < network.n_inputs:
            own[slot] = errors[slot] = _normalized(network, slot, off[slot], low[rows[slot]], high[rows[slot]]).error
            return errors[slot]
        node = network.nodes[slot - network.n_inputs]
        own[slot] = node_value(node, ranges(node.inputs, values, True)).error
        whole = node_value(node, ranges(node.inputs, values, False)).error
        # By the derivatives, which terms that cancel do not blow up; and by the operations alone.
        carried = sum(_size(part) * errors[source] for part, source in zip(partials, node.inputs, strict=True))
        errors[slot] = np.fmin((carried + own[slot]) * _UP, whole)
        return errors[slot]

    if network.nodes:
        values, partials = enclose_slots(network, low, high, widen)
        last = network.n_inputs + len(network.nodes) - 1
        if not _may_fuse(network):  # what a slot adds may reach the output on several ways that cancel
            reached = sum(_size(gain) * own[slot] for slot, gain in enclose_gains(network, partials, 1.0).items())
            errors[last] = np.fmin(errors[last], (reached + own[last]) * _UP)
        y = network.y_mean + network.y_scale * ranges((last,), values, False)[last]
    else:
        nothing = np.zeros(low.shape[1])
        y = Rounded(nothing, nothing, nothing) + network.y_mean
    return _bounded(network, y)


def _may_fuse(network: Network) -> bool:
    """Whether a compiler may add a slot that is a product without rounding it, where another node reads it rounded."""
    sums = [node for node in network.nodes if node.kind in (LINEAR, SIGMOID, RAMP)]
    return any(abs(held_in(c, FLOAT)) == 1.0 for node in sums for c in node.coef)


def _normalized(network: Network, slot: int, off: float, low: np.ndarray, high: np.ndarray) -> Rounded:
    """An input from `low` to `high`, off by `off`, as nodes read it."""
    mean, gain = network.x_mean[slot], 1.0 / network.x_scale[slot]
    first, rest = offset(mean, FLOAT)
    x = given(low, high, off) + constant(-first, 0.0 if rest else abs(mean - first))
    if rest:
        x = x + constant(-rest, abs(mean - first - rest))
    return x * constant(gain, abs(gain - held_in(gain, FLOAT)) + 2.0**-53 * gain)  # the exact network divides


def _bounded(network: Network, y: Rounded) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Error of the clamped output, and its range; whether code and network are clamped can differ near the bounds alone."""
    (low, high), error = output_limits(network, FLOAT), y.error
    moved = abs(low - network.y_low), abs(network.y_high - high)
    least, most = y.low - error, y.high + error
    clamped = np.maximum(error, np.where(least < max(low, network.y_low), moved[0], 0.0))
    clamped = np.maximum(clamped, np.where(most > min(high, network.y_high), moved[1], 0.0))
    clamped = np.where(most <= min(low, network.y_low), moved[0], clamped)
    clamped = np.where(least >= max(high, network.y_high), moved[1], clamped)
    fits = np.isfinite(error)  # else the value may be none, which no clamp mends
    return (
        np.where(fits, clamped, np.inf),
        np.where(fits, np.clip(y.low, low, high), -np.inf),
        np.where(fits, np.clip(y.high, low, high), np.inf),
    )


def _size(form: Form) -> np.ndarray:
    """Largest magnitude (m,)."""
    return np.maximum(np.abs(form.lower()[0]), np.abs(form.upper()[0]))
