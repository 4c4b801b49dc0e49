import dataclasses

import numba
import numpy as np
import pytest

from helpers.flow_steps import PSI, Links, states, step, step_all, with_limit
from helpers.valves import changed
from polydraulic import build_flow
from polydraulic.errors import InputError
from polydraulic.flow import (
    OK,
    OUT_OF_DOMAIN,
)
from polydraulic.flow.polynomial import ARRANGEMENTS, shipped_models
from polydraulic.networks import Variable
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.thesis.excavator import pump_of, spool_of, with_pumps
from polydraulic.units import to_si

NETWORKS = [("polynomial", {}), ("polynomial", {"arrangement": "direct"}), ("polynomial-fine", {}), ("neural", {})]
RMS = {"polynomial": 0.01, "polynomial-fine": 0.002, "neural": 0.03}
N = 2_000 if numba.config.DISABLE_JIT else 20_000  # points of the map, of which plain Python makes few in a second


def test_pressures_beyond_training_are_reported(machine):
    model = build_flow("polynomial", machine)
    assert step(machine, model, 0.008, 3000 * PSI, 100 * PSI).status == OK
    assert step(machine, model, 0.008, 4600 * PSI, 100 * PSI).status == OUT_OF_DOMAIN


def boom_models():
    return [model for model in shipped_models() if model.output.name.startswith("boom.")]


def test_networks_must_fit_their_place(machine):
    k_out, q_in, _ = boom_models()
    with pytest.raises(InputError, match=r"needs one model of boom.k_out or boom.q_out; given are \['boom.q_in'\]"):
        build_flow("polynomial", machine, models=[q_in])
    swapped = type(q_in)(q_in.inputs[::-1], q_in.output, q_in.networks, q_in.partition)
    with pytest.raises(InputError, match="the model of 'boom.q_in' reads .*'boom.p_in', 'boom.travel'"):
        build_flow("polynomial", machine, models=[swapped, k_out])
    inches = (Variable("boom.travel", "in"), q_in.inputs[1])
    with pytest.raises(InputError, match=r"has boom.travel \[in\]; the circuit computes in SI"):
        build_flow("polynomial", machine, models=[dataclasses.replace(q_in, inputs=inches), k_out])
    with pytest.raises(InputError, match="a flow model needs those of all functions of a circuit"):
        build_flow("polynomial", machine, models=[])
    with pytest.raises(InputError, match="arrangement = 'parallel': choose one of"):
        build_flow("polynomial", machine, arrangement="parallel")


@pytest.mark.parametrize(("name", "options"), NETWORKS)
def test_networks_of_both_circuits_are_near_exact(machine, name, options):
    """The root mean square over random states, as a share of the pump's flow: the worst states are in the report."""
    model, exact = build_flow(name, machine, **options), build_flow("exact", machine)
    errors = []
    for spool, p_in, p_out in states(machine, 400):
        p_in = p_in._replace(swing=min(p_in.swing, 3400 * PSI))
        ours, true = step_all(machine, model, spool, p_in, p_out), step_all(machine, exact, spool, p_in, p_out)
        errors.append(np.subtract(ours.q_in, true.q_in) / pump_of(machine, "series").flow)
        assert ours.k_out == pytest.approx(true.k_out, abs=2e-3 * max(machine.function("swing").valve.outlet_positive))
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < RMS[name])


def over_the_map(machine, section, n=N):
    """Travels and pressures at random in the box of the circuits, up to relief; half of them on faces and in corners.

    In section D both valves of the series circuit are open, and the first still passes something on.
    """
    rng, spool = np.random.default_rng(8), spool_of(machine)
    low, high = np.zeros(6), np.append(np.full(3, spool.end), np.full(3, pump_of(machine, "boom").relief))
    high[3] = machine.function("swing").line.relief
    if section == "D":
        low[[0, 2]], high[0] = np.nextafter(spool.deadband, 1.0), spool.bypass_closed
    unit = rng.random((n, 6))
    on_faces = (np.arange(n) % 2 == 0)[:, None] & (rng.random((n, 6)) < 0.4)
    unit[on_faces] = np.round(unit[on_faces])
    return np.split(np.clip(low + (high - low) * unit, low, high), 2, axis=1)


# Largest errors over the map that the package's networks may have, in3/s: swing, boom, stick.
# The finer networks have the smaller rms, and rare errors that are larger, where the stick's inlet just opens.
LARGEST = {
    ("polynomial", False, "whole"): (3.0, 0.7, 3.0),
    ("polynomial", False, "D"): (3.3, 0.7, 3.6),
    ("polynomial", True, "D"): (5.5, 0.7, 6.0),
    ("polynomial-fine", False, "whole"): (16.0, 0.1, 3.0),
    ("polynomial-fine", False, "D"): (16.0, 0.1, 3.0),
}


@pytest.mark.parametrize(("name", "limit", "section"), LARGEST)
def test_the_least_of_the_modes_is_near_exact_over_the_map(machine, name, limit, section):
    machine = with_limit(machine) if limit else machine
    spool, p_in = over_the_map(machine, section)
    ours, true = (sample_flow(machine, flow, spool, p_in, 0.0 * p_in) for flow in (name, "exact"))
    open_relief = true.p_pump >= pump_of(machine, "boom").relief * (1.0 - 1e-12)
    assert np.all(open_relief.sum(axis=0) > 0.01 * N)  # of both pumps
    assert np.all(
        np.abs(ours.q_in - true.q_in).max(axis=0) <= to_si(1.0, "in3/s") * np.array(LARGEST[name, limit, section])
    )


