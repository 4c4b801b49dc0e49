import numpy as np
import pytest

from polydraulic.studies.adaptation_study import adaptive_flow, operator_run, torque_limit_study, worn_pump_study


@pytest.mark.slow
def test_networks_learn_a_torque_limit_that_they_never_saw(machine):
    found = torque_limit_study(machine, minutes=2, judges=(2000, 2001), seconds=20.0)
    for link in ("boom", "swing"):
        fitted, adapted = found[f"{link}.fitted"], found[f"{link}.adapted"]
        assert adapted[0] == fitted[0] == fitted[-1]
        assert adapted[-1] < 0.6 * fitted[-1]
    assert found["tip.adapted"][-1] < 0.6 * found["tip.fitted"][-1]
    assert all(np.all(np.isfinite(values)) for values in found.columns.values())


@pytest.mark.slow
def test_networks_follow_a_pump_that_wears_and_its_replacement(machine):
    found = worn_pump_study(machine, loss=0.1, minutes=2, after=2, judges=(2000, 2001), seconds=20.0)
    assert found["delivery"].tolist() == [1.0, 0.95, 0.9, 1.0, 1.0]
    swing = found["swing.adapted"] / found["swing.fitted"]
    assert swing[2] < 0.5
    assert found["swing.adapted"][4] < 0.5 * found["swing.adapted"][3]  # the new pump is noticed
    assert found["swing.adapted"][3] > 2.0 * found["swing.fitted"][3]  # though not at once


@pytest.mark.slow
def test_reset_gives_the_fitted_flows_back(machine):
    adaptive = adaptive_flow(machine)
    adaptive.take_in(operator_run(machine, 1, 5.0))
    changed = [adapter.model() for adapter in adaptive.adapters.values()]
    for adapter in adaptive.adapters.values():
        adapter.reset()
    fitted = [adapter.model() for adapter in adaptive.adapters.values()]
    assert all(one != other for one, other in zip(fitted, changed, strict=True))
    assert fitted == [adapter.model() for adapter in adaptive_flow(machine).adapters.values()]
