"""Networks that name kinds of faults, in the C of a machine that is watched."""

from collections.abc import Mapping
from typing import NamedTuple

from polydraulic.export.exported import filled
from polydraulic.export.model_bundle import c_name
from polydraulic.export.translate.program import Program
from polydraulic.export.watch.texts import enumerators, strings
from polydraulic.watch.kernels.numbers import CERTAINTY, FAMILIAR, KIND
from polydraulic.watch.kernels.opinions import ask_networks
from polydraulic.watch.watch import FaultWatch


class NetworksInC(NamedTuple):
    """What they add to header and source, to the numbers, to the state, and to what is done with a row; nothing where there are none."""

    header: str = ""
    source: str = ""
    data: str = ""
    rooms: str = ""
    ask: str = ""


def networks_c(watch: FaultWatch, program: Program, texts: Mapping[str, str]) -> NetworksInC:
    """What the networks of a watch add to its C.

    Parameters
    ----------
    watch : FaultWatch
    program : Program
        Gets the kernel that asks them.
    texts : mapping
        Of the templates of the watch.
    """
    if watch.networks is None or watch.asked is None:
        return NetworksInC()
    name, judge, (kinds, room, slots) = texts["name"], watch.judge_parts, watch.asked
    examples = [judge.numbers, kinds, judge.work, judge.live, judge.marks, room, slots]
    program.entry(f"{name}_kernel_kind", ask_networks, examples)
    known = watch.networks.kinds
    more = {
        "kinds": enumerators(f"{name}_kind", map(c_name, known)),
        "n_kinds": str(len(known)),
        "names": strings(known),
        "kind": str(KIND),
        "certainty": str(CERTAINTY),
        "familiar": str(FAMILIAR),
    }
    header, source = filled("watch_networks", name, {**texts, **more}).values()
    ask = f"""    if (became >= {name.upper()}_ALARM) {{
        {name}_kernel_kind(&{name}_numbers, &{name}_kinds, w->work, w->live, w->marks, w->room, w->slots);
    }}
"""
    rooms = f"    double room[{len(room)}];\n    double slots[{len(slots)}];\n"
    return NetworksInC(header, source, program.scope.data(kinds, f"{name}_kinds", "static "), rooms, ask)
