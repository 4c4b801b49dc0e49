"""Derivatives and the flows made of them."""

import numpy as np
import pytest

from polydraulic import load_scenario, simulate
from polydraulic.measure import add_flows, reconstruct_flow
from polydraulic.measure.columns_made import FlowChannel, RateChannel
from polydraulic.measure.flows import FlowStream, flow_statement, rate_statement
from polydraulic.measure.smoothing import window_length
from polydraulic.parameters.layout.geometry import triangle
from polydraulic.tables import Table
from polydraulic.thesis.excavator import spool_of

FLOW = FlowChannel("q", "stroke", 0.012, "p", 2e-11, 0.1)


def made(segments=((0, 300), (340, 700), (705, 708))):
    place = np.concatenate([np.arange(a, b) for a, b in segments])
    segment = np.concatenate([np.full(b - a, float(n)) for n, (a, b) in enumerate(segments)])
    time = 0.01 * place
    return Table(
        {"time": time, "segment": segment, "stroke": 0.3 * np.sin(time), "p": 1e7 + 5e6 * np.cos(2.0 * time)},
        {"time": "s", "segment": "1", "stroke": "m", "p": "Pa"},
    )


def test_a_flow_moves_the_actuator_and_compresses_the_oil():
    table = made()
    found = add_flows(table, [FLOW], 0.01)
    t = found["time"]
    assert found.unit("q") == "m3/s"
    assert len(found) == 660  # three rows are too few to be differentiated
    expected = 0.012 * 0.3 * np.cos(t) - 2e-11 * 1e7 * np.sin(2.0 * t)
    assert found["q"] == pytest.approx(expected, abs=2e-6)
    without = reconstruct_flow(table["stroke"][:300], 0.01, 0.012)
    assert without == pytest.approx(0.012 * 0.3 * np.cos(t[:300]), abs=1e-6)
    assert "friction does not enter; leakage is left out" in flow_statement(FLOW, 0.01)
    assert "wrong by C dp/dt" in flow_statement(FlowChannel("q", "stroke", 0.012), 0.01)


@pytest.mark.parametrize("size", [1, 7, 40, 1000])
def test_blocks_do_not_matter_for_flows(size):
    table = made()
    whole = add_flows(table, [FLOW], 0.01)
    stream, given = FlowStream(["stroke", "p"], [FLOW], 0.01), []
    for at in range(0, len(table), size):
        part = slice(at, at + size)
        given += stream.add(table["time"][part], table["segment"][part], [table["stroke"][part], table["p"][part]])
    given += stream.end()
    assert np.array_equal(np.concatenate([t for t, _, _ in given]), whole["time"])
    assert np.array_equal(np.concatenate([s for _, s, _ in given]), whole["segment"])
    assert np.concatenate([c[2] for _, _, c in given]) == pytest.approx(whole["q"], abs=1e-12)
    assert stream.too_short == 3


def test_the_flow_of_the_boom_is_found_from_its_stroke(machine):
    run = simulate(machine, "exact", load_scenario("random:5:20"), raster=0.01)
    boom = machine.function("boom")
    cylinder, pins = boom.drive, triangle(boom.pins, machine.link("boom"))
    psi = pins.offset + run["boom.angle"]
    stroke = np.sqrt(pins.r_base**2 + pins.r_rod**2 - 2.0 * pins.r_base * pins.r_rod * np.cos(psi))
    area = cylinder.number * np.pi / 4.0 * cylinder.bore**2
    with_oil = {"pressure": run["boom.p_a"], "compliance": boom.line.compliance_a}
    up = (run["boom.spool"] > spool_of(machine).deadband) & (run["boom.p_a"] > machine.tank.floor)
    errors = []
    for terms in (with_oil, {}):
        flow = reconstruct_flow(stroke, 0.01, area, window=0.05, **terms)
        errors.append(np.sqrt(np.mean((flow - run["boom.q_in"])[up] ** 2)) / np.max(run["boom.q_in"]))
    assert errors[0] < 0.05
    assert errors[0] < 0.5 * errors[1]


def test_a_rate_is_the_derivative_of_its_column_and_says_how_it_is_smoothed():
    table, rate = made(((0, 300),)), RateChannel("v", "stroke", 0.1)
    stream = FlowStream(["stroke", "p"], [FLOW, rate], 0.01)
    rows = [*stream.add(table["time"], table["segment"], [table["stroke"], table["p"]]), *stream.end()]
    v = np.concatenate([columns[-1] for _, _, columns in rows])
    assert v == pytest.approx(0.3 * np.cos(table["time"]), abs=1e-4)
    assert rate_statement(rate, "m/s", 0.01).startswith("v = d(stroke)/dt in m/s, by a cubic over 0.11 s: assumes that")


def test_what_is_made_of_a_silent_channel_lacks_values_within_half_a_window_of_it():
    table, rate = made(((0, 300),)), RateChannel("v", "stroke", 0.1)
    stroke, p = table["stroke"].copy(), table["p"].copy()
    stroke[100:150], p[200] = np.nan, np.nan
    found = []
    for cuts in ([300], [90, 120, 201, 300]):
        stream, given = FlowStream(["stroke", "p"], [FLOW, rate], 0.01), []
        for part in np.split(np.arange(300), cuts)[:-1]:
            given += stream.add(table["time"][part], table["segment"][part], [stroke[part], p[part]])
        given += stream.end()
        found.append([np.concatenate([c[k] for _, _, c in given]) for k in range(4)])
    assert all(np.array_equal(a, b, equal_nan=True) for a, b in zip(*found, strict=True))
    half = window_length(0.01, 0.1) // 2
    assert np.flatnonzero(np.isnan(found[0][3])).tolist() == list(range(100 - half, 150 + half))
    lacking = [*range(100 - half, 150 + half), *range(200 - half, 201 + half)]
    assert np.flatnonzero(np.isnan(found[0][2])).tolist() == lacking
    whole = add_flows(table, [FLOW], 0.01)[FLOW.name]
    known = ~np.isnan(found[0][2])
    assert found[0][2][known] == pytest.approx(whole[known], rel=1e-9, abs=1e-15)
