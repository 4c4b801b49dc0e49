"""Text of the circuit of n valves in series on a pump: named tuples and straight-line kernels around those written by hand.

Valves are counted from the pump. `series_n` solves a circuit: passes until they settle, the certificate, the march for what that refuses.
Lanes have the same order of the same kernels: `series_n_path`, `series_n_begin`, then until all have settled, at most `PASSES` times, what
`series_n_pass`, or if a pump has a torque limit `series_n_limit_pass`, calls, each in a loop over lanes of its own; `series_n_end`; and
`series_n_repair` where the status is not `PROVED`. Once a circuit has settled a pass leaves it as it is, and a pass with torque limit
does to a pump without one what the other does, so that lanes have the bits of single circuits.
"""

from polydraulic.machine.circuits.series.march_text import march_text
from polydraulic.machine.circuits.wording import definitions, each, repeated, valves

SERIES_IMPORTS = (
    "from typing import NamedTuple",
    "from polydraulic._kernel import kernel",
    "from polydraulic.machine.circuits.series.check import FAR, PROVED, UNPROVED, Junction, delivers, first_node, node, status_of",
    "from polydraulic.machine.circuits.series.march import HALVINGS, Climb, asks_too_much, before_bypass, before_outlet, climbed",
    "from polydraulic.machine.circuits.series.march import delivers_at, highest_root, joined, lowest_root, march_status, reached_at, unreached",
    "from polydraulic.machine.circuits.series.passes import AT_FIRST, PASSES, Moved, Outlet, behind, least_flow, limited",
    "from polydraulic.machine.circuits.series.passes import passed_first, passed_on, resistance, settled, stepped, tangent",
    "from polydraulic.machine.pump import Circuit",
    "from polydraulic.machine.valve import orifice_flow",
)


def series_text(n: int) -> str:
    """Definitions of a circuit of `n` valves, 2 to 6; `SERIES_IMPORTS` belong above them.

    Two are for comparison, since `series_2` is written by hand.
    """
    return definitions((_tuples(n), _passes(n), _ends(n), march_text(n), _solved(n)))


def _tuples(n: int) -> str:
    return f'''
class Series{n}(NamedTuple):
    """{n} actuators on a pump, each fed by what passes the valves before it."""

{repeated("    q_in_~: float  # m3/s", range(1, n + 1))}
{repeated("    p_between_~: float  # Pa, behind this valve", range(1, n))}
    circuit: Circuit
    status: int  # 0: proved, 1: repaired, 2: not to be trusted


class Path{n}(NamedTuple):
    """Resistances of inlets and bypasses, Pa s2/m6."""

{repeated("    a_~: float", range(1, n + 1))}
{repeated("    b_~: float", range(1, n + 1))}


class Passed{n}(NamedTuple):
    """Between two passes: the pump's flow, its least, what passes each valve; last changes, the pump's as a share; whether all has settled."""

    q_pump: float  # m3/s
    least: float  # m3/s
    dq: float
{repeated("    w_~: float  # m3/s", range(1, n))}
{repeated("    dw_~: float  # m3/s", range(1, n))}
    largest: float  # m3/s
    still: bool
'''


def _passes(n: int) -> str:
    return f'''
@kernel
def series_{n}_path({each("k_~", 1, n)}):
    """What resists the flow; the same in all passes."""
    return Path{n}({each("resistance(k_~.inlet)", 1, n)}, {each("resistance(k_~.bypass)", 1, n)})


@kernel
def series_{n}_begin(pump):
    """Where passes start: most of the flow passes all valves."""
    flow = pump.flow
    return Passed{n}(flow, least_flow(pump), AT_FIRST, {", ".join(f"{1.0 - 0.1 * i:.1f} * flow" for i in range(1, n))}, {each("AT_FIRST", 1, n)}, False)


@kernel
def series_{n}_pass(x, path, {_ports(n)}):
    """One pass at a given flow of the pump: tangents from the last valve to the first, then shares back."""
    still = x.still
{_backwards(n)}
{_forwards(n, "x.q_pump")}
    largest = {_largest(n)}
{_result(n, "x.q_pump", "x.dq")}


@kernel
def series_{n}_limit_pass(x, path, {_ports(n)}):
    """One pass, and between its halves a step of the pump's flow towards the torque limit."""
    still = x.still
{_backwards(n)}
    whole = tangent(x.q_pump, path.a_1, p_1, behind_1)
    q = limited(x.q_pump, x.dq, x.least, whole, pump, still)
{_forwards(n, "q.value")}
    largest = max(abs(q.change) * q.value, {_largest(n)})
{_result(n, "q.value", "q.change")}
'''


