"""Fit angles or strokes of joints to the commands that move them: models of joints, with the errors of their runs through blocks held out."""

from collections.abc import Sequence
from math import inf, pi
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.arguments import check_columns, table_of
from polydraulic.identification.dynamic_fit import DynamicFit, fit_log
from polydraulic.identification.log_rows import log_rows
from polydraulic.networks.dynamic.command_response import longest_lag_in_rows, most_looked_back
from polydraulic.networks.dynamic.joint_regressor import JointRegressor
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table


def fit_joints(
    table: Table | str | Path | Sequence[Table | str | Path],
    commands: Sequence[str],
    joints: Sequence[str],
    *,
    more_inputs: Sequence[str] = (),
    continuous: Sequence[str] = (),
    longest: float | None = None,
    horizon: float = 10.0,
    progress: Progress = quiet,
) -> DynamicFit:
    """Fit angles or strokes of joints to the commands that move them, where nothing is known of the hydraulics.

    Dead time, lag and dead zone of each command are found, then the rate of each joint, which may depend on what the others do; see
    `JointRegressor`. Blocks of time are held out as by `fit_dynamic`, which also says what is stated.

    Parameters
    ----------
    table : Table, str, Path or sequence of them
        As for `fit_dynamic`.
    commands, joints : sequence of str
        The first command moves the first joint, and so on.
    more_inputs : sequence of str
        What else rates may depend on, such as engine speed.
    continuous : sequence of str
        Joints that turn without end, such as a swing: they have no stops, and no rate depends on their angle. Angles that went through more
        than a full turn count as such, too. An angle goes on past a full turn; one that jumps back there is to be unwrapped first.
    longest : float, s, optional
        After which the response of a rate to its command must be over, nearly; at most 120 rows. 0.8 if not given, or 120 rows where these
        are shorter.
    horizon : float, s
        Of the free runs by which is chosen what rates depend on.
    progress : Progress, optional
        Called with each joint.

    Returns
    -------
    DynamicFit

    Raises
    ------
    InputError
        As `fit_dynamic`; as many commands as joints are needed, and each must move its own; a continuous joint that is none of the joints, or
        moves by more than half a turn from one row to the next.
    """
    if len(commands) != len(joints):
        raise InputError(
            f"{len(commands)} commands for {len(joints)} joints: name the command of each joint, in the order of the joints"
        )
    for name, value in (("longest", longest), ("horizon", horizon)):
        if value is not None and not 0.0 < value < inf:
            raise InputError(f"{name} = {value!r} s: must be a time above 0")

    strange = [name for name in continuous if name not in joints]
    if strange:
        raise InputError(f"continuous joints {strange} are not among the joints: {list(joints)}")
    log, source = table_of(table, [*commands, *more_inputs, *joints], ["time", "segment"])
    check_columns(log, [*commands, *more_inputs], joints)
    endless = [k for k, name in enumerate(joints) if name in continuous or _went_round(log, name)]
    for k in endless:
        _check_goes_on(log, joints[k])

    def learner(raster: float, tell: Progress) -> JointRegressor:
        return JointRegressor(
            longest_lag=longest_lag_in_rows(longest, raster), horizon=max(20, round(horizon / raster)), continuous=endless, raster=raster, progress=tell,
            signal_names=[*commands, *more_inputs, *joints],
        )  # fmt: skip

    def looks_back(raster: float) -> int:
        return most_looked_back(longest_lag_in_rows(longest, raster))

    return fit_log((log, source), [*commands, *more_inputs], joints, learner, looks_back, progress)


def _went_round(table: Table, joint: str) -> bool:
    """Whether an angle went through more than a full turn."""
    return bool(np.ptp(table[joint]) > _turn(table, joint))


def _check_goes_on(table: Table, joint: str) -> None:
    """Refuse an angle that jumps back after a turn, which would be learnt as a motion."""
    half = 0.5 * _turn(table, joint)
    follows = np.diff(log_rows(table).segments) == 0
    step = np.diff(table[joint])
    jumps = np.flatnonzero(follows & (np.abs(step) > half))
    if jumps.size:
        row, unit = int(jumps[0]), table.unit(joint)
        raise InputError(
            f"the continuous joint {joint!r} goes from {table[joint][row]:.6g} to {table[joint][row + 1]:.6g} {unit} in row {row + 2}, and so by more "
            f"than half a turn in {jumps.size} row(s): an angle must go on past a full turn; unwrap it first, for example by numpy.unwrap with "
            f"period={2.0 * half:.6g}"
        )


def _turn(table: Table, joint: str) -> float:
    """A full turn in the unit of a joint; infinite for a stroke."""
    return {"rad": 2.0 * pi, "deg": 360.0}.get(table.unit(joint), inf)
