"""Steps of a machine with a fixed raster that a communication step of an FMU makes due, in C."""


def steps_due(name: str) -> str:
    """Text of a function ``steps_due(rest, from, to)``; `name` is before ``_DT``."""
    return f"""/* Steps that a communication step makes due. One that is a whole number of them, up to the rounding of its ends, counts
   as that number, however large the times are and however often it comes; of any other the rest is carried over. */
static double steps_due(double *rest, double from, double to)
{{
    const double steps = (to - from) / {name.upper()}_DT;
    const double rounding = 2.0 * DBL_EPSILON * fmax(fabs(from), fabs(to)) / {name.upper()}_DT;
    const double whole = floor(steps + 0.5);
    if (whole >= 1.0 && fabs(steps - whole) <= 1e-9 * whole + rounding) {{
        return whole;
    }}
    const double passed = *rest + steps;
    const double due = floor(passed + 1e-6 + rounding);
    *rest = passed - due;
    return due;
}}
"""
