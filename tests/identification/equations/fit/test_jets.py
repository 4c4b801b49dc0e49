"""Jets of a circuit's valves: conductance times drop, whatever sensors there are."""

import numpy as np
import pytest

from helpers.machine_log import machine_log
from polydraulic import load_machine
from polydraulic.identification.equations.fit.jets import jets_of
from polydraulic.identification.equations.sensors import AT_VALVE, Signals

MACHINE = load_machine("cat215b")
VALVE = MACHINE.function("boom").valve
CIRCUIT = MACHINE.circuit("boom")
NOISE = dict.fromkeys(("p_a", "p_b"), 1e5) | {"q_out": 8e-6}


def jets(spool, p_a, p_b, q_out=None, shares=None, machine=MACHINE):
    read = {"spool": spool, "p_a": p_a, "p_b": p_b} | ({} if q_out is None else {"q_out": q_out})
    s = Signals({what: np.full(12, value) for what, value in read.items()}, {}, NOISE)
    return jets_of(machine, CIRCUIT, {"boom": s}, np.zeros(12), shares or {}, {})["boom"]


def conductance(spool, curve):
    return float(np.interp(abs(spool), VALVE.knots, getattr(VALVE, curve)))


@pytest.mark.parametrize("spool", [8e-3, -8e-3])
def test_jets_are_conductance_times_drop(spool):
    """The pump's pressure is what its whole flow makes of a shut bypass."""
    full, low = np.copysign(VALVE.knots[-1], spool), 2e6
    ports = (1e7, 6e6) if spool > 0.0 else (6e6, 1e7)
    outlet = conductance(full, "outlet_positive" if spool > 0.0 else "outlet_negative")
    inlet = conductance(full, "inlet")
    by_hand = CIRCUIT.pump.flow**2 / inlet + outlet * (6e6 - MACHINE.tank.return_pressure)
    assert jets(full, *ports).strength == pytest.approx(np.full(12, by_hand), rel=1e-6)
    assert jets(0.0, *ports).strength == pytest.approx(np.zeros(12), abs=1e-6)
    assert jets(full, *ports).strength[0] > jets(full, *(p - low for p in ports)).strength[0]


def test_a_wide_outlet_is_known_by_its_flow_and_a_narrow_one_by_its_drop():
    wide, narrow = VALVE.knots[-1], VALVE.knots[1] + 2e-4
    for spool, by_flow in ((wide, True), (narrow, False)):
        k = conductance(spool, "outlet_positive")
        drop = 1e6
        more = [
            jets(spool, 1e7, MACHINE.tank.return_pressure + drop, q).strength[0]
            for q in (k * drop**0.5, 1.1 * k * drop**0.5)
        ]
        without = jets(spool, 1e7, MACHINE.tank.return_pressure + drop).strength[0]
        assert more[0] == pytest.approx(without, rel=1e-9)
        share = (more[1] - more[0]) / (0.21 * k * drop)  # 1 where the flow alone counts
        assert (share > 0.8) == by_flow
        assert 0.0 <= share <= 1.0


@pytest.mark.parametrize("flow", [False, True])
@pytest.mark.parametrize("spool", [6e-3, 8e-3, -1.2e-2])
def test_what_is_unsure_of_curves_is_unsure_of_jets(spool, flow):
    """As by differences, of each conductance at a knot on its own; a flow that is measured agrees with the drop."""
    outlet = conductance(spool, "outlet_positive" if spool > 0.0 else "outlet_negative")
    q_out, share = outlet * (6e6 - MACHINE.tank.return_pressure) ** 0.5 if flow else None, 0.01
    at = (spool, 1e7, 6e6, q_out) if spool > 0.0 else (spool, 6e6, 1e7, q_out)
    keys = ("inlet", "outlet_positive", "outlet_negative")
    none, of = jets(*at), jets(*at, shares={"boom": np.full(len(keys) * len(VALVE.knots), share)})
    assert not none.unsure.any()
    assert not none.moved.any()
    for number, own in enumerate(of.unsure):
        key, knot = keys[number // len(VALVE.knots)], number % len(VALVE.knots)
        strength = []
        for way in (1e-3, -1e-3):
            values = np.array(getattr(VALVE, key))
            values[knot] *= 1.0 + way
            f = MACHINE.function("boom")._replace(valve=VALVE._replace(**{key: tuple(values.tolist())}))
            others = tuple(f if other.name == "boom" else other for other in MACHINE.functions)
            strength.append(jets(*at, machine=MACHINE._replace(functions=others)).strength[0])
        slope = (strength[0] - strength[1]) / 2e-3
        assert own == pytest.approx(np.full(12, share * slope), rel=2e-2, abs=1e-5 * none.strength[0])
    assert of.unsure.any(axis=1).sum() >= 2


def test_noise_once_more_is_as_large_as_that_of_the_sensors():
    log = machine_log(120.0)
    s = Signals({what: log[f"boom.{what}"] for what in AT_VALVE}, {}, NOISE)
    noise = jets_of(MACHINE, CIRCUIT, {"boom": s}, log["segment"], {}, {})["boom"].noise
    open_ = log["boom.spool"] > VALVE.knots[3]
    drop = log["boom.p_b"] - MACHINE.tank.return_pressure > 1e6
    here = open_ & drop
    k = np.interp(log["boom.spool"][here], VALVE.knots, VALVE.outlet_positive)
    # a parabola through five rows leaves the root of 17/35 of white noise
    assert np.std(noise[here] / k) == pytest.approx(1e5 * np.sqrt(17.0 / 35.0), rel=0.15)


def test_rows_in_which_a_sensor_is_silent_have_no_jets():
    p_a = np.full(12, 1e7)
    p_a[:3] = np.nan
    q_out = np.full(12, 1e-3)
    q_out[-2:] = np.nan
    read = {"spool": np.full(12, 1e-2), "p_a": p_a, "p_b": np.full(12, 6e6), "q_out": q_out}
    s = Signals(read, {}, NOISE)
    found = jets_of(MACHINE, CIRCUIT, {"boom": s}, np.zeros(12), {}, {})["boom"]
    assert np.isnan(found.strength[:3]).all()
    assert np.isfinite(found.strength[3:]).all()
    assert found.at(np.isfinite(found.strength)).noise.shape == (9,)
    drop = conductance(1e-2, "outlet_positive") * (6e6 - MACHINE.tank.return_pressure)
    without = jets(1e-2, 1e7, 6e6).strength[0]
    assert found.strength[-1] == pytest.approx(without)
    assert abs(found.strength[5] - without) > 1e-3 * drop
