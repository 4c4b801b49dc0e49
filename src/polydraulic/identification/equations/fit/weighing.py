"""Loops over the rows of a fit, compiled: what is left of measured flows with its slopes, and sums of squares over all rows.

A curve that is linear between knots depends in a row on two of them, so that most slopes are zero: sums are made of those that are not.
"""

from math import sqrt

import numpy as np

from polydraulic._kernel import driver

HUBER = 2.0  # standard deviations, beyond which a row counts less
LEAST_DROP = 3.0  # standard deviations of the pressure's noise, below which a drop says nothing of the conductance
LEAST_FLOW = 5.0  # standard deviations of its noise, from which on a flow tells the drop that it takes


@driver
def weigh(
    q: np.ndarray, by_inlet: np.ndarray, by_bypass: np.ndarray, by_pressure: np.ndarray, by_pump: np.ndarray, left: np.ndarray, share: np.ndarray,
    steep: np.ndarray, first: np.ndarray, mean: np.ndarray, measured: np.ndarray, counts: np.ndarray, noise: np.ndarray, off: np.ndarray,
    slopes: np.ndarray,
) -> None:  # fmt: skip
    """What is left of the mean flows of windows in standard deviations, and the slopes of that over curves and numbers of the pump.

    Parameters
    ----------
    q : (n_row, n) array, m3/s
        Flows of the model; the rows of a window follow each other.
    by_inlet, by_bypass, by_pressure : (n_row, n, n) array
        Their slopes, as of `CircuitSlopes`.
    by_pump : (n_row, n, n_pump) array
        Over numbers of the pump.
    left, share : (n_row, n) array
        Where travels lie among the knots of each valve.
    steep : (n_row, n, 2) array
        Slopes of inlet and bypass over travel there.
    first : (n + 1,) array of int
        Place of the first number of each valve, and of those of the pump.
    mean : (n_long,) array
        Weights of the rows of a window.
    measured, counts : (n_window, n) array
        Measured mean flows, and which of them count.
    noise : (3, n) array
        Standard deviations of travel, pressure and flow.
    off : (n, n_window) array
        Written.
    slopes : (n, n_window, n_number) array
        Written; zero before.
    """
    n, long = q.shape[1], len(mean)
    pump = first[n]
    squares = 0.0
    for at in range(long):
        squares += mean[at] * mean[at]
    for i in range(n):
        for w in range(measured.shape[0]):
            off[i, w] = 0.0
            if not counts[w, i]:
                continue
            flow, variance = -measured[w, i], noise[2, i] * noise[2, i]
            for at in range(long):
                flow += mean[at] * q[w * long + at, i]
            for j in range(n):
                begin = first[j]
                knots = (first[j + 1] - begin) // 3
                by_travel, by_port = 0.0, 0.0
                for at in range(long):
                    row = w * long + at
                    inlet, bypass = mean[at] * by_inlet[row, i, j], mean[at] * by_bypass[row, i, j]
                    travel = inlet * steep[row, j, 0] + bypass * steep[row, j, 1]
                    by_travel += travel
                    by_port += mean[at] * by_pressure[row, i, j]
                    right = share[row, j]
                    k = begin + left[row, j]
                    slopes[i, w, k] += inlet * (1.0 - right)
                    slopes[i, w, k + 1] += inlet * right
                    slopes[i, w, k + knots] += bypass * (1.0 - right)
                    slopes[i, w, k + knots + 1] += bypass * right
                    slopes[i, w, k + 2 * knots] -= travel * (1.0 - right)
                    slopes[i, w, k + 2 * knots + 1] -= travel * right
                variance += (by_travel * noise[0, j]) ** 2 + squares * (by_port * noise[1, j]) ** 2
            for k in range(by_pump.shape[2]):
                for at in range(long):
                    slopes[i, w, pump + k] += mean[at] * by_pump[w * long + at, i, k]
            weight = 1.0 / sqrt(variance)
            off[i, w] = weight * flow
            for k in range(slopes.shape[2]):
                slopes[i, w, k] *= weight


