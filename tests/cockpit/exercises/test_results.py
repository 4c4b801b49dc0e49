import pytest

from polydraulic.cockpit.exercises.results import NAME, add_result, compared_attempts, read_results


def result(mode, seconds, *, finished=True):
    return {
        "machine": "m",
        "exercise": "trench",
        "mode": mode,
        "finished": finished,
        "values": {"time": [seconds, "s"], "error_rms": [0.1 * seconds, "m"]},
    }


def test_a_line_that_a_crash_has_torn_spoils_no_other(tmp_path):
    folder = tmp_path / "made"
    add_result(folder, result("joint", 1.0))
    with (folder / NAME).open("a") as file:
        file.write('{"machine": "m", "exer')
    add_result(folder, result("joint", 2.0))
    assert [found["values"]["time"][0] for found in read_results(folder)] == [1.0, 2.0]
    assert read_results(tmp_path / "none") == []


def test_finished_attempts_are_compared_by_mode():
    results = [result("joint", t) for t in (1.0, 5.0, 3.0)]
    results += [result("coordinated", 2.0), result("joint", 99.0, finished=False)]
    found = {group["mode"]: group for group in compared_attempts(results)}
    assert (found["joint"]["attempts"], found["coordinated"]["attempts"]) == (3, 1)
    assert found["joint"]["values"] == {"time": 3.0, "error_rms": pytest.approx(0.3)}


def test_attempts_with_the_guard_are_compared_apart():
    results = [result("coordinated", 2.0), *({**result("coordinated", t), "guard": True} for t in (4.0, 6.0))]
    # levers that move joints know no guard
    results += [{**result("joint", t), "guard": guard} for t, guard in ((1.0, True), (3.0, False))]
    found = {(g["mode"], g["guard"]): (g["attempts"], g["values"]["time"]) for g in compared_attempts(results)}
    assert found == {("coordinated", False): (1, 2.0), ("coordinated", True): (2, 5.0), ("joint", False): (2, 2.0)}


def test_a_result_that_is_no_number_is_refused(tmp_path):
    with pytest.raises(ValueError, match="JSON"):
        add_result(tmp_path, result("joint", float("nan")))
    assert read_results(tmp_path) == []
