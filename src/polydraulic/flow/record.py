"""What stands where in a state vector and in a row that a run records: said here, read everywhere else.

A row holds the state quantity by quantity, then the flows of the links, the pumps' values circuit by circuit, and the flows into
volumes that a flow model has of its own. Kernels leave Python as C, where a place is a plain number: those that read or
write whole rows stand here, below the list that they follow.
"""

from collections.abc import Collection
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.flow.interface import Flows
from polydraulic.machine.state import Links, State
from polydraulic.parameters.schema import CIRCUITS, LINKS


class Column(NamedTuple):
    """A value of a run, and its unit."""

    name: str
    unit: str


_STATE = (("spool", "m"), ("p_a", "Pa"), ("p_b", "Pa"), ("angle", "rad"), ("rate", "rad/s"))
_FLOWS = (("q_in", "m3/s"), ("q_out", "m3/s"))
_CIRCUIT = (("q_pump", "m3/s"), ("q_bypass", "m3/s"), ("q_relief", "m3/s"), ("p_pump", "Pa"))
_BETWEEN = Column("series.p_between", "Pa")
EFFECTOR = ("effector.x", "effector.y", "effector.z")  # m; follow from the angles

COLUMNS = (
    *(Column(f"{link}.{name}", unit) for name, unit in _STATE + _FLOWS for link in LINKS),
    *(Column(f"{circuit}.{name}", unit) for circuit in CIRCUITS for name, unit in _CIRCUIT),
    _BETWEEN,
    *(Column(f"{circuit}.q_stored", "m3/s") for circuit in CIRCUITS),
)
PLACE = {column.name: place for place, column in enumerate(COLUMNS)}
N_STATE, N_RECORD = len(_STATE) * len(LINKS), len(COLUMNS)

# first of three places, links in their order
SPOOL, P_A, P_B, ANGLE, RATE, Q_IN, Q_OUT = (PLACE[f"{LINKS[0]}.{name}"] for name, _ in _STATE + _FLOWS)
BOOM, SERIES = PLACE["boom.q_pump"], PLACE["series.q_pump"]  # first of a circuit's places
P_BETWEEN, STORED = PLACE[_BETWEEN.name], PLACE["boom.q_stored"]


def link_columns(link: str) -> list[Column]:
    """Columns of a link that moves."""
    return [Column(f"{link}.{name}", unit) for name, unit in _STATE + _FLOWS]


def circuit_columns(circuit: str, *, p_pump: bool, q_stored: bool) -> list[Column]:
    """Columns of a circuit, of a flow model that gives pressures of pumps or has volumes of its own."""
    found = [Column(f"{circuit}.{name}", unit) for name, unit in _CIRCUIT if p_pump or name != "p_pump"]
    found += [Column(f"{circuit}.q_stored", "m3/s")] if q_stored else []
    return found + ([_BETWEEN] if p_pump and circuit == "series" else [])


def working_circuits(locked: Collection[str]) -> list[str]:
    """Circuits of which a link may move."""
    return [circuit for circuit, links in CIRCUITS.items() if not set(links) <= set(locked)]


def to_vector(x: State) -> np.ndarray:
    """State as one vector of shape (15,), quantity by quantity: what an ODE solver owns."""
    return np.array([value for links in x for value in links], dtype=np.float64)


@kernel
def from_vector(v: np.ndarray) -> State:
    """State from a vector of shape (15,)."""
    return State(
        Links(v[0], v[1], v[2]),
        Links(v[3], v[4], v[5]),
        Links(v[6], v[7], v[8]),
        Links(v[9], v[10], v[11]),
        Links(v[12], v[13], v[14]),
    )


@kernel
def store(x: State, v: np.ndarray) -> None:
    """Write a state into the first 15 places of a vector."""
    v[0], v[1], v[2] = x.spool.swing, x.spool.boom, x.spool.stick
    v[3], v[4], v[5] = x.p_a.swing, x.p_a.boom, x.p_a.stick
    v[6], v[7], v[8] = x.p_b.swing, x.p_b.boom, x.p_b.stick
    v[9], v[10], v[11] = x.angle.swing, x.angle.boom, x.angle.stick
    v[12], v[13], v[14] = x.rate.swing, x.rate.boom, x.rate.stick


@kernel
def record_flows(flows: Flows, q_out: Links, row: np.ndarray) -> None:
    """Write flows and pump pressures into the places after the state."""
    row[15], row[16], row[17] = flows.q_in.swing, flows.q_in.boom, flows.q_in.stick
    row[18], row[19], row[20] = q_out.swing, q_out.boom, q_out.stick
    boom, series = flows.boom, flows.series
    row[21], row[22], row[23], row[24] = boom.q_pump, boom.q_bypass, boom.q_relief, boom.p_pump
    row[25], row[26], row[27], row[28] = series.q_pump, series.q_bypass, series.q_relief, series.p_pump
    row[29] = flows.p_between
    row[30], row[31] = boom.q_stored, series.q_stored
