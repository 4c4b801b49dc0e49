from polydraulic import build_flow, load_scenario
from polydraulic.thesis.timing import time_runs


def test_models_are_timed_in_turn(machine, monkeypatch):
    turns, clock = [], iter(range(1000))
    names = {"a": build_flow("exact", machine), "b": build_flow("exact", machine, relief=False)}

    def run(model, *rest):
        turns.append("a" if model is names["a"] else "b")
        for _ in range(2 if model is names["a"] else 6):
            next(clock)

    monkeypatch.setattr("polydraulic.thesis.timing.run", run)
    monkeypatch.setattr("polydraulic.thesis.timing.perf_counter", lambda: float(next(clock)))
    found = time_runs(machine, names, load_scenario("single_08"), repeats=3)
    assert turns == ["a", "b"] * 4  # the first turn is not counted
    assert found == {"a": 3.0, "b": 7.0}
