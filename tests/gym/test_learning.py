"""The example that learns, cut short: even a few rounds of few trials bring more than rest."""

import runpy
from pathlib import Path

EXAMPLE = Path(__file__).parents[2] / "examples" / "learn_to_reach.py"


def test_a_few_rounds_improve_the_policy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = EXAMPLE.read_text()
    for whole, less in (
        ("= 60, 32, 4, 16, ", "= 10, 8, 4, 4, "),
        ('machine="wheel_loader"', 'machine="wheel_loader", max_episode_steps=60'),
    ):
        assert whole in text
        text = text.replace(whole, less)
    (tmp_path / "short.py").write_text(text.replace("assert learnt > none + 1.0", ""))
    found = runpy.run_path("short.py")
    assert found["learnt"] > found["none"] + 0.2
    assert min(found["curve"][-3:]) > found["curve"][0]
    assert (tmp_path / "learning.png").stat().st_size > 5000
