"""Energy and power of a machine's links, from the columns of a run and the machine's numbers alone: no kernel is asked."""

from math import pi

import numpy as np

from polydraulic.machine.frames import link_frames, vector
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import COORDINATES, GROUND
from polydraulic.parameters.schema import SwingMotor


def joint_columns(machine, run):
    """Positions and rates, each (n_time, n_function)."""
    slides = [machine.link(f.moves).joint == "prismatic" for f in machine.functions]
    positions = [
        run[f"{f.name}.{'position' if s else 'angle'}"] for f, s in zip(machine.functions, slides, strict=True)
    ]
    rates = [run[f"{f.name}.{'speed' if s else 'rate'}"] for f, s in zip(machine.functions, slides, strict=True)]
    return np.column_stack(positions), np.column_stack(rates)


def mechanical_energy(machine, run):
    """Kinetic and potential energy, J, (n_time,)."""
    positions, rates = joint_columns(machine, run)
    frames = link_frames(machine, positions)
    n, zero = len(positions), np.zeros((len(positions), 3))
    spin, speed, total = {GROUND: zero}, {GROUND: zero}, np.zeros(n)
    for place, f in enumerate(machine.functions):
        link = machine.link(f.moves)
        parent, rate = link.parent, rates[:, place, None]
        axis = np.eye(3)["xyz".index(link.axis[-1])] * (-1.0 if link.axis[0] == "-" else 1.0)
        along = frames[parent][0] @ axis
        turns = link.joint == "revolute"
        turn, origin = frames[link.name]
        spin[link.name] = spin[parent] + (along * rate if turns else 0.0)
        speed[link.name] = (
            speed[parent] + np.cross(spin[parent], origin - frames[parent][1]) + (0.0 if turns else along * rate)
        )
        to_centre = turn @ vector(link.cg)
        moving = speed[link.name] + np.cross(spin[link.name], to_centre)
        own = np.einsum("tji,tj->ti", turn, spin[link.name])  # in the link's frame, where its inertia is given
        total += 0.5 * link.mass * (moving**2).sum(1) + 0.5 * np.einsum("ti,ij,tj->t", own, _inertia(link), own)
        total += link.mass * machine.gravity * (origin + to_centre)[:, 2]
    return total


def joint_power(machine, run):
    """Power of oil on the joints less friction, W, (n_time,)."""
    positions, rates = joint_columns(machine, run)
    power = np.zeros(len(positions))
    for place, f in enumerate(machine.functions):
        q, w = positions[:, place], rates[:, place]
        a, b = _volumes(machine, f, q)
        x = f.friction
        level = x.coulomb + (x.static - x.coulomb) * np.exp(-((w / x.stribeck) ** 2))
        power += (
            a * run[f"{f.name}.p_a"] - b * run[f"{f.name}.p_b"] - level * np.tanh(w / x.smoothing) - x.viscous * w
        ) * w
    return power


def _inertia(link):
    tensor = np.zeros((3, 3))
    for key, value in link.inertia.items():
        first, second = (COORDINATES.index(c) for c in key)
        tensor[first, second] = tensor[second, first] = value
    return tensor


def _volumes(machine, f, positions):
    """Volume that a radian or metre draws from line A and gives to line B, at each position."""
    if isinstance(f.drive, SwingMotor):
        volume = np.full(len(positions), f.drive.displacement * f.drive.gear_ratio)
        return volume, volume
    arms = np.array([lever(f, machine.link(f.moves), q) for q in positions])
    head = f.drive.number * pi / 4.0 * f.drive.bore**2
    rod = head - f.drive.number * pi / 4.0 * f.drive.rod**2
    return (arms * head, arms * rod) if arms[0] > 0.0 else (-arms * rod, -arms * head)
