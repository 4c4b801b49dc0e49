"""The planar arm of a machine: where its tip is, and which joint rates move the tip as wanted.

The joints between the ground and the tip that lie in one vertical plane are the arm: they turn about y or slide along x or z. What turns the
whole plane about z is the swing. The last joint may be an attachment's, whose angle to the ground is held or commanded; then the arm before
it moves the attachment's pin, and the tip with it. Angles of the plane are positive upward, about -y.

Tip and rates are kernels here, and not those of `polydraulic.machine.reach`, since a controller calls them without allocating and is written out as C.
"""

from math import cos, hypot, isfinite, sin, sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.errors import InputError
from polydraulic.machine.drives import prepare_drive
from polydraulic.machine.reach.tip import tip_links
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import CylinderSize, LinkParameters, MachineFunction, Point
from polydraulic.parameters.layout.schema import LayoutMachine

ATTACHMENTS = ("bucket", "front_bucket")  # roles


class Arm(NamedTuple):
    """A planar arm; arrays have an entry for each of its joints, from the machine outward, without the attachment's.

    Attributes
    ----------
    function : array of int
        Which function moves the joint.
    slides : array of int
        1 of a prismatic joint.
    sign : array
        1 where a positive position is upward, or along the axis; -1 otherwise.
    along_x, along_z : array
        Axis of a prismatic joint, in the plane.
    at_x, at_z : array, m
        The joint in the frame of the link before it.
    speed : array, rad/s or m/s
        What the pump's whole flow gives at mid-travel: what is easy for the joint.
    end_x, end_z : float, m
        The point that the arm moves, in the frame of its last link.
    swing, attachment : int
        Functions, -1 where there is none.
    swing_sign, attachment_sign : float
    tip_x, tip_z : float, m
        The tip from that point, in the attachment's frame; 0 without one.
    """

    function: np.ndarray
    slides: np.ndarray
    sign: np.ndarray
    along_x: np.ndarray
    along_z: np.ndarray
    at_x: np.ndarray
    at_z: np.ndarray
    speed: np.ndarray
    end_x: float
    end_z: float
    swing: int
    attachment: int
    swing_sign: float
    attachment_sign: float
    tip_x: float
    tip_z: float


class Pose(NamedTuple):
    """Of the tip, in the plane of the arm: reach and height in m, and the pitch of the last link in rad."""

    reach: float
    height: float
    pitch: float


@kernel
def arm_pose(arm: Arm, live: np.ndarray, angles: int, columns: int) -> Pose:
    """Where the tip is; for each joint of the arm, what a unit of its rate adds to the velocity of its end is put into `live`.

    Parameters
    ----------
    arm : Arm
    live : array
        Holds positions of all functions' joints from `angles` on; reach and height of each column are put from `columns` on.
    angles, columns : int
    """
    x, z, s, c, pitch = 0.0, 0.0, 0.0, 1.0, 0.0
    for i in range(arm.function.shape[0]):
        x += c * arm.at_x[i] - s * arm.at_z[i]
        z += s * arm.at_x[i] + c * arm.at_z[i]
        q = live[angles + arm.function[i]]
        if arm.slides[i] == 1:
            along_x = c * arm.along_x[i] - s * arm.along_z[i]
            along_z = s * arm.along_x[i] + c * arm.along_z[i]
            live[columns + 2 * i] = along_x
            live[columns + 2 * i + 1] = along_z
            x += along_x * q
            z += along_z * q
        else:
            live[columns + 2 * i] = x
            live[columns + 2 * i + 1] = z
            pitch += arm.sign[i] * q
            turn = sincos(pitch)
            s = turn.sin
            c = turn.cos
    x += c * arm.end_x - s * arm.end_z
    z += s * arm.end_x + c * arm.end_z
    for i in range(arm.function.shape[0]):
        if arm.slides[i] == 0:
            pin_x = live[columns + 2 * i]
            live[columns + 2 * i] = -arm.sign[i] * (z - live[columns + 2 * i + 1])
            live[columns + 2 * i + 1] = arm.sign[i] * (x - pin_x)
    if arm.attachment >= 0:
        pitch += arm.attachment_sign * live[angles + arm.attachment]
    last = sincos(pitch)
    return Pose(x + last.cos * arm.tip_x - last.sin * arm.tip_z, z + last.sin * arm.tip_x + last.cos * arm.tip_z, pitch)