@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
def test_networks_of_the_torque_limit_come_with_machines_that_have_one(machine, arrangement):
    spool, p_in = over_the_map(machine, "D", min(N // 4, 2000))

    def flows(name, machine, **options):
        return sample_flow(machine, build_flow(name, machine, **options), spool, p_in, 0.0 * p_in).q_in

    true = flows("exact", with_limit(machine))
    ours = flows("polynomial", with_limit(machine), arrangement=arrangement)
    asked = flows("polynomial", with_limit(machine), models=shipped_models(arrangement, limited=True))
    unaware = flows("polynomial", with_limit(machine), models=shipped_models(arrangement))
    assert np.array_equal(ours, asked)
    assert np.array_equal(unaware, flows("polynomial", machine, arrangement=arrangement))
    wrong = np.sqrt(np.mean((unaware - true) ** 2, axis=0))
    assert np.all(np.sqrt(np.mean((ours - true) ** 2, axis=0)) < 0.1 * wrong)


def test_the_torque_limit_of_one_pump_is_that_of_its_circuit_alone(machine):
    spool, p_in = over_the_map(machine, "D", 200)

    def flows(machine):
        return sample_flow(machine, build_flow("polynomial", machine), spool, p_in, 0.0 * p_in).q_in

    limited = {c.name: c for c in with_limit(machine).circuits}
    none, both = flows(machine), flows(with_limit(machine))
    for name in limited:
        one = flows(machine._replace(circuits=tuple(limited[name] if c.name == name else c for c in machine.circuits)))
        for place, function in enumerate(machine.names):
            of = both if function in limited[name].functions else none
            assert np.array_equal(one[:, place], of[:, place]), (name, function)
            assert np.any(both[:, place] != none[:, place])


@pytest.mark.parametrize("name", ["polynomial", "polynomial-fine", "neural"])
def test_networks_of_the_package_refuse_circuits_they_were_not_trained_on(machine, name):
    valve, pump = machine.function("boom").valve, pump_of(machine, "boom")
    slower = with_pumps(machine, torque_limit_start=0.9 * pump.torque_limit_start)
    heavier = machine.with_values({"links.boom.mass": 2e3})
    for known in (slower, heavier):  # a torque limit that is off, and what is no circuit
        build_flow(name, known)
    wider = tuple(1.1 * k for k in valve.inlet)
    others = {
        "circuits.boom.pump.flow": with_pumps(machine, flow=2.0 * pump.flow),
        "circuits.boom.pump.torque_limit_start": with_limit(slower),
        "functions.boom.valve.inlet": changed(machine, "boom", valve={"inlet": wider}),
    }
    for parameter, other in others.items():
        with pytest.raises(InputError, match=f"(?s){parameter} = .* in cat215b, whose circuits"):
            build_flow(name, other)
        build_flow("polynomial", other, models=shipped_models())  # whoever gives models knows what they are for


def test_modes_may_be_missing(machine):
    """Without them the input-flow networks answer for all modes: alone below relief pressure, and nothing enters at it."""
    models = [model for model in shipped_models() if model.output.name.split(".")[1] in ("q_in", "k_out")]
    assert len(models) == len(shipped_models()) - 3
    model, (boom,) = (
        build_flow("polynomial", machine, models=models),
        [m for m in models if m.output.name == "boom.q_in"],
    )
    relief, spool = pump_of(machine, "boom").relief, spool_of(machine).end
    for p in (0.0, 0.5 * relief, np.nextafter(relief, 0.0)):
        expected = min(max(boom.predict([[spool, p]])[0], 0.0), pump_of(machine, "boom").flow)
        assert step(machine, model, spool, p, 0.0).q_in.boom == expected
    assert step(machine, model, spool, relief, 0.0).q_in.boom == 0.0
    spool = Links(0.3 * spool_of(machine).bypass_closed, 0.0, spool_of(machine).end)  # the swing's is in its deadband
    passed = Links(0.0, 0.0, 40e5)
    (stick,) = (m for m in models if m.output.name == "stick.q_in")
    expected = stick.predict([[pump_of(machine, "series").flow, spool.stick, passed.stick]])[0]
    assert step_all(machine, model, spool, passed, Links(0.0, 0.0, 0.0)).q_in.stick == expected


def test_the_first_valve_shut_off_passes_nothing_on(machine):
    spool = Links(spool_of(machine).end, 0.0, spool_of(machine).end)
    for name, options in NETWORKS:
        flows = step_all(
            machine, build_flow(name, machine, **options), spool, Links(1e6, 1e6, 1e6), Links(1e5, 1e5, 1e5)
        )
        assert flows.q_in.stick == 0.0
        assert flows.q_in.swing == pytest.approx(pump_of(machine, "series").flow, rel=0.02)


def test_nothing_enters_a_line_at_relief_pressure(machine):
    p, travel = pump_of(machine, "boom").relief, spool_of(machine).end
    for name, options in NETWORKS:
        model = build_flow(name, machine, **options)
        assert step_all(machine, model, Links(travel, travel, travel), Links(p, p, p), Links(0.0, 0.0, 0.0)).q_in == (
            0,
            0,
            0,
        )


def test_a_name_gives_one_model_for_all_machines_with_the_same_circuits(machine):
    flow = build_flow("polynomial", machine)
    heavier = machine.with_values({"links.boom.mass": 1.1 * machine.link("boom").mass})
    assert build_flow("polynomial", heavier) is flow
    assert build_flow("polynomial", "cat215b") is flow
    assert build_flow("polynomial", with_limit(machine)) is not flow
    assert build_flow("polynomial", machine, arrangement="direct") is not flow
    assert build_flow("polynomial-fine", machine) is not flow
    assert build_flow("neural", machine) is not flow
    with pytest.raises(ValueError, match="read-only"):
        flow.parts["table"].coef[0, 0] = 1.0
