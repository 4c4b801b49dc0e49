"""Suspects of whom the first is an error of a sensor: a bias, which came at once and stays, and a drift, which grows."""

from collections.abc import Sequence

from polydraulic.watch.diagnosis import Suspect, sized
from polydraulic.watch.directions import Direction
from polydraulic.watch.kernels.courses import GrownError
from polydraulic.watch.kernels.evidence import ELSE

BIAS, DRIFT = ".bias", ".drift"


def with_course(
    suspects: Sequence[Suspect], directions: Sequence[Direction], course: GrownError | None, began_before: bool = False
) -> tuple[Suspect, ...]:
    """Suspects, of whom the first is two if it is an error of a sensor: a bias and a drift, as likely as its course makes them.

    Parameters
    ----------
    suspects : sequence of Suspect
        From `named_suspects`.
    directions : sequence of Direction
    course : GrownError or None
        How the error went on; None of what is no error of a sensor.
    began_before : bool
        Whether that is of blocks that are no longer kept.
    """
    if course is None:
        return tuple(suspects)
    bias = suspects[0]
    column, whole = bias.name.removesuffix(BIAS), next(d.size for d in directions if d.name == bias.name)
    when = "in the first minutes of the alarm" if began_before else "by now"
    title = sized(
        f"sensor of {column} drifts, {when} to {{}} of its range too much", whole * course.size, whole * course.error
    )
    drift = Suspect(
        f"{column}{DRIFT}", title, bias.probability * course.grows, whole * course.size, whole * course.error, False
    )  # fmt: skip
    both = [bias._replace(probability=bias.probability * (1.0 - course.grows)), drift]
    likely = sorted(both, key=lambda suspect: -suspect.probability)
    return (
        likely[0],
        *(s for s in sorted((likely[1], *suspects[1:]), key=lambda s: -s.probability) if s.probability >= ELSE),
    )
