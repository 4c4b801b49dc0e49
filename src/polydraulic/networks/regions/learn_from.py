"""Learning from a function instead of a table: samples where the error asks for them, until a tolerance is reached.

A region takes the points that are known in it, draws others, on faces and in corners too, fits a network, and hunts for its largest error
on a grid, on all known points and around the worst of them. If it is nearly good enough, the worst points join the rows and it fits again; one
that looks good is looked at once more. The worst region is cut in two, until all are good enough or the budget is used.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import qmc
from sklearn.base import clone
from sklearn.utils import check_random_state

from polydraulic.errors import InputError
from polydraulic.networks.growth.far_values import far_values_untold
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.fitted import checked_box
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import checked_edges, grid, region_boxes
from polydraulic.networks.regions.split_search import best_cut
from polydraulic.networks.regions.tree import Halves, Leaf, box_halves, grow_tree
from polydraulic.progress import Progress, quiet

_ON_FACES = 0.25  # of a region's points
_MARGIN = 0.8  # a region is good enough at this share of the tolerance: a finer grid finds a little more
_FRESH = 0.25  # of a region's points are drawn at least: a cut has made new faces
_GRID, _CONFIRM = 600, 1500  # points on which errors are sought; and so many more where none was found
_WORST, _AROUND, _ROUNDS = 8, 16, 3  # points around which they are sought further, how many there, how often
_HOPELESS = 4.0  # times the tolerance: a region with a larger error is cut without looking further
_HUNTED = 0.25  # of a region's rows: so many of the worst points join them for a second fit
_ON_BOUND = 0.01  # of the points that share the least or the largest value: it is a bound
_SEARCHED = 0.8  # of the regions, before larger networks take over
_NEAR_BORDER = 0.02  # of a region's points that a cut leaves on each side


class Learnt(NamedTuple):
    """What `learn_from` found.

    Attributes
    ----------
    model : Model
    largest : float
        Largest error that was found, in units of the output.
    where : (n_input,) array
        Where it was found.
    converged : bool
        Whether it is within the tolerance.
    n_evaluations : int
        Points at which the function was asked.
    """

    model: Model
    largest: float
    where: np.ndarray
    converged: bool
    n_evaluations: int


class _Points(NamedTuple):
    """Points, and the function's values there."""

    X: np.ndarray
    y: np.ndarray

    def and_also(self, other: "_Points") -> "_Points":
        return _Points(np.vstack([self.X, other.X]), np.append(self.y, other.y))

    def at(self, chosen: np.ndarray) -> "_Points":
        return _Points(self.X[chosen], self.y[chosen])

    def inside(self, cell: np.ndarray) -> "_Points":
        return self.at(np.all((cell[:, 0] <= self.X) & (cell[:, 1] >= self.X), axis=1))

    def errors(self, model: Model) -> np.ndarray:
        found: np.ndarray = np.abs(model.predict(self.X) - self.y)
        return found


class _Region(NamedTuple):
    """A fitted region: estimator, the points it learnt from, all that are known, the largest error on these with its place."""

    estimator: AbductiveRegressor
    rows: _Points
    known: _Points
    error: float
    where: np.ndarray


