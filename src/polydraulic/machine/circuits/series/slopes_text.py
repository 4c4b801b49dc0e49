"""Text of the slopes of a circuit of n valves in series, over port pressures and spools; how they are found is said in `slopes`."""

from collections.abc import Iterable

from polydraulic.machine.circuits.wording import definitions, each, repeated

SERIES_SLOPES_IMPORTS = (
    "from typing import NamedTuple",
    "from polydraulic._kernel import kernel",
    "from polydraulic.machine.circuits.series.slopes import divider, fall, fall_before, in_row, linear",
    "from polydraulic.machine.circuits.series.slopes import pump_conductance",
)


def series_slopes_text(n: int) -> str:
    """Definitions of the slopes of `series_n`; `SERIES_SLOPES_IMPORTS` belong above them."""
    return definitions((_tuple(n), _kernel(n)))


def _tuple(n: int) -> str:
    def fields(what: str, unit: str) -> str:
        return "\n".join(f"    {name}: float  # {unit}" for name in _names(what, n))

    return f'''
class Slopes{n}(NamedTuple):
    """Slopes of inlet flows: by_p_i_j and by_x_i_j are those of valve i over port pressure and spool of valve j."""

{fields("p", "m3/s/Pa")}
{fields("x", "m2/s")}
'''


def _names(what: str, n: int) -> list[str]:
    return [f"by_{what}_{i}_{j}" for i in range(1, n + 1) for j in range(1, n + 1)]


def _kernel(n: int) -> str:
    valves = range(1, n + 1)
    return f'''
@kernel
def series_{n}_slopes({each("k_~", 1, n)}, {each("d_~", 1, n)}, s, pump):
    """Slopes at a solution `s` of `series_{n}`; d_i are the slopes of the conductances k_i over the spool."""
    passed_{n} = s.circuit.q_bypass
{repeated("    passed_~ = passed_~+ + s.q_in_~+", range(n - 1, 0, -1))}
{repeated("    v_~ = linear(k_~, d_~, s.q_in_~, passed_~)", valves)}
    # beyond its inlet, what a node sees towards the tank, and towards the pump
    to_tank_{n} = v_{n}.bypass
{repeated("    to_tank_~ = in_row(v_~.bypass, v_~+.inlet + to_tank_~+)", range(n - 1, 0, -1))}
    to_pump_1 = pump_conductance(s.circuit, pump)
{repeated("    to_pump_~ = in_row(v_~-.bypass, v_~-.inlet + to_pump_~-)", range(2, n + 1))}
    # pressure at a node as a share of that at the node before it, or behind it
{repeated("    down_~ = divider(v_~-.bypass, v_~.inlet + to_tank_~)", range(2, n + 1))}
{repeated("    up_~ = divider(v_~.bypass, v_~.inlet + to_pump_~)", range(1, n))}
{_joined(_over_port(n, j) for j in valves)}
{_joined(_over_spool(n, j) for j in valves)}
    return Slopes{n}({", ".join([*_names("p", n), *_names("x", n)])})
'''


def _joined(parts: Iterable[str]) -> str:
    return "\n".join(part for part in parts if part)


def _elsewhere(n: int, j: int, letter: str, behind: str) -> str:
    """Pressures at all nodes but `j`, of which that right behind it is given, and the flows into their inlets."""
    towards_pump = repeated(f"    {letter}_~_{j} = up_~ * {letter}_~+_{j}", range(j - 1, 0, -1))
    right_behind = f"    {letter}_{j + 1}_{j} = {behind}" if j < n else ""
    towards_tank = repeated(f"    {letter}_~_{j} = down_~ * {letter}_~-_{j}", range(j + 2, n + 1))
    others = [i for i in range(1, n + 1) if i != j]
    flows = repeated(f"    by_{letter}_~_{j} = v_~.inlet * {letter}_~_{j}", others)
    return _joined([towards_pump, right_behind, towards_tank, flows])


def _over_port(n: int, j: int) -> str:
    return f"""    # pressures and flows over the port pressure of valve {j}
    rest_{j} = to_tank_{j} + to_pump_{j}
    p_{j}_{j} = divider(v_{j}.inlet, rest_{j})
    by_p_{j}_{j} = -v_{j}.inlet * divider(rest_{j}, v_{j}.inlet)
{_elsewhere(n, j, "p", f"down_{j + 1} * p_{j}_{j}")}"""


def _over_spool(n: int, j: int) -> str:
    before, beyond = f"v_{j}.inlet + to_pump_{j}", f"v_{j + 1}.inlet + to_tank_{j + 1}"
    source, bypass = f"v_{j}.bypass_source", f"v_{j}.bypass"
    falls = f"fall_before({source}, {bypass}, {before}, {beyond})" if j < n else f"fall({source}, {before} + {bypass})"
    rises = f"fall_before({source}, {bypass}, {beyond}, {before})"
    return f"""    # pressures and flows over the spool of valve {j}, of what its inlet takes and its bypass passes on
    taken_{j} = fall(v_{j}.inlet_source, v_{j}.inlet + rest_{j})
    passed_on_{j} = {falls}
    x_{j}_{j} = -taken_{j} - passed_on_{j}
    by_x_{j}_{j} = v_{j}.inlet_source * divider(rest_{j}, v_{j}.inlet) - v_{j}.inlet * passed_on_{j}
{_elsewhere(n, j, "x", f"{rises} - down_{j + 1} * taken_{j}")}"""
