"""All kernels of a block as one text: the steps of a plan, one after the other, with circuits of as many valves as a machine has.

A plan is data (`polydraulic.watch.plan`): for each step its kind, and the places that it reads and writes.
"""

from collections.abc import Iterable
from functools import cache
from types import ModuleType

from polydraulic.flow.layout.text_module import loaded
from polydraulic.machine.circuits.series.text import SERIES_IMPORTS, series_text

# kinds of steps in the order of their numbers: module, and arrays that a step is given
STEPS = {
    "read": ("signals", "ints, floats, live, work"),
    "smooth": ("signals", "ints, floats, work"),
    "not_below_zero": ("signals", "ints, work"),
    "spool_by_voltage": ("signals", "ints, floats, work"),
    "port": ("signals", "ints, work"),
    "opening_of_outlet": ("signals", "ints, floats, work"),
    "flow_out": ("signals", "ints, floats, work"),
    "outlet_pressure": ("signals", "ints, floats, work"),
    "straight_volumes": ("signals", "ints, floats, work"),
    "tabled_volumes": ("signals", "ints, floats, work"),
    "difference": ("signals", "ints, work"),
    "volume_balance": ("windows", "ints, floats, work"),
    "within": ("windows", "ints, floats, work"),
    "above": ("windows", "ints, floats, work"),
    "clear_of_relief": ("windows", "ints, floats, work"),
    "same_number": ("windows", "ints, floats, work"),
    "add_moved": ("windows", "ints, floats, work"),
    "add_window_noise": ("windows", "ints, floats, work"),
    "where_worth": ("windows", "ints, floats, work"),
    "convolved": ("motion", "ints, floats, work"),
    "oil_torque": ("motion", "ints, floats, work"),
    "friction": ("motion", "ints, floats, work"),
    "add_friction_unsure": ("motion", "ints, floats, work"),
    "torque_left": ("motion", "ints, work"),
    "needed_torques": ("motion", "ints, floats, work"),
}
_CIRCUIT, _CROSSING = "circuit_", "crossing_"


def kind_of_step(name: str) -> int:
    """Number of a kind of step; ``circuit_N`` of circuits of N valves, ``crossing_N`` of two that a crossover joins."""
    for first, prefix in ((len(STEPS), _CIRCUIT), (len(STEPS) + 1, _CROSSING)):
        if name.startswith(prefix):
            return first + 2 * int(name.removeprefix(prefix))  # in turns, so that no two meet
    return list(STEPS).index(name)


def kernels_for(sizes: Iterable[int], joined: Iterable[int] = ()) -> ModuleType:
    """The kernels of a block for machines whose circuits have so many valves, and so many together those that a crossover joins."""
    return _module(tuple(sorted(set(sizes))), tuple(sorted(set(joined))))


@cache
def _module(sizes: tuple[int, ...], joined: tuple[int, ...]) -> ModuleType:
    return loaded(block_text(sizes, joined))


def block_text(sizes: tuple[int, ...], joined: tuple[int, ...] = ()) -> str:
    """The text of the kernels of a block.

    Parameters
    ----------
    sizes, joined : tuple of int
        Numbers of valves of circuits, and of two that a crossover joins, rising.
    """
    imports = [
        "import numpy as np",
        "from polydraulic._kernel import driver, kernel",
        "from polydraulic.machine.pump import Pump",
        "from polydraulic.machine.circuits.series.check import UNPROVED",
        "from polydraulic.machine.circuits.series.short import series_1, series_2",
        "from polydraulic.machine.valve import Orifices",
        *(line for line in SERIES_IMPORTS if max(sizes, default=0) > 2 and "_kernel" not in line),
        *(
            f"from polydraulic.machine.circuits.crossover.circuit import CrossoverOrifice, crossover_{n}"
            for n in joined
        ),
        "from polydraulic.watch.kernels.alarms import decide",
        "from polydraulic.watch.kernels.numbers import WatchNumbers",
        "from polydraulic.watch.kernels.rows import FULL, JUDGED, keep_rows, take_row",
        "from polydraulic.watch.kernels.scores import score, whiten",
        "from polydraulic.watch.kernels.stays import sensor_states",
        *(f"from polydraulic.watch.kernels.{module} import {name}" for name, (module, _) in STEPS.items()),
        "from polydraulic.watch.kernels.signals import NOTHING, interpolated",
    ]
    parts = [
        '"""A block of a machine that is watched."""',
        "\n".join(imports),
        *(series_text(n) for n in sizes if n > 2),
        *(_circuit(n) for n in sizes),
        *(_crossing(n) for n in joined),
        _plan(sizes, joined),
        _JUDGED,
    ]
    return "\n\n\n".join(part.strip() for part in parts) + "\n"


def _circuit(n: int) -> str:
    return f'''
@driver
def circuit_{n}(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """Flows into the actuators of a circuit and the pressure of its pump, `NOTHING` where they are not proved.

    Places are the first row, how many, the pump, and the output of its pressure; of each valve spool, port, output, curves and their knots.
    """
    first, n, number = ints[s], ints[s + 1], ints[s + 2]
    pump = {_pump(0)}
{_places(n, 1)}
    for i in range(first, first + n):
{_orifices(n)}
        found = series_{n}({_each("k", range(n))}, {_each("p", range(n))}, pump)
{_results([f"found.q_in_{k + 1}" for k in range(n)], ["found.circuit"], "found.status")}
'''