@kernel
def arm_rates(
    arm: Arm,
    live: np.ndarray,
    columns: int,
    rates: int,
    reach: float,
    height: float,
    swing: float,
    pitch: float,
    slow: float,
) -> None:
    """Rates of all functions that move the arm's end with `reach` and `height` in m/s, and turn swing and attachment in rad/s.

    The least rates by the joints' speeds, damped where the pump's whole flow moves the end slower than `slow` m/s in some direction. An arm
    of one joint follows the height alone.
    """
    xx, xz, zz = 0.0, 0.0, 0.0
    n = arm.function.shape[0]
    for i in range(n):
        weight = arm.speed[i] * arm.speed[i]
        jx = live[columns + 2 * i] if n > 1 else 0.0
        jz = live[columns + 2 * i + 1]
        xx += weight * jx * jx
        xz += weight * jx * jz
        zz += weight * jz * jz
    half = 0.5 * (xx - zz)
    least = 0.5 * (xx + zz) - sqrt(half * half + xz * xz) if n > 1 else zz
    damped = max(slow * slow - least, 0.0)
    xx += damped
    zz += damped
    below = xx * zz - xz * xz + 1e-300
    fx = (zz * reach - xz * height) / below if n > 1 else 0.0
    fz = (xx * height - xz * reach) / below if n > 1 else height / (zz + 1e-300)
    turned = 0.0
    for i in range(n):
        jx = live[columns + 2 * i] if n > 1 else 0.0
        rate = arm.speed[i] * arm.speed[i] * (jx * fx + live[columns + 2 * i + 1] * fz)
        live[rates + arm.function[i]] = rate
        turned += arm.sign[i] * rate if arm.slides[i] == 0 else 0.0
    if arm.attachment >= 0:
        live[rates + arm.attachment] = arm.attachment_sign * (pitch - turned)
    if arm.swing >= 0:
        live[rates + arm.swing] = arm.swing_sign * swing


def planar_arm(machine: LayoutMachine) -> Arm:
    """The arm of a machine.

    Raises
    ------
    InputError
        A machine whose joints, from the ground to its tip, do not lie in a plane that turns about z.
    """
    chain = tip_links(machine)
    swing = chain[0] if chain[0].joint == "revolute" and chain[0].axis[-1] == "z" else None
    rest = chain[1:] if swing is not None else chain
    moved = {f.moves: number for number, f in enumerate(machine.functions)}
    broken = [link for link in rest if link.axis[-1] not in ("y" if link.joint == "revolute" else "xz")]
    if broken or not rest:
        what = f"{broken[0].joint} {broken[0].axis} of {broken[0].name}" if broken else "none"
        raise InputError(
            f"{machine.title}: the joints between the ground and the tip are no planar arm ({what}): after a swing about z, joints must turn "
            "about y or -y, or slide along x or z"
        )
    last = machine.functions[moved[rest[-1].name]]
    held = last.role in ATTACHMENTS and rest[-1].joint == "revolute" and len(rest) > 1
    joints = rest[:-1] if held else rest
    end = rest[-1].at if held else machine.tip[1]
    tip: Point = machine.tip[1] if held else {}
    origin = swing.at.get("z", 0.0) if swing is not None else 0.0
    ats = [(link.at.get("x", 0.0), link.at.get("z", 0.0)) for link in joints]
    ats[0] = ats[0][0], ats[0][1] + origin
    slides = [link.joint == "prismatic" for link in joints]
    return Arm(
        np.array([moved[link.name] for link in joints], dtype=np.int64),
        np.array(slides, dtype=np.int64),
        np.array([_upward(link) for link in joints]),
        np.array([_towards(link, "x") for link in joints]),
        np.array([_towards(link, "z") for link in joints]),
        np.array([x for x, _ in ats]),
        np.array([z for _, z in ats]),
        np.array([pump_rate(machine, machine.functions[moved[link.name]]) for link in joints]),
        end.get("x", 0.0),
        end.get("z", 0.0),
        moved[swing.name] if swing is not None else -1,
        moved[rest[-1].name] if held else -1,
        -1.0 if swing is not None and swing.axis.startswith("-") else 1.0,
        _upward(rest[-1]) if held else 1.0,
        tip.get("x", 0.0),
        tip.get("z", 0.0),
    )