def _ports(n: int) -> str:
    return f"{each('p_~', 1, n)}, pump"


def _result(n: int, flow: str, change: str) -> str:
    values, changes = each("to_~.value", 1, n - 1), each("to_~.change", 1, n - 1)
    still = f"settled(largest, x.largest, {flow})"
    return f"    return Passed{n}({flow}, x.least, {change}, {values}, {changes}, largest, {still})"


def _largest(n: int) -> str:
    largest = "abs(to_1.change)"
    for i in range(2, n):
        largest = f"max({largest}, abs(to_{i}.change))"
    return largest


def _backwards(n: int) -> str:
    line = "    behind_~ = behind(x.w_~, path.a_~+, p_~+, behind_~+, path.b_~)"
    return f"""    behind_{n} = Outlet(path.b_{n}, pump.p_return)
{repeated(line, range(n - 1, 0, -1))}"""


def _forwards(n: int, flow: str) -> str:
    inner = """    to_~ = stepped(x.w_~, x.dw_~, passed_on(to_~-.value, path.a_~, p_~, behind_~), to_~-.value, still)"""
    first = f"    to_1 = stepped(x.w_1, x.dw_1, passed_first({flow}, path.a_1, p_1, behind_1, pump), {flow}, still)"
    return "\n".join([first, *(repeated(inner, [i]) for i in range(2, n))])


def _ends(n: int) -> str:
    return f'''
@kernel
def series_{n}_seen(q_pump, {each("q_~", 1, n)}, {each("w_~", 1, n)}, {valves(n)}, repaired):
    """Pressures that belong to flows into actuators and past valves; the certificate, unless they were repaired."""
    node_{n} = node(q_{n}, w_{n}, k_{n}, p_{n}, pump.p_return, Junction(0.0, 0.0))
{repeated("    node_~ = node(q_~, w_~, k_~, p_~, p_~+, node_~+)", range(n - 1, 1, -1))}
    q_relief = q_pump - q_1 - w_1
    first = first_node(q_1, w_1, q_relief, k_1, p_1, p_2, node_2, pump)
    circuit = Circuit(q_pump, w_{n}, max(q_relief, 0.0), first.p, 0.0)
    known = abs({" + ".join(f"p_{i}" for i in range(1, n + 1))}) < FAR
    status = status_of(first.unmet, pump) if repaired == PROVED else repaired
    status = status if known else UNPROVED
    return Series{n}({each("q_~", 1, n)}, {each("p_~ + node_~.over", 2, n)}, circuit, status)


@kernel
def series_{n}_end(x, path, {valves(n)}):
    """Flows after the passes, with pressures and certificate."""
    q_1 = min(x.q_pump - x.w_1, orifice_flow(k_1.inlet, pump.relief - p_1))
{repeated("    q_~ = x.w_~- - x.w_~", range(2, n))}
    w_{n} = passed_on(x.w_{n - 1}, path.a_{n}, p_{n}, Outlet(path.b_{n}, pump.p_return))
    q_{n} = x.w_{n - 1} - w_{n}
    return series_{n}_seen(x.q_pump, {each("q_~", 1, n)}, {each("x.w_~", 1, n - 1)}, w_{n}, {valves(n)}, PROVED)


@kernel
def series_{n}_limit_end(x, path, {valves(n)}):
    """The same after passes with torque limit, to which the certificate then extends."""
    s = series_{n}_end(x, path, {valves(n)})
    status = s.status if delivers(s.circuit, pump) else UNPROVED
    return Series{n}({each("s.q_in_~", 1, n)}, {each("s.p_between_~", 1, n - 1)}, s.circuit, status)
'''


def _solved(n: int) -> str:
    return f'''
@kernel
def series_{n}({valves(n)}):
    """{n} actuators on a pump, the first with priority: conductances in m3/s/Pa^0.5, port pressures in Pa."""
    path = series_{n}_path({each("k_~", 1, n)})
    x = series_{n}_begin(pump)
    if pump.log_least < 0.0:
        for _ in range(PASSES):
            x = series_{n}_limit_pass(x, path, {_ports(n)})
            if x.still:
                break
        s = series_{n}_limit_end(x, path, {valves(n)})
    else:
        for _ in range(PASSES):
            x = series_{n}_pass(x, path, {_ports(n)})
            if x.still:
                break
        s = series_{n}_end(x, path, {valves(n)})
    return s if s.status == PROVED else series_{n}_repair({valves(n)})
'''