def _crossing(n: int) -> str:
    giving = n - 2
    flows = [*(f"found.giving.q_in_{k + 1}" for k in range(giving)), "found.taking.q_in_1", "found.taking.q_in_2"]
    return f'''
@driver
def crossing_{n}(ints: np.ndarray, floats: np.ndarray, work: np.ndarray, s: int) -> None:
    """The same of two circuits that a crossover joins, valves of the giving one first; behind them the crossover's opening pressure and curve."""
    first, n, number = ints[s], ints[s + 1], ints[s + 2]
    gives = {_pump(0)}
    takes = {_pump(6)}
{_places(n, 2)}
    cross = s + {5 + 5 * n}
    opens, count = ints[cross], ints[cross + 1]
    for i in range(first, first + n):
{_orifices(n)}
        conductance = interpolated(floats, opens + 1, opens + 1 + count, count, x_{n - 1})
        orifice = CrossoverOrifice(conductance, floats[opens])
        found = crossover_{n}(orifice, {_each("k", range(n))}, {_each("p", range(n))}, gives, takes)
{_results(flows, ["found.giving.circuit", "found.taking.circuit"], "found.taking.status")}
'''


def _pump(at: int) -> str:
    return f"Pump({', '.join(f'floats[number + {at + k}]' if at + k else 'floats[number]' for k in range(6))})"


def _each(name: str, numbers: Iterable[int]) -> str:
    return ", ".join(f"{name}_{k}" for k in numbers)


def _places(n: int, pumps: int) -> str:
    return "\n".join(f"    valve_{k} = s + {3 + pumps + 5 * k}" for k in range(n))


def _orifices(n: int) -> str:
    return "\n".join(
        f"""        x_{k} = abs(work[ints[valve_{k}] + i])
        knots_{k}, count_{k} = ints[valve_{k} + 3], ints[valve_{k} + 4]
        k_{k} = Orifices(
            interpolated(floats, knots_{k}, knots_{k} + count_{k}, count_{k}, x_{k}),
            interpolated(floats, knots_{k}, knots_{k} + 2 * count_{k}, count_{k}, x_{k}),
            0.0,
        )
        p_{k} = work[ints[valve_{k} + 1] + i]"""
        for k in range(n)
    )


def _results(flows: Iterable[str], circuits: Iterable[str], status: str) -> str:
    outputs = [(f"ints[valve_{k} + 2]", flow) for k, flow in enumerate(flows)]
    outputs += [(f"ints[s + {3 + k}]", f"{circuit}.p_pump") for k, circuit in enumerate(circuits)]
    return "\n".join(
        f"        work[{place} + i] = {value} if {status} < UNPROVED else NOTHING" for place, value in outputs
    )


def _plan(sizes: tuple[int, ...], joined: tuple[int, ...]) -> str:
    calls = [(kind_of_step(name), name, arrays) for name, (_, arrays) in STEPS.items()]
    solved = [*(f"{_CIRCUIT}{n}" for n in sizes), *(f"{_CROSSING}{n}" for n in joined)]
    calls += [(kind_of_step(name), name, "ints, floats, work") for name in solved]
    branches = "\n".join(
        f"        {'if' if k == 0 else 'elif'} kind == {number}:\n            {name}({arrays}, s)"
        for k, (number, name, arrays) in enumerate(calls)
    )
    return f'''
@driver
def run_plan(ints: np.ndarray, floats: np.ndarray, live: np.ndarray, work: np.ndarray) -> None:
    """All steps of a plan: `ints` begins with how many there are, and where each stands."""
    for k in range(ints[0]):
        kind, s = ints[ints[k + 1]], ints[k + 1] + 1
{branches}
'''


_JUDGED = '''
@driver
def judge_block(numbers: WatchNumbers, work: np.ndarray, live: np.ndarray, marks: np.ndarray) -> None:
    """What a block says of each direction, and of each sensor."""
    run_plan(numbers.ints, numbers.floats, live, work)
    score(numbers.ints, numbers.scales, work, numbers.directions, numbers.in_work, numbers.score_table)
    whiten(numbers.offset, numbers.jitter, work, numbers.directions, numbers.in_work)
    states = numbers.in_marks + 2 * (numbers.directions + numbers.sensors) + numbers.owners
    sensor_states(numbers.ints, numbers.floats, live, numbers.at_rows, marks, states, numbers.states_table)


@driver
def watch_row(
    numbers: WatchNumbers, work: np.ndarray, live: np.ndarray, marks: np.ndarray, time: float, row: np.ndarray
) -> int:
    """Take a row: what became of it, and of one that completes a block, whether there is an alarm."""
    became = take_row(time, row, numbers.rows, live, numbers.at_rows, marks, numbers.raster)
    if became == FULL:
        judge_block(numbers, work, live, marks)
        became = JUDGED + decide(numbers, work, live, marks)
        keep_rows(live, numbers.at_rows, numbers.rows, numbers.inside, numbers.sensors + 1, marks)
    return became
'''