@driver
def add_squares(
    off: np.ndarray, slopes: np.ndarray, gradient: np.ndarray, curvature: np.ndarray, used: np.ndarray
) -> float:
    """Half the squares of rows, those far off counting less, with their slopes, added to gradient and lower triangle of the curvature.

    Parameters
    ----------
    off : (n_row,) array
        In standard deviations.
    slopes : (n_row, n_number) array
    gradient : (n_number,) array
    curvature : (n_number, n_number) array
    used : (n_number,) array of int
        Room.
    """
    loss = 0.0
    for row in range(len(off)):
        size = abs(off[row])
        robust = 1.0
        if size <= HUBER:
            loss += 0.5 * size * size
        else:
            loss += HUBER * (size - 0.5 * HUBER)
            robust = HUBER / size
        count = 0
        for k in range(slopes.shape[1]):
            if slopes[row, k] != 0.0:
                used[count] = k
                count += 1
        for a in range(count):
            k = used[a]
            pull = robust * slopes[row, k]
            gradient[k] += pull * off[row]
            for b in range(a + 1):
                curvature[k, used[b]] += pull * slopes[row, used[b]]
    return loss


@driver
def over_knots(left: np.ndarray, share: np.ndarray, factor: np.ndarray, found: np.ndarray) -> None:
    """Sums of the rows of each window over the values at knots, (n_window, m), to what `found` holds.

    `left` and `share`, (n_window, n_long), say where travels lie among the knots, and `factor` of the same shape what a row counts.
    """
    for w in range(factor.shape[0]):
        for at in range(factor.shape[1]):
            k = left[w, at]
            found[w, k] += factor[w, at] * (1.0 - share[w, at])
            found[w, k + 1] += factor[w, at] * share[w, at]


@driver
def linearise_outlet(
    left: np.ndarray, share: np.ndarray, drop: np.ndarray, rate: np.ndarray, q_out: np.ndarray, mean: np.ndarray, values: np.ndarray, steep: np.ndarray,
    lead: float, p_return: float, noise: np.ndarray, root: np.ndarray, target: np.ndarray, sd: np.ndarray, by_lead: np.ndarray,
) -> None:  # fmt: skip
    """Flows out as conductances times factors, around a curve and a lead.

    Parameters
    ----------
    left, share, drop, rate : (n_window, n_long) array
        Where travels lie among the knots, pressure drops in Pa as if nothing held the return line, and how fast these change in Pa/s.
    q_out : (n_window,) array, m3/s
    mean : (n_long,) array
        Weights of the rows of a window.
    values, steep : array
        Conductances at the knots, and slopes between these.
    lead, p_return : float
        In s and Pa.
    noise : (3,) array
        Standard deviations of travel, pressure and flow.
    root : (n_window, n_long) array, Pa^0.5
        Written, as the others: the factors.
    target, sd, by_lead : (n_window,) array
    """
    long = len(mean)
    squares = 0.0
    for at in range(long):
        squares += mean[at] * mean[at]
    least = sqrt(LEAST_DROP * noise[1])
    for w in range(drop.shape[0]):
        k, widest, slope, mean_root, mean_drop, mean_rate = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for at in range(long):
            i, right = left[w, at], share[w, at]
            here = values[i] * (1.0 - right) + values[i + 1] * right
            own = drop[w, at] + lead * rate[w, at] - p_return
            root[w, at] = sqrt(max(own, 1.0))
            k += here / long
            widest = max(widest, here)
            slope += steep[i] / long
            mean_root += mean[at] * root[w, at]
            mean_drop += mean[at] * own
            mean_rate += mean[at] * rate[w, at]
        # the mean flow of a window is no flow at its mean travel
        flows = q_out[w] > LEAST_FLOW * noise[2] and widest > 1e-9 and long == 1
        taken = max(q_out[w] / max(k, 1e-12), least) if flows else mean_root
        by_drop = 0.5 * k / taken
        sd[w] = sqrt(noise[2] ** 2 + ((slope * taken * noise[0]) ** 2 + (by_drop * noise[1]) ** 2) * squares)
        of_pressure, of_flow = noise[1] / (taken * taken), 2.0 * noise[2] / max(q_out[w], 1e-12)
        by_lead[w] = by_drop * mean_rate
        if flows and of_pressure > of_flow:
            target[w] = k * taken - by_drop * (mean_drop - taken * taken)
            for at in range(long):
                root[w, at] = taken
        else:
            target[w] = q_out[w] * (1.0 + (0.125 if flows else 0.0) * of_pressure * of_pressure)
        target[w] += by_lead[w] * lead
