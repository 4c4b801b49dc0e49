"""The table of keys in docs/your_machine.md is that of the schema."""

import re
from typing import get_type_hints

from helpers.pages import ROOT
from polydraulic.parameters.layout.chassis import WEIGHT, Slope, Tracks
from polydraulic.parameters.layout.parts import (
    CONDUCTANCE,
    MASS,
    MOMENT,
    OPENING,
    POINT,
    TRAVEL,
    CrossoverValve,
    CylinderSize,
    FlowForce,
    FourBar,
    LinkParameters,
    MachineFunction,
    PumpParameters,
    Seen,
    SlideFriction,
    SlideInitial,
    SlideStops,
    SupplyCircuit,
    ValveCurves,
)
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.quantity import leaf_of
from polydraulic.parameters.schema import Friction, Initial, Line, Pilot, Stops, SwingMotor, Tank

PAGE = (ROOT / "docs" / "your_machine.md").read_text(encoding="utf-8")
ROW = re.compile(r"^\| (\w+) \| `(\w+)`(?: or `(\w+)`)? \| ([^|]+?) \|", re.MULTILINE)
PARTS = {
    "tank": (Tank,), "motor": (SwingMotor,), "cylinder": (CylinderSize,), "pilot": (Pilot,), "line": (Line,), "pump": (PumpParameters,),
    "flow_force": (FlowForce,), "friction": (Friction, SlideFriction), "stops": (Stops, SlideStops), "initial": (Initial, SlideInitial),
}  # fmt: skip


def units(part):
    """Key and unit of each entry of a part; a switch has no unit."""
    leaves = {key: leaf_of(hint) for key, hint in get_type_hints(part, include_extras=True).items()}
    return [(key, leaf.quantity.unit if leaf.quantity else "text") for key, leaf in leaves.items()]


def described():
    """Rows of tables, keys and units as the schema has them."""
    rows = set()
    for table, parts in PARTS.items():
        for alike in zip(*map(units, parts), strict=True):
            keys, measured = zip(*alike, strict=True)
            rows.add((table, *dict.fromkeys(keys), " or ".join(dict.fromkeys(measured))))
    rows |= {("valve", key, TRAVEL.unit if key == "knots" else CONDUCTANCE.unit) for key in ValveCurves._fields}
    rows |= {("friction", "sticks", "text"), ("functions", "backlash", "rad or m"), ("valve", "hysteresis", "m")}
    special = {"at": POINT.unit, "cg": POINT.unit, "mass": MASS.unit, "inertia": MOMENT.unit}
    rows |= {("links", key, special.get(key, "text")) for key in LinkParameters._fields if key != "name"}
    rows |= {("functions", key, "text") for key in ("moves", "actuator", "role")}
    rows |= {("functions", key, POINT.unit) for key in ("rod_pin", *FourBar._fields)}
    rows |= {
        ("crossover", key, CONDUCTANCE.unit if key == "conductance" else OPENING.unit) for key in CrossoverValve._fields
    }
    rows |= {("chassis", "mass", WEIGHT.unit), *(("chassis", key, POINT.unit) for key in ("cg", "contacts"))}
    rows |= {("tracks", "at", POINT.unit), *(("tracks", *row) for row in units(Tracks))}
    rows |= {("slope", *row) for row in units(Slope)}
    rows |= {("seen", key, TRAVEL.unit if key == "travel" else OPENING.unit) for key in Seen._fields}
    rows |= {("circuits", key, "text") for key in SupplyCircuit._fields if key not in ("name", "pump")}
    return rows | {
        ("top", "title", "text"),
        ("top", "gravity", "m/s2"),
        ("tip", "link", "text"),
        ("tip", "at", POINT.unit),
    }


def test_the_table_of_keys_is_that_of_the_schema():
    found = [tuple(part for part in row if part) for row in ROW.findall(PAGE[PAGE.index("## All keys") :])]
    assert len(found) == len(set(found))
    assert set(found) == described()


def test_no_part_of_the_schema_is_left_out():
    """A new field of a function or a machine needs a place in the table, and here."""
    assert set(MachineFunction._fields) == {
        "name",
        "moves",
        "actuator",
        "drive",
        "pins",
        "pilot",
        "valve",
        "line",
        "friction",
        "stops",
        "initial",
        "effects",
        "role",
        "seen",
    }
    assert set(LayoutMachine._fields) == {
        "title",
        "gravity",
        "tank",
        "links",
        "functions",
        "circuits",
        "tip",
        "crossovers",
        "chassis",
    }
