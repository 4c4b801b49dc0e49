"""What a layout has, as the lists that pages loop over."""

from collections.abc import Mapping
from itertools import pairwise

from polydraulic.flow.layout.model import STORING
from polydraulic.machine.actuator import Triangle
from polydraulic.machine.drives import Motor, Ram, Rocker
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import (
    CIRCUIT,
    MORE_STATE,
    STATE,
    columns_of,
    cross_name,
    gap_name,
    has,
    stored_name,
)
from polydraulic.simulation.layout.expand import Rows, Value

_CLASSES = {"motor": Motor, "ram": Ram, "cylinder": Triangle, "four_bar": Rocker}


def page_lists(machine: LayoutMachine, tip: str, force: bool, flow: str = "exact") -> dict[str, Rows]:
    """Lists of the pages of a single machine, with a force at the tip or without; letters: F function, J its number, C circuit, I place in it, N length, P place in a row."""
    place = columns_of(machine, stores_oil=flow in STORING).place
    circuit_of = {f: (c.name, k) for c in machine.circuits for k, f in enumerate(c.functions, 1)}
    gaps = [(c.name, k, len(c.functions)) for c in machine.circuits for k in range(1, len(c.functions))]
    lists: dict[str, Rows] = {
        "FUNCTIONS": [
            {"F": f.name, "J": number, "D": f.actuator, "A": _CLASSES[f.actuator].__name__, "K": str(len(f.valve.knots)),
             "C": circuit_of[f.name][0], "I": str(circuit_of[f.name][1]), "S": "driven" if has(f, "driven") else "spool",
             "R": "viscous_torque" if f.effects.sticks else "friction_torque",
             "X": "sliding_torque" if f.effects.sticks else "friction_torque"}
            for number, f in enumerate(machine.functions)
        ],
        "TABLES": [{"F": f.name, "K": str(len(f.valve.knots))} for f in machine.functions if flow != "networks"],
        "CIRCUITS": [{"C": c.name, "N": str(len(c.functions))} for c in machine.circuits],
        "PLAIN_CIRCUITS": [{"C": c.name, "N": str(len(c.functions))} for c in machine.circuits if c.kind != "crossover"],
        "CROSSOVERS": [{**row, "P": place[cross_name(str(row["G"]))]} for row in crossover_rows(machine)],
        "ANY_CROSSOVER": [{"E": ""}] if machine.crossovers else [],
        "GAPS": [{"C": c, "I": str(k)} for c, k, _ in gaps],
        "QUANTITIES": [{"Q": quantity} for quantity, _ in STATE],
        "STATE_PLACES": [
            {"Q": q, "F": f.name, "P": place[f"{f.name}.{q}"]}
            for q, _ in (*STATE, *MORE_STATE) for f in machine.functions if has(f, q)
        ],
        "INLET_PLACES": [{"F": f, "P": place[f"{f}.q_in"]} for f in machine.names],
        "OUTLET_PLACES": [{"F": f, "P": place[f"{f}.q_out"]} for f in machine.names],
        "CIRCUIT_PLACES": [{"C": c.name, "W": q, "P": place[f"{c.name}.{q}"]} for c in machine.circuits for q, _ in CIRCUIT],
        "GAP_PLACES": [{"C": c, "I": str(k), "P": place[gap_name(c, k, n)]} for c, k, n in gaps],
    }  # fmt: skip
    stored: Rows = [
        {"C": c.name, "W": "q_stored", "P": place[stored_name(c.name)]} for c in machine.circuits if flow in STORING
    ]
    lists["CIRCUIT_PLACES"] = [*lists["CIRCUIT_PLACES"], *stored]
    lists["ANY_NETWORKS"] = [{"E": ""}] if flow in ("networks", "pressure", "residual") else []
    n = len(machine.names)
    lists["TIP"], lists["PUSHED"] = [{"T": tip}], [{"T": tip}] if force else []
    lists["UNPUSHED"] = [] if force else [{"E": ""}]
    lists["FORCE_PLACES"] = [{"P": n + k} for k in range(3)] if force else []
    lists["NO_FORCE"] = [] if force else [{"P": k} for k in range(3)]
    for c in machine.circuits:
        lists[f"FUNCTIONS_OF_{c.name}"] = [{"F": f} for f in c.functions]
    for quantity, _ in (*STATE, *MORE_STATE):
        of = [f for f in machine.functions if has(f, quantity)]
        lists[f"PLACES_OF_{quantity}"] = [{"P": place[f"{f.name}.{quantity}"]} for f in of]
    return lists | _flow_lists(machine, flow) | _effect_lists(machine)


def _effect_lists(machine: LayoutMachine) -> dict[str, Rows]:
    """Functions with an effect and those without, and lists of one row, or none, for what stands there if any has it."""
    functions = machine.functions
    holders = {
        "DRIVEN": [f for f in functions if has(f, "driven")],
        "SHIFTED": [f for f in functions if has(f, "flow_shift")],
        "LOOSE": [f for f in functions if has(f, "gap")],
        "STICKING": [f for f in functions if f.effects.sticks],
    }
    lists: dict[str, Rows] = {}
    for name, of in holders.items():
        number: dict[str, Mapping[str, Value]] = {
            f.name: {"F": f.name, "J": j, "K": str(len(f.valve.knots)), "S": "driven" if has(f, "driven") else "spool"}
            for j, f in enumerate(functions)
        }
        lists[name] = [number[f.name] for f in of]
        lists[f"NOT_{name}"] = [number[f.name] for f in functions if f not in of]
        lists[f"ANY_{name}"] = [{"E": ""}] if of else []
        lists[f"NONE_{name}"] = [] if of else [{"E": ""}]
    lists["ANY_VALVE_EFFECT"] = [{"E": ""}] if holders["DRIVEN"] or holders["SHIFTED"] else []
    lists["NO_VALVE_EFFECT"] = [] if lists["ANY_VALVE_EFFECT"] else [{"E": ""}]
    held = [(q, [f.name for f in functions if has(f, q)]) for q, _ in MORE_STATE]
    lists["MORE_QUANTITIES"] = [{"Q": q, "T": q.title().replace("_", "")} for q, of in held if of]
    lists |= {f"HOLDERS_OF_{q}": [{"F": f} for f in of] for q, of in held}
    for f in functions:
        fields = {"half_play": "float"} if has(f, "gap") else {}
        fields |= {"half_width": "float"} if has(f, "driven") else {}
        fields |= {"shift": "float", "lag": "float"} if has(f, "flow_shift") else {}
        lists[f"FIELDS_OF_{f.name}"] = [{"Q": field, "T": kind} for field, kind in fields.items()]
    return lists


