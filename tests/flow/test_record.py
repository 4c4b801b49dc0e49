"""The list of columns, and the kernels that write by plain numbers, say the same."""

import numpy as np
import pytest

from polydraulic.flow.interface import OK, Flows
from polydraulic.flow.record import (
    ANGLE,
    BOOM,
    COLUMNS,
    N_RECORD,
    N_STATE,
    P_BETWEEN,
    PLACE,
    Q_OUT,
    SERIES,
    STORED,
    circuit_columns,
    from_vector,
    link_columns,
    record_flows,
    store,
    to_vector,
    working_circuits,
)
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links, State
from polydraulic.parameters.schema import CIRCUITS, LINKS


def whole_row():
    """A row in which every value is another number, with the state, flows and outlet flows it was written from."""
    numbers = iter(range(1, 100))
    links = lambda: Links(*(float(next(numbers)) for _ in LINKS))  # noqa: E731
    state = State(*(links() for _ in State._fields))
    circuits = [Circuit(*(float(next(numbers)) for _ in Circuit._fields)) for _ in CIRCUITS]
    flows = Flows(links(), links(), *circuits, float(next(numbers)), OK)
    row, q_out = np.full(N_RECORD, np.nan), links()
    store(state, row)
    record_flows(flows, q_out, row)
    return row, state, flows, q_out


def test_every_value_of_a_row_stands_where_the_list_says():
    row, state, flows, q_out = whole_row()
    expected = {}
    for link in LINKS:
        expected |= {f"{link}.{name}": getattr(getattr(state, name), link) for name in State._fields}
        expected |= {f"{link}.q_in": getattr(flows.q_in, link), f"{link}.q_out": getattr(q_out, link)}
    for circuit in CIRCUITS:
        expected |= {f"{circuit}.{name}": value for name, value in getattr(flows, circuit)._asdict().items()}
    expected["series.p_between"] = flows.p_between
    assert {column.name: row[PLACE[column.name]] for column in COLUMNS} == expected


def test_places_are_the_first_of_their_values():
    row, state, flows, q_out = whole_row()
    assert tuple(row[ANGLE : ANGLE + 3]) == state.angle
    assert tuple(row[Q_OUT : Q_OUT + 3]) == q_out
    assert (row[BOOM], row[SERIES]) == (flows.boom.q_pump, flows.series.q_pump)
    assert (row[P_BETWEEN], row[STORED], row[STORED + 1]) == (
        flows.p_between,
        flows.boom.q_stored,
        flows.series.q_stored,
    )


def test_a_state_is_the_beginning_of_a_row():
    row, state, _, _ = whole_row()
    assert to_vector(state).tolist() == row[:N_STATE].tolist()
    assert from_vector(row) == state


@pytest.mark.parametrize("p_pump", [False, True])
@pytest.mark.parametrize("q_stored", [False, True])
def test_columns_of_links_and_circuits_make_up_the_row(p_pump, q_stored):
    found = [column for link in LINKS for column in link_columns(link)]
    found += [column for name in CIRCUITS for column in circuit_columns(name, p_pump=p_pump, q_stored=q_stored)]
    left_out = set(COLUMNS) - set(found)
    assert len(found) == len(set(found))
    assert any(name.endswith(".p_pump") for name, _ in left_out) != p_pump
    assert any(name.endswith(".q_stored") for name, _ in left_out) != q_stored
    assert ("series.p_between" in {name for name, _ in left_out}) != p_pump


def test_a_circuit_works_while_one_of_its_links_may_move():
    assert working_circuits(()) == ["boom", "series"]
    assert working_circuits(("swing",)) == ["boom", "series"]
    assert working_circuits(("swing", "stick")) == ["boom"]
    assert working_circuits(("boom",)) == ["series"]
