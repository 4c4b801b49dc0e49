"""Text of the slopes of a circuit of n valves in series, over port pressures and spools."""

from polydraulic.machine.circuits.wording import definitions, each, repeated

SERIES_SLOPES_IMPORTS = (
    "from typing import NamedTuple",
    "from polydraulic._kernel import kernel",
    "from polydraulic.machine.circuits.series_slopes import before_source, divider, in_row, linear, own_slope",
    "from polydraulic.machine.circuits.series_slopes import pump_conductance",
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
    # what a node sees beyond its inlet towards the tank, and without its inlet towards the pump
    to_tank_{n} = v_{n}.bypass
{repeated("    to_tank_~ = in_row(v_~.bypass, v_~+.inlet + to_tank_~+)", range(n - 1, 0, -1))}
    to_pump_1 = pump_conductance(s.circuit, pump)
{repeated("    to_pump_~ = in_row(v_~-.bypass, v_~-.inlet + to_pump_~-)", range(2, n + 1))}
    # pressure at a node as a share of that at the one before or behind it
{repeated("    down_~ = divider(v_~-.bypass, v_~.inlet + to_tank_~)", range(2, n + 1))}
{repeated("    up_~ = divider(v_~.bypass, v_~.inlet + to_pump_~)", range(1, n))}
{"".join(_ports(n, j) for j in valves)}{"".join(_spools(n, j) for j in valves).rstrip()}
    return Slopes{n}({", ".join([*_names("p", n), *_names("x", n)])})
'''


def _spread(n: int, j: int, towards_tank: str | None = None) -> str:
    """Pressures of all nodes from that of node `j`, and from that of the next one where it has a value of its own."""
    up = repeated(f"    p_~_{j} = up_~ * p_~+_{j}\n", range(j - 1, 0, -1))
    next_one = [f"    p_{j + 1}_{j} = {towards_tank or f'down_{j + 1} * p_{j}_{j}'}\n"] if j < n else []
    down = repeated(f"    p_~_{j} = down_~ * p_~-_{j}\n", range(j + 2, n + 1))
    return "".join([up, *next_one, down]).replace("\n\n", "\n")


def _ports(n: int, j: int) -> str:
    others = repeated(f"    by_p_~_{j} = v_~.inlet * p_~_{j}\n", [i for i in range(1, n + 1) if i != j])
    return f"""    # over the port pressure of valve {j}: pressures of all nodes, then flows
    share_{j} = own_slope(v_{j}.inlet, to_tank_{j} + to_pump_{j})
    p_{j}_{j} = 1.0 - share_{j}
{_spread(n, j)}    by_p_{j}_{j} = -v_{j}.inlet * share_{j}
{others}""".replace("\n\n", "\n")


def _spools(n: int, j: int) -> str:
    beyond = f"v_{j + 1}.inlet + to_tank_{j + 1}" if j < n else "_TANK"
    return ""
