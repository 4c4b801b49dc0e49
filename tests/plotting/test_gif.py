import pytest
from PIL import Image

from helpers.made_runs import made_run, small_crane
from polydraulic.plotting.animation import write_animation


def test_a_gif_lasts_as_long_as_the_run(machine, whole, tmp_path):
    seen = []
    write_animation(whole, machine, tmp_path / "run.gif", rate=10.0, progress=lambda *done: seen.append(done))
    with Image.open(tmp_path / "run.gif") as image:
        durations = []
        for number in range(image.n_frames):
            image.seek(number)
            durations.append(image.info["duration"])
        assert image.n_frames > 2
        assert sum(durations) == 700
        assert image.info["loop"] == 0
        assert image.convert("RGB").getpixel((image.width - 1, image.height - 1)) == (255, 255, 255)
    assert seen == [("frames", k, 7) for k in range(1, 8)]
    assert [path.name for path in tmp_path.iterdir()] == ["run.gif"]


def test_an_interrupted_gif_leaves_nothing(machine, whole, tmp_path):
    def stop(what, done, total):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_animation(whole, machine, tmp_path / "run.gif", progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_a_gif_of_any_layout_has_all_its_frames(tmp_path):
    crane = small_crane()
    write_animation({"made": made_run(crane)}, crane, tmp_path / "run.gif", rate=10.0)
    with Image.open(tmp_path / "run.gif") as image:
        assert image.n_frames == 11  # every frame differs from the one before