def _flow_lists(machine: LayoutMachine, flow: str) -> dict[str, Rows]:
    """Lists of flow models.

    Of networks: F and G functions, E the first of two; T and P places of travels and pressures as inputs. Of pressures that are kept: P
    places in memory; of waves P and R, at both ends of the line before a valve.
    """
    shared = [c for c in machine.circuits if len(c.functions) > 1]
    ordered = [(c.name, f, place) for c in machine.circuits for place, f in enumerate(c.functions)]
    lists: dict[str, Rows] = {
        "FLOW_FIELDS": [{"Q": name, "T": kind} for name, kind in _flow_fields(machine, flow)],
        "FIRST": [{"C": c.name, "F": c.functions[0]} for c in machine.circuits],
        "SHARED": [{"C": c.name, "F": c.functions[0]} for c in shared],
        "LATER": [{"C": c.name, "F": f} for c in shared for f in c.functions[1:]],
        "PASSING": [{"C": c.name, "F": f, "G": g} for c in shared for f, g in pairwise(c.functions)],
        "LAST": [{"C": c.name, "F": c.functions[-1]} for c in machine.circuits],
        "BACKWARDS": [
            {"C": c, "F": f, "I": str(place + 1), "O": str(place)} for c, f, place in reversed(ordered) if place
        ],
        "BY_CIRCUIT": [{"C": c, "F": f} for c, f, _ in ordered],
        "WAVES": [{"F": f, "P": 2 * k, "R": 2 * k + 1} for k, (_, f, _) in enumerate(ordered)],
        "BEGUN": [{"P": len(ordered) * (2 if flow == "tlm" else 1)}],
        "PUMP_MEMORY": [],
        "GAP_MEMORY": [],
    }
    kept = 0
    for c in machine.circuits:
        n = len(c.functions)
        lists[f"MEMORY_OF_{c.name}"] = [{"P": kept + k} for k in range(n)]
        lists["PUMP_MEMORY"] = [*lists["PUMP_MEMORY"], {"C": c.name, "P": kept}]
        gaps: Rows = [{"C": c.name, "I": str(k), "P": kept + k} for k in range(1, n)]
        lists["GAP_MEMORY"] = [*lists["GAP_MEMORY"], *gaps]
        kept += n
        lists[f"ALL_OF_{c.name}"] = [{"F": f, "T": k, "P": n + k} for k, f in enumerate(c.functions)]
        lists[f"TRAVELS_OF_{c.name}"] = [{"F": f, "T": k} for k, f in enumerate(c.functions)]
        lists[f"BEHIND_OF_{c.name}"] = [{"F": f, "P": n + k} for k, f in enumerate(c.functions[1:])]
        for place, f in enumerate(c.functions):
            rest = c.functions[place:]
            lists[f"FROM_{f}"] = [{"G": g, "T": 1 + k, "P": 1 + len(rest) + k} for k, g in enumerate(rest)]
            lists[f"SECOND_OF_{f}"] = [{"E": c.functions[0]}] if n == 2 and place else []
    return lists


def _flow_fields(machine: LayoutMachine, flow: str) -> list[tuple[str, str]]:
    """What a flow model has in the text's ``Valves`` besides orifice tables and pumps: name and type."""
    by_flow: dict[str, list[tuple[str, str]]] = {
        "exact": [],
        "iterative": [("sweeps", "Sweeps")],
        "stiff": [("volumes", "Volumes")],
        "tlm": [("tlm_lines", "TlmLines")],
        "lookup": [(f"lookup_{c.name}", f"FlowTable{len(c.functions)}") for c in machine.circuits],
        "pressure": [("table", "NetworkTable"), *((f"pressure_{f}", "PressureNetwork") for f in machine.names)],
        "residual": [("table", "NetworkTable"), *((f"residual_{f}", "ResidualNetwork") for f in machine.names)],
        "networks": [
            ("table", "NetworkTable"),
            *((f"networks_{f}", "ValveNetworks") for f in machine.names),
            *((f"passed_{c.name}", "PassedNetworks") for c in machine.circuits if len(c.functions) > 1),
        ],
    }
    return by_flow[flow]


def crossover_rows(machine: LayoutMachine) -> Rows:
    """X crossover, G giving and T taking circuit, N valves in all, F the function that it feeds, K knots of its valve."""
    fed = {x.name: machine.function(machine.circuit(x.taking).functions[-1]) for x in machine.crossovers}
    return [
        {
            "X": x.name,
            "G": x.giving,
            "T": x.taking,
            "N": str(len(machine.circuit(x.giving).functions) + 2),
            "F": fed[x.name].name,
            "K": str(len(fed[x.name].valve.knots)),
        }
        for x in machine.crossovers
    ]
