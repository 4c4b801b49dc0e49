"""Back-propagation: the loss of a perceptron with one hidden layer, its exact gradient, and two ways to minimize it.

Thesis sections 3.2 and 4.3. A sigmoid is g(h) = 1 / (1 + exp(-2 beta h)).
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import OptimizeResult, minimize

from polydraulic.errors import InputError

MARGIN = 0.05  # a sigmoid output runs from here to 1 - here over the training data, and need not saturate
_PATIENCE = 100  # iterations over which the loss has to fall
_PERFECT = 1e-20  # half a squared error so small that only rounding is left
_MEMORY = 60  # updates that the quasi-Newton method keeps; about as many as a network of 15 units has weights
_BLOCK = 4096  # rows whose activations stay in the cache


class Task(NamedTuple):
    """All that the loss depends on, besides the weights."""

    inputs: np.ndarray  # (n_row, n_input + 1) scaled to 0..1, then a column of ones for the bias
    target: np.ndarray  # (n_row,) scaled to 0..1
    share: np.ndarray  # (n_row,) weights of the rows, with sum 1
    hidden_units: int
    beta: float
    weight_cost: float
    zero_error_radius: float
    sigmoid: bool


class Trained(NamedTuple):
    """Weights in one vector, and the loss at the start and after each iteration."""

    weights: np.ndarray
    history: list[float]


def loss_and_gradient(weights: np.ndarray, task: Task) -> tuple[float, np.ndarray]:
    """Loss E and its exact gradient, by back-propagation over blocks of rows.

    Parameters
    ----------
    weights : (n_weight,) array
        Hidden layer unit by unit, each with its bias last; then the output, with its bias last.
    task : Task
    """
    beta = task.beta
    hidden, output = layers(weights, task)
    # The penalty is on connections; biases stand in the last column and place.
    penalty = 0.5 * task.weight_cost * float(np.sum(hidden[:, :-1] ** 2) + np.sum(output[:-1] ** 2))
    gradient = task.weight_cost * weights
    d_hidden, d_output = layers(gradient, task)  # views: filling them fills the gradient
    d_hidden[:, -1] = 0.0
    d_output[-1] = 0.0
    loss = 0.0
    for start in range(0, len(task.target), _BLOCK):
        rows = slice(start, start + _BLOCK)
        inputs, share = task.inputs[rows], task.share[rows]
        wave = np.tanh(inputs @ (beta * hidden.T))  # g(h) = (1 + tanh(beta h)) / 2
        active = 0.5 + 0.5 * wave
        h = active @ output[:-1] + output[-1]
        predicted, slope = h, np.ones_like(h)
        if task.sigmoid:
            out = 0.5 + 0.5 * np.tanh(beta * h)
            predicted = (out - MARGIN) / (1.0 - 2.0 * MARGIN)
            slope = 2.0 * beta / (1.0 - 2.0 * MARGIN) * out * (1.0 - out)
        error = predicted - task.target[rows]
        error -= np.clip(error, -task.zero_error_radius, task.zero_error_radius)
        loss += 0.5 * float(share @ (error * error))
        delta = share * error * slope
        d_output[:-1] += delta @ active
        d_output[-1] += delta.sum()
        d_wave = (1.0 - wave * wave) * delta[:, None]
        d_hidden += (0.5 * beta * output[:-1, None]) * (d_wave.T @ inputs)
    return loss + penalty, gradient


def starting_weights(random: np.random.RandomState, task: Task, varies: np.ndarray) -> np.ndarray:
    """Random weights with which every hidden unit turns somewhere inside the box of inputs.

    Directions are random, steepness grows with the number of units as one over the width that each has to cover
    (Nguyen and Widrow, 1990); with small weights all units would start alike.
    """
    n_unit, n_input = task.hidden_units, len(varies)
    direction = random.normal(size=(n_unit, n_input))
    direction /= np.sqrt(np.sum(direction**2, axis=1, keepdims=True))
    slope = 1.4 / task.beta * n_unit ** (1.0 / n_input) * direction * varies
    turn = random.uniform(size=(n_unit, n_input))
    hidden = np.column_stack([slope, -np.sum(slope * turn, axis=1)])
    output = random.uniform(-0.25, 0.25, size=n_unit + 1) / task.beta
    return np.concatenate([hidden.ravel(), output])


def quasi_newton(start: np.ndarray, task: Task, max_iter: int, tol: float) -> Trained:
    """Minimize the loss by L-BFGS."""
    history = [loss_and_gradient(start, task)[0]]

    def watch(intermediate_result: OptimizeResult) -> None:
        history.append(float(intermediate_result.fun))
        if _settled(history, tol):
            raise StopIteration

    # SciPy measures progress against 1, not against the loss: its own rules are off, `watch` ends the search.
    options = {"maxiter": max_iter, "maxfun": 20 * max_iter, "maxcor": _MEMORY, "maxls": 40, "ftol": 0.0, "gtol": 0.0}
    found = minimize(
        loss_and_gradient, start, args=(task,), jac=True, method="L-BFGS-B", callback=watch, options=options
    )
    return Trained(found.x, history)


def descend(start: np.ndarray, task: Task, eta: float, momentum: float, max_iter: int, tol: float) -> Trained:
    """Minimize the loss by gradient descent over all rows at once.

    Raises
    ------
    InputError
        If the loss grows without bound.
    """
    weights, step = start, np.zeros_like(start)
    loss, gradient = loss_and_gradient(weights, task)
    history = [loss]
    while len(history) <= max_iter and not _settled(history, tol):
        step = momentum * step - eta * gradient
        weights = weights + step
        with np.errstate(over="ignore", invalid="ignore"):
            loss, gradient = loss_and_gradient(weights, task)
        if not np.isfinite(loss):
            raise InputError(f"eta = {eta:g}: the loss grows without bound, choose a smaller one")
        history.append(loss)
    return Trained(weights, history)


def layers(weights: np.ndarray, task: Task) -> tuple[np.ndarray, np.ndarray]:
    """Views of the hidden layer (n_unit, n_input + 1) and the output (n_unit + 1,), biases last."""
    size = task.hidden_units * task.inputs.shape[1]
    return weights[:size].reshape(task.hidden_units, -1), weights[size:]


def _settled(history: list[float], tol: float) -> bool:
    """Whether the loss has stopped falling, or there is nothing left to learn."""
    if history[-1] <= _PERFECT:
        return True
    if len(history) <= _PATIENCE:
        return False
    return min(history[-_PATIENCE:]) >= (1.0 - tol) * history[-1 - _PATIENCE]