def learn_from(
    function: Callable[[np.ndarray], np.ndarray],
    box: Sequence[tuple[float, float]],
    *,
    tolerance: float,
    edges: Mapping[Any, Sequence[float]] | None = None,
    budget: int = 1_000_000,
    max_regions: int = 64,
    rows: int = 1500,
    estimator: AbductiveRegressor | None = None,
    finer: AbductiveRegressor | None = None,
    finer_rows: int | None = None,
    inputs: Sequence[Variable] | None = None,
    output: Variable | None = None,
    random_state: Any = 0,
    progress: Progress = quiet,
) -> Learnt:
    """Networks by region that follow a function to a tolerance.

    Parameters
    ----------
    function : function of an (n_row, n_input) array
        Gives (n_row,) finite outputs.
    box : sequence of (low, high), one per input
    tolerance : float
        Largest error allowed, in units of the output.
    edges : mapping from input (index, or name of a given input) to rising edges, optional
        Borders that are known: the search starts from the cells of this grid.
    budget : int
        Points at which the function may be asked.
    max_regions : int
        Maximum number of regions.
    rows : int
        Points from which a region learns.
    estimator : AbductiveRegressor, optional
        Settings of the networks; if not given, three layers, and bounds where many points share the least or the largest value. Its `domain` is
        replaced by that of each region.
    finer : AbductiveRegressor, optional
        Settings of larger networks, which a search for places to cut does not need: it ends at four fifths of the
        regions, all that are not good enough are fitted with these, and the worst of them cut further. The fits are not
        in the budget, further cuts are.
    finer_rows : int, optional
        Points from which a region learns then; `rows` if not given.
    inputs, output : Variable, optional
        Names and units for the model.
    random_state : int, RandomState or None
        Places the points.
    progress : Progress, optional
        Told the largest error of each region that is to be cut, and how much of the budget is spent.

    Returns
    -------
    Learnt

    Raises
    ------
    InputError
        A box, tolerance or budget that makes no sense; a function that gives another shape or values that are not finite.

    Examples
    --------
    >>> found = learn_from(lambda X: np.abs(X[:, 0]) * X[:, 1], [(-1, 1), (0, 2)], tolerance=1e-3)
    >>> found.converged, len(found.model.networks)
    (True, 2)
    """
    limits = np.column_stack(checked_box(box, len(box)))
    _check(limits, tolerance, max_regions, rows)
    base = AbductiveRegressor(max_layers=3) if estimator is None else estimator
    random = check_random_state(random_state)
    asked, grid_points = 0, _grid(len(limits))
    # of one region at most
    price = rows + 2 ** len(limits) + len(grid_points) + _CONFIRM + 2 * _ROUNDS * _WORST * _AROUND

    def ask(X: np.ndarray) -> _Points:
        nonlocal asked
        asked += len(X)
        return _Points(X, _asked(function, X))

    def leaf(
        cell: np.ndarray,
        known: _Points,
        settings: AbductiveRegressor = base,
        rows: int = rows,
        patience: float = _HOPELESS,
    ) -> Leaf:
        seed = int(random.randint(2**31 - 1))
        chance, known = np.random.default_rng(seed), known.inside(cell)
        fresh = max(round(_FRESH * rows), rows - len(known.y))
        drawn = ask(_points(cell, fresh, seed))
        learnt = drawn.and_also(known.at(chance.permutation(len(known.y))[: rows - fresh]))
        known = known.and_also(drawn).and_also(ask(_in_box(cell, grid_points)))
        settings = clone(settings).set_params(domain=list(map(tuple, cell.tolist())), calibration=0.0)
        if estimator is None:
            settings.set_params(output_bounds=_bounds(known.y))

        def examined(learnt: _Points, known: _Points) -> _Region:
            with far_values_untold():
                fitted = clone(settings).fit(*learnt)
            model = fitted.to_model()
            error = known.errors(model)
            if error.max() <= patience * tolerance:
                known = _around_worst(ask, model, known, cell, chance)
                error = known.errors(model)
            if error.max() <= _MARGIN * tolerance:
                known = known.and_also(ask(_points(cell, _CONFIRM - 2 ** len(cell), seed + 1)))
                error = known.errors(model)
            return _Region(fitted, learnt, known, float(error.max()), known.X[np.argmax(error)])

        region = examined(learnt, known)
        if _MARGIN * tolerance < region.error <= patience * tolerance:
            worst = np.argsort(-region.known.errors(region.estimator.to_model()), kind="stable")
            again = examined(learnt.and_also(region.known.at(worst[: round(_HUNTED * rows)])), region.known)
            region = min(region, again, key=lambda r: r.error)._replace(known=again.known)
        return Leaf(cell, region, region.error, region.error <= _MARGIN * tolerance)

    def cut(parent: Leaf, settings: AbductiveRegressor = base, rows: int = rows) -> Halves | None:
        region = parent.fitted
        progress(f"largest error {region.error:.3g}", asked, budget)
        if asked + 2 * price > budget:
            return None
        min_rows = max(1, round(_NEAR_BORDER * rows))
        found = best_cut(region.rows.X, region.rows.y[:, None], np.ones(len(region.rows.y)), min_rows)
        if found is None:
            return None
        below, above = box_halves(parent.box, found.axis, found.at)
        above[found.axis, 0] = np.nextafter(found.at, np.inf)  # the border itself belongs below
        return Halves(
            found.axis, found.at, leaf(below, region.known, settings, rows), leaf(above, region.known, settings, rows)
        )

    names = [variable.name for variable in inputs] if inputs else [f"x{i}" for i in range(len(limits))]
    known = grid(checked_edges(edges or {}, names))
    nothing = _Points(np.zeros((0, len(limits))), np.zeros(0))
    start = [leaf(_cell(region, limits), nothing) for region in region_boxes(known, len(limits)).values()]
    searched = max_regions if finer is None else max(1, round(_SEARCHED * max_regions))
    partition, leaves = grow_tree(known, start, cut, searched)
    if finer is not None:
        settings, n = finer, finer_rows or rows
        better = [
            found if found.settled else leaf(found.box, found.fitted.known, settings, n, np.inf) for found in leaves
        ]
        leaves = [min(pair, key=lambda found: found.cost) for pair in zip(leaves, better, strict=True)]
        partition, leaves = grow_tree(partition, leaves, lambda parent: cut(parent, settings, n), max_regions)
    # what was to be cut, and is not, has not been looked at closely
    for k, found in enumerate(leaves):
        if found.cost > _HOPELESS * tolerance and asked + price <= budget:
            leaves[k] = min(found, leaf(found.box, found.fitted.known, patience=np.inf), key=lambda one: one.cost)
    regions = [found.fitted for found in leaves]
    worst = max(regions, key=lambda region: region.error)
    models = [region.estimator.to_model(inputs, output) for region in regions]
    training = {name: value for name, value in models[0].training.items() if name not in ("pse", "fse")}
    training |= {"tolerance": tolerance, "largest_error": worst.error, "n_evaluations": asked}
    networks = tuple(model.networks[0] for model in models)
    model = Model(models[0].inputs, models[0].output, networks, partition, training)
    return Learnt(model, worst.error, worst.where, worst.error <= tolerance, asked)