def pump_rate(machine: LayoutMachine, f: MachineFunction) -> float:
    """Rate of a joint at mid-travel, in rad/s or m/s, with all of the pump's flow into the larger side of its actuator."""
    circuit = next(c for c in machine.circuits if f.name in c.functions)
    link, drive = machine.link(f.moves), prepare_drive(f, machine.link(f.moves))
    if isinstance(f.drive, CylinderSize):
        low, high = f.stops.low, f.stops.high
        arms = [abs(lever(f, link, low + (high - low) * k / 8.0) or 0.0) for k in range(1, 8)]
        volume = max(drive.area_a, drive.area_b) * max(arms)  # type: ignore[union-attr]
    else:
        volume = drive.displacement  # type: ignore[union-attr]
    return circuit.pump.flow / volume


def _upward(link: LinkParameters) -> float:
    negated = link.axis.startswith("-")
    return 1.0 if negated == (link.joint == "revolute") else -1.0


def _towards(link: LinkParameters, axis: str) -> float:
    if link.joint != "prismatic" or link.axis[-1] != axis:
        return 0.0
    return -1.0 if link.axis.startswith("-") else 1.0


def joints_at(machine: LayoutMachine, reach: float, height: float, *, pitch: float = 0.0) -> dict[str, float]:
    """Positions of the arm's joints that bring the tip to a place, from where they are at the start.

    Parameters
    ----------
    machine : LayoutMachine
    reach, height : float, m
        In the plane of the arm, from the swing axis and the ground.
    pitch : float, rad
        Of the attachment to the ground, where there is one.

    Returns
    -------
    dict from function to position in rad or m

    Raises
    ------
    InputError
        A place that cannot be reached within the stops.
    """
    for name, value in (("reach", reach), ("height", height), ("pitch", pitch)):
        if not isfinite(value):
            raise InputError(f"{name} = {value}: must be a finite number")
    arm, n = planar_arm(machine), len(machine.names)
    live = np.zeros(4 * n)
    live[:n] = [f.initial.angle for f in machine.functions]
    stops = np.array([f.stops for f in machine.functions])
    for _ in range(400):
        pose = arm_pose(arm, live, 0, 2 * n)
        turn = pitch - pose.pitch if arm.attachment >= 0 else 0.0
        if hypot(reach - pose.reach, height - pose.height) < 1e-6 and abs(turn) < 1e-6:
            return {name: float(live[j]) for j, name in enumerate(machine.names)}
        c, s = cos(pose.pitch), sin(pose.pitch)
        x, z = c * arm.tip_x - s * arm.tip_z, s * arm.tip_x + c * arm.tip_z
        c, s = cos(pitch), sin(pitch)
        on = [reach - pose.reach, height - pose.height]
        if arm.attachment >= 0:  # the end moves so that the tip arrives with its pitch
            on = [on[0] + x - (c * arm.tip_x - s * arm.tip_z), on[1] + z - (s * arm.tip_x + c * arm.tip_z)]
        arm_rates(arm, live, 2 * n, n, on[0], on[1], 0.0, turn, 0.02)
        live[:n] = np.clip(live[:n] + 0.3 * live[n : 2 * n], stops[:, 0], stops[:, 1])
    raise InputError(
        f"{machine.title}: the tip cannot be brought to a reach of {reach:g} m and a height of {height:g} m"
        + (f" with a pitch of {pitch:g} rad" if arm.attachment >= 0 else "")
        + f"; the nearest found is {pose.reach:.3f} m, {pose.height:.3f} m, {pose.pitch:.3f} rad"
    )
