"""Elementary functions for kernels: sine and cosine, angle of a direction, exponential, logarithm, hyperbolic tangent.

The C library's versions differ between platforms in the last bit and do not vectorise; these are plain arithmetic, so
they give the same bits in numba, plain Python and C, one value at a time or many. The polynomials are the classic
minimax ones of Sun's fdlibm; the largest errors are tested against `math` in ``tests/test_elementary.py``.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel

_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to the nearest integer
_TWO_OVER_PI = 0.6366197723675814
# pi/2 in three parts: products with a whole number below 2^20 are exact for the first two
_PIO2_1, _PIO2_2, _PIO2_3 = 1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21
_LOG2E = 1.4426950408889634
_ROOT_TWO = 1.4142135623730951
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10


class SinCos(NamedTuple):
    """Sine and cosine of one angle."""

    sin: float
    cos: float


@kernel
def sincos(x: float) -> SinCos:
    """Sine and cosine of `x` in rad, for magnitudes below 1e6."""
    n = (x * _TWO_OVER_PI + _ROUND) - _ROUND
    r = ((x - n * _PIO2_1) - n * _PIO2_2) - n * _PIO2_3
    z = r * r
    s = r + r * z * (
        -1.66666666666666324348e-01
        + z
        * (
            8.33333333332248946124e-03
            + z
            * (
                -1.98412698298579493134e-04
                + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
            )
        )
    )
    c = (1.0 - 0.5 * z) + z * z * (
        4.16666666666666019037e-02
        + z
        * (
            -1.38888888888741095749e-03
            + z
            * (
                2.48015872894767294178e-05
                + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11))
            )
        )
    )
    quadrant = n - 4.0 * ((n * 0.25 + _ROUND) - _ROUND)  # -2, -1, 0, 1 or 2
    odd = abs(quadrant) == 1.0
    sin = c if odd else s
    cos = s if odd else c
    sin = -sin if (quadrant == -1.0 or abs(quadrant) == 2.0) else sin
    cos = -cos if (quadrant == 1.0 or abs(quadrant) == 2.0) else cos
    return SinCos(sin, cos)


@kernel
def direction(y: float, x: float) -> float:
    """Angle of the direction (x, y) from x towards y in rad, as `math.atan2` gives it; 0 of no direction."""
    a, b = abs(y), abs(x)
    r = min(a, b) / (max(a, b) + 1e-300)  # 0 to 1: the rest of the circle follows from it
    near, middle = r < 0.4375, r < 0.6875
    high = 0.0 if near else (4.63647609000806093515e-01 if middle else 7.85398163397448278999e-01)
    low = 0.0 if near else (2.26987774529616870924e-17 if middle else 3.06161699786838301793e-17)
    u = r if near else ((2.0 * r - 1.0) / (2.0 + r) if middle else (r - 1.0) / (r + 1.0))
    z = u * u
    w = z * z
    odd = z * (
        3.33333333333329318027e-01
        + w
        * (
            1.42857142725034663711e-01
            + w
            * (
                9.09088713343650656196e-02
                + w * (6.66107313738753120669e-02 + w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02))
            )
        )
    )
    even = w * (
        -1.99999999998764832476e-01
        + w
        * (
            -1.11111104054623557880e-01
            + w * (-7.69187620504482999495e-02 + w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))
        )
    )
    t = high - ((u * (odd + even) - low) - u)
    t = (1.57079632679489655800e00 - t) if a > b else t
    t = (3.14159265358979311600e00 - t) if x < 0.0 else t
    return -t if y < 0.0 else t


@driver
def _sincos_of(x: np.ndarray, sin: np.ndarray, cos: np.ndarray) -> None:
    for i in range(x.shape[0]):
        both = sincos(x[i])
        sin[i], cos[i] = both.sin, both.cos


def sincos_of(x: np.ndarray) -> tuple[Any, Any]:
    """Sines and cosines of an array of any shape, with the bits of `sincos`."""
    flat = np.ascontiguousarray(x, dtype=np.float64).ravel()
    sin, cos = np.empty_like(flat), np.empty_like(flat)
    _sincos_of(flat, sin, cos)
    return sin.reshape(np.shape(x)), cos.reshape(np.shape(x))


@kernel
def _power_of_two(k: float) -> float:
    # 2^k for a whole number k in -1022..1023, by writing the exponent bits
    return np.int64((np.int64(k) + 1023) << 52).view(np.float64)


@kernel
def exp(x: float) -> float:
    """Exponential of `x`, which is first limited to -700..700."""
    x = min(max(x, -700.0), 700.0)
    k = (x * _LOG2E + _ROUND) - _ROUND
    high = x - k * _LN2_HIGH
    low = k * _LN2_LOW
    r = high - low
    z = r * r
    c = r - z * (
        1.66666666666666019037e-01
        + z
        * (
            -2.77777777770155933842e-03
            + z * (6.61375632143793436117e-05 + z * (-1.65339022054652515390e-06 + z * 4.13813679705723846039e-08))
        )
    )
    y = 1.0 - ((low - (r * c) / (2.0 - c)) - high)
    return y * _power_of_two(k)


@kernel
def log(x: float) -> float:
    """Natural logarithm of a positive `x`, not subnormal."""
    bits = np.float64(x).view(np.int64)
    m = np.int64((bits & 0x000FFFFFFFFFFFFF) | 0x3FF0000000000000).view(np.float64)  # x = m 2^k, m in [1, 2)
    above = m > _ROOT_TWO
    m = 0.5 * m if above else m
    k = float(((bits >> 52) & 0x7FF) - (1022 if above else 1023))
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    r = z * (
        6.666666666666735130e-01
        + z
        * (
            3.999999999940941908e-01
            + z
            * (
                2.857142874366239149e-01
                + z
                * (
                    2.222219843214978396e-01
                    + z * (1.818357216161805012e-01 + z * (1.531383769920937332e-01 + z * 1.479819860511658591e-01))
                )
            )
        )
    )
    half = 0.5 * f * f
    return k * _LN2_HIGH - ((half - (s * (half + r) + k * _LN2_LOW)) - f)


@kernel
def tanh(x: float) -> float:
    """Hyperbolic tangent of `x`; absolute error below 3e-16, small arguments lose relative accuracy."""
    return 1.0 - 2.0 / (exp(2.0 * x) + 1.0)
