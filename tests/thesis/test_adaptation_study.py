import numpy as np
import pytest

from polydraulic.flow.polynomial import shipped_models
from polydraulic.thesis.adaptation_study import (
    AT_RELIEF,
    SENSORS,
    WINDOW,
    adaptive_flow,
    measurements,
    operator_run,
    readings,
    torque_limit_study,
    worn_pump_study,
)
from polydraulic.thesis.excavator import pump_of, with_pumps

INLETS = {model.output.name: model for model in shipped_models() if model.output.name.endswith(".q_in")}


def test_exact_sensors_read_the_run_and_real_ones_are_noisy_late_and_sometimes_silent(machine):
    run = operator_run(machine, 1, 5.0)
    exact, real = (readings(run, sensors, 1) for sensors in SENSORS.values())
    assert np.allclose(exact["boom.spool"], run["boom.spool"][::4], rtol=0.0, atol=1e-15)
    heard = np.isfinite(real["boom.q_in"])
    assert 0.5 < np.mean([np.isfinite(values).mean() for values in real.columns.values()]) < 1.0
    error = (real["boom.q_in"] - exact["boom.q_in"])[heard]
    assert 0.0 < np.median(np.abs(error)) < 0.05 * pump_of(machine, "boom").flow


def test_measurements_are_means_of_times_in_which_spools_rest_below_relief(machine):
    machine = with_pumps(machine, torque_limit_enabled=False)
    read = readings(operator_run(machine, 1, 20.0), SENSORS["exact"], 1)
    for output, model in INLETS.items():
        X, y, weight = measurements(machine, read, model, output)
        on = weight > 0.0
        assert 0.1 < on.mean() < 0.9
        assert len(X) == len(y) == len(read["time"]) - WINDOW + 1
        k = int(np.flatnonzero(on)[0])
        assert y[k] == pytest.approx(read[output][k : k + WINDOW].mean())
        pump = read["boom.p_pump" if output == "boom.q_in" else "series.p_pump"]
        assert max(pump[k : k + WINDOW].max() for k in np.flatnonzero(on)) < AT_RELIEF * pump_of(machine, "boom").relief
        # where they count, they are what the networks were trained on
        assert np.median(np.abs(model.predict(X[on]) - y[on])) < 0.01 * pump_of(machine, "boom").flow
    read.columns["boom.p_a"][40:60] = np.nan
    read.columns["boom.p_b"][40:60] = np.nan
    weight = measurements(machine, read, INLETS["boom.q_in"], "boom.q_in")[2]
    assert not weight[40 - WINDOW + 1 : 60].any()
    assert measurements(machine, read, INLETS["swing.q_in"], "swing.q_in")[2].any()


def test_noise_alone_leaves_an_unchanged_machine_alone(machine):
    machine = with_pumps(machine, torque_limit_enabled=False)
    adaptive = adaptive_flow(machine, SENSORS["real"])
    adaptive.take_in(readings(operator_run(machine, 1, 30.0), SENSORS["real"], 1))
    exact = readings(operator_run(machine, 2, 30.0), SENSORS["exact"], 2)
    for output, adapter in adaptive.adapters.items():
        X, y, weight = measurements(machine, exact, INLETS[output], output)
        X, y = X[weight > 0.0], y[weight > 0.0]
        error = np.sqrt(np.mean((adapter.model().predict(X) - y) ** 2))
        assert adapter.model() != INLETS[output]
        assert error < 0.02 * pump_of(machine, "boom").flow


@pytest.mark.slow
def test_networks_learn_a_torque_limit_that_they_never_saw(machine):
    found = torque_limit_study(machine, minutes=2, judges=(2000, 2001), seconds=20.0)
    for link in ("boom", "swing"):
        for kind in SENSORS:
            fitted, adapted = found[f"{link}.fitted"], found[f"{link}.{kind}"]
            assert adapted[0] == fitted[0] == fitted[-1]
            assert adapted[-1] < 0.6 * fitted[-1]
    assert all(found[f"tip.{kind}"][-1] < 0.6 * found["tip.fitted"][-1] for kind in SENSORS)
    assert all(np.all(np.isfinite(values)) for values in found.columns.values())


@pytest.mark.slow
def test_networks_follow_a_pump_that_wears_and_its_replacement(machine):
    found = worn_pump_study(machine, loss=0.1, minutes=2, after=2, judges=(2000, 2001), seconds=20.0)
    assert found["delivery"].tolist() == [1.0, 0.95, 0.9, 1.0, 1.0]
    for kind in SENSORS:
        swing = found[f"swing.{kind}"]
        assert swing[2] < 0.5 * found["swing.fitted"][2]
        assert swing[4] < 0.7 * swing[3]  # the new pump is noticed
        assert swing[3] > 2.0 * found["swing.fitted"][3]  # though not at once


@pytest.mark.slow
def test_reset_gives_the_fitted_flows_back(machine):
    adaptive = adaptive_flow(machine)
    adaptive.take_in(readings(operator_run(machine, 1, 20.0), SENSORS["exact"], 1))
    changed = [adapter.model() for adapter in adaptive.adapters.values()]
    for adapter in adaptive.adapters.values():
        adapter.reset()
    fitted = [adapter.model() for adapter in adaptive.adapters.values()]
    assert all(one != other for one, other in zip(fitted, changed, strict=True))
    assert fitted == [adapter.model() for adapter in adaptive_flow(machine).adapters.values()]
