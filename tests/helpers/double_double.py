"""Numbers of twice the machine's precision: unevaluated sums (high, low) of two floats, 106 bits."""

import numba

compiled = numba.njit(error_model="numpy", inline="never", cache=False)


@compiled
def two_sum(a, b):
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@compiled
def two_product(a, b):
    p = a * b
    c = 134217729.0 * a
    a1 = c - (c - a)
    c = 134217729.0 * b
    b1 = c - (c - b)
    a2, b2 = a - a1, b - b1
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


@compiled
def add(x, y):
    s, e = two_sum(x[0], y[0])
    t, f = two_sum(x[1], y[1])
    s, e = two_sum(s, e + t)
    return two_sum(s, e + f)


@compiled
def minus(x):
    return -x[0], -x[1]


@compiled
def times(x, y):
    p, e = two_product(x[0], y[0])
    return two_sum(p, e + (x[0] * y[1] + x[1] * y[0]))


@compiled
def divided(x, y):
    q = x[0] / y[0]
    r = add(x, minus(times(y, (q, 0.0))))
    q2 = r[0] / y[0]
    r = add(r, minus(times(y, (q2, 0.0))))
    s, e = two_sum(q, q2)
    return two_sum(s, e + r[0] / y[0])


@compiled
def root(x):
    if x[0] <= 0.0:
        return 0.0, 0.0
    a = x[0] ** 0.5
    r = add(x, minus(two_product(a, a)))
    b = r[0] / (2.0 * a)
    s = two_sum(a, b)
    r = add(x, minus(times(s, s)))
    return add(s, (r[0] / (2.0 * a), 0.0))


@compiled
def above(x, y):
    return x[0] > y[0] or (x[0] == y[0] and x[1] > y[1])