def _cell(region: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """A region inside the box; the border itself belongs below.

    Raises
    ------
    InputError
        If an edge lies outside the box.
    """
    cell = np.column_stack(
        [np.maximum(np.nextafter(region[:, 0], np.inf), limits[:, 0]), np.minimum(region[:, 1], limits[:, 1])]
    )
    if not np.all(cell[:, 0] < cell[:, 1]):
        raise InputError(f"edges: the region {region.tolist()} has no part in the box {limits.tolist()}")
    return cell


def _asked(function: Callable[[np.ndarray], np.ndarray], X: np.ndarray) -> np.ndarray:
    y = np.asarray(function(X), dtype=np.float64)
    if y.shape != (len(X),):
        raise InputError(f"the function gives shape {y.shape} for {len(X)} rows; it must give ({len(X)},)")
    if not np.all(np.isfinite(y)):
        row = int(np.argmin(np.isfinite(y)))
        raise InputError(f"the function gives {y[row]} at {X[row].tolist()}; it must be finite in the whole box")
    return y


def _points(cell: np.ndarray, n: int, seed: int) -> np.ndarray:
    """Points of a box: well spread, a share of them moved onto faces, and the corners."""
    n_input = len(cell)
    unit = qmc.Sobol(n_input, rng=seed).random(2 ** int(np.ceil(np.log2(n))))[:n]
    random = np.random.default_rng(seed)
    faces = unit[: round(_ON_FACES * n)]
    moved = random.random(faces.shape) < random.random((len(faces), 1))  # faces of faces, too
    moved[np.arange(len(faces)), random.integers(0, n_input, len(faces))] = True
    faces[moved] = np.round(faces[moved])
    return _in_box(cell, np.vstack([unit, list(product((0.0, 1.0), repeat=n_input))]))


def _grid(n_input: int) -> np.ndarray:
    """A grid of the unit cube, its faces included."""
    side = max(3, round(_GRID ** (1.0 / n_input)))
    return np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, side)] * n_input), axis=-1).reshape(-1, n_input)


def _around_worst(
    ask: Callable[[np.ndarray], _Points], model: Model, known: _Points, cell: np.ndarray, random: np.random.Generator
) -> _Points:
    """Known points, and others around those with the largest errors, again and again, nearer each time."""
    low, high = cell.T
    reach, error = (high - low) / max(3.0, _GRID ** (1.0 / len(cell))), known.errors(model)
    for _ in range(_ROUNDS):
        worst = known.X[np.argsort(-error, kind="stable")[:_WORST]]
        steps = random.uniform(-reach, reach, size=(len(worst), _AROUND, len(cell)))
        around = ask(np.clip(worst[:, None] + steps, low, high).reshape(-1, len(cell)))
        known, error = known.and_also(around), np.append(error, around.errors(model))
        reach = 0.25 * reach
    return known


def _bounds(y: np.ndarray) -> tuple[float, float]:
    """Ends of the values where many points lie on them, and a tenth of the range beyond where they do not."""
    low, high = float(y.min()), float(y.max())
    beyond = 0.1 * (high - low)
    return (
        low if np.mean(y == low) >= _ON_BOUND else low - beyond,
        high if np.mean(y == high) >= _ON_BOUND else high + beyond,
    )


def _in_box(cell: np.ndarray, unit: np.ndarray) -> np.ndarray:
    """Points of the unit cube, stretched to a box and not beyond its ends."""
    low, high = cell.T
    return np.asarray(np.clip(low + (high - low) * unit, low, high))


def _check(limits: np.ndarray, tolerance: float, max_regions: int, rows: int) -> None:
    if not np.all(np.isfinite(limits)) or not np.all(limits[:, 0] < limits[:, 1]):
        raise InputError(f"box = {limits.tolist()}: must give finite (low, high) with low < high for each input")
    if not tolerance > 0.0:
        raise InputError(f"tolerance = {tolerance!r}: must be positive, in units of the output")
    for name, value in (("max_regions", max_regions), ("rows", rows)):
        if not isinstance(value, int | np.integer) or value < 1:
            raise InputError(f"{name} = {value!r}: must be a whole number, at least 1")
