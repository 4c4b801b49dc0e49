"""What is doubtful in the inputs of a run, though it can be run: levers far beyond their ends, parts that come after the end."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from polydraulic.display import amount
from polydraulic.parameters.deviations import TimedFault
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine

BEYOND = 3.0  # times the voltage of full travel; more is rather a wrong unit than a lever
LATE = 0.1  # s after the end; the hand of a random operator goes on for less


def full_lever(function: MachineFunction) -> float:
    """Voltage in V that gives a function's spool full travel."""
    return function.valve.knots[-1] / function.pilot.gain


def input_warnings(scenario: Scenario, full_lever: Mapping[str, float], t_end: float | None = None) -> list[str]:
    """Say what is doubtful in a scenario; an empty list if nothing is.

    Parameters
    ----------
    scenario : Scenario
    full_lever : mapping from function to float, V
        What gives its spool full travel.
    t_end : float, s, optional
        Where the run ends if that is asked for: then what comes later is not missed.

    Returns
    -------
    list of str
        Functions whose voltage goes beyond `BEYOND` times full lever, and signals and payloads that change after the end.
    """
    found = []
    for name, full in full_lever.items():
        largest = _largest(scenario.voltage.get(name, Constant()))
        if name not in scenario.locked and largest > BEYOND * full:
            found.append(_too_far(name, largest, full))
    late = [] if t_end is not None else list(_late(scenario))
    return found + [f"{what} after the end at {scenario.duration:g} s and is not run" for what in late]


def voltage_warnings(
    names: Sequence[str], voltage: np.ndarray, signal: np.ndarray, full_lever: np.ndarray
) -> list[str]:
    """Say which functions of a batch get voltages beyond `BEYOND` times full lever, each of the machine where it is worst.

    Parameters
    ----------
    names : sequence of str
        The functions.
    voltage : (n_signal, n_step, n_function) array, V
    signal : (n_machine,) array of int
        Which voltages each machine gets.
    full_lever : (n_machine, n_function) array, V
        What gives a spool full travel; infinite where a function is locked.

    Returns
    -------
    list of str
    """
    # nearly always, and many times faster than what follows
    if max(voltage.max(), -voltage.min()) <= BEYOND * full_lever.min():
        return []
    largest = np.maximum(voltage.max(axis=1), -voltage.min(axis=1))[signal]
    worst = np.argmax(largest / full_lever, axis=0)
    found = []
    for place, (name, machine) in enumerate(zip(names, worst.tolist(), strict=True)):
        reached, full = float(largest[machine, place]), float(full_lever[machine, place])
        if reached > BEYOND * full:
            found.append(("" if len(signal) == 1 else f"machine {machine}: ") + _too_far(name, reached, full))
    return found


def _too_far(name: str, largest: float, full: float) -> str:
    return f"{name}: the lever's voltage reaches {amount(largest, 'V')}, and {amount(full, 'V')} gives full travel; check its unit"


def _largest(signal: Signal) -> float:
    """Largest voltage to either side."""
    if isinstance(signal, Piecewise):
        return float(np.abs(signal.voltage).max())
    return abs(signal.amplitude if isinstance(signal, Sine) else signal.voltage)


def _late(scenario: Scenario) -> Iterator[str]:
    end, signals = scenario.duration + LATE, [(f"the voltage of {name}", s) for name, s in scenario.voltage.items()]
    signals += [(f"the force along {axis}", s) for axis, s in scenario.loads.force.items()]
    for what, signal in signals:
        if (
            isinstance(signal, Piecewise)
            and np.ptp(np.append(signal.voltage[signal.time > end], signal(np.array(end)))) > 0.0
        ):
            yield f"{what} changes"
    payload = scenario.loads.payload
    if payload is not None and payload.time[-1] >= scenario.duration:
        yield "the payload changes"


def fault_warnings(faults: Iterable[TimedFault], end: float) -> list[str]:
    """Faults that do not act in a run that ends at a time, s."""
    found = []
    for one in faults:
        if one.fault.readings:
            found.append(f"fault {one.fault.name}: sensors are no part of a run; `record` lets them err")
        elif one.begin >= end:
            found.append(f"fault {one.fault.name}: begins at {one.begin:g} s, and the run ends at {end:g} s")
    return found
