import io
import itertools

import numpy as np
import pytest

from helpers.made_runs import small_crane
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.parameters.load import machine_names
from polydraulic.plotting import draw_machine


def texts(figure):
    return [text.get_text() for axis in figure.axes for text in axis.texts] + [t.get_text() for t in figure.texts]


def test_all_parts_have_their_names():
    found = texts(draw_machine("cat215b_bucket"))
    pins = ["joint", "base", "rod pin"]
    assert {"swing", "boom", "stick", "bucket", "tip"} <= set(found)
    assert {f"{name} {pin}" for name in ("boom", "stick") for pin in pins} <= set(found)
    assert {f"bucket {pin}" for pin in ("joint", "base", "hinge", "knee", "pin")} <= set(found)
    assert {"-145 deg", "-28 deg"} <= set(found)
    assert found[-5:] != found[:5]
    assert "Caterpillar 215B excavator, with bucket" in found
    assert "-115 deg to 25 deg, begins at -40 deg" in found
    assert "all round, begins at 0 deg" in found


def test_a_joint_that_slides_is_told_by_its_lengths():
    found = texts(draw_machine(small_crane()))
    assert "moves extension, 0 mm to 1100 mm, begins at 200 mm" in found
    assert "1100 mm" in found
    found = texts(draw_machine(small_crane(), units="field"))
    assert "moves extension, 0 in to 43.31 in, begins at 7.874 in" in found


def test_no_range_runs_off_the_page():
    for name in machine_names():
        figure = draw_machine(name)
        assert all(text.get_window_extent().x1 <= figure.bbox.width for text in figure.texts)


def test_all_that_a_machine_stands_on_is_in_the_picture():
    machine = load_machine("wheel_loader")
    for axis, place in zip(draw_machine(machine).axes, ([0, 2], [0, 1]), strict=True):
        (contacts,) = (line for line in axis.lines if line.get_marker() == "^")
        (middle,) = (line for line in axis.lines if line.get_marker() == "P")
        expected = np.array(machine.chassis.corners)[:, place]
        assert np.sort(contacts.get_xydata(), axis=0) == pytest.approx(np.sort(expected, axis=0))
        for line in (contacts, middle):
            assert np.all((axis.viewLim.min < line.get_xydata()) & (line.get_xydata() < axis.viewLim.max))


@pytest.mark.parametrize("units", ["metric", "field"])
def test_names_and_the_lines_to_them_do_not_cover_names(units):
    for machine in (*(load_machine(name) for name in machine_names()), small_crane()):
        axis = draw_machine(machine, units=units).axes[0]
        boxes = [text.get_window_extent() for text in axis.texts]
        assert len(boxes) > 8
        assert not any(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))
        leading = [axis.transData.transform(line.get_xydata()) for line in axis.lines if line.get_linewidth() == 0.6]
        assert leading  # from pins in a crowd, at least
        for point, end in leading:
            along = point + np.linspace(0.0, 0.97, 60)[:, None] * (end - point)  # its end touches its own name
            assert not any(box.contains(*spot) for box in boxes for spot in along)


def test_a_tall_picture_is_as_tall_as_the_machine_asks_for():
    heights = {name: draw_machine(name).get_size_inches()[1] for name in ("wheel_loader", "loader_crane")}
    assert 7.5 < heights["wheel_loader"] < heights["loader_crane"] < 11.0


def test_axes_tell_lengths_in_the_units_asked_for():
    for units, factor, label in (
        ("metric", 1e3, "outward [mm]"),
        ("field", 1.0 / 0.0254, "outward [in]"),
        ("si", 1.0, "outward [m]"),
    ):
        axis = draw_machine(small_crane(), units=units).axes[0]
        assert axis.get_xlabel() == label
        ticks = [
            (place, float(text.get_text()))
            for place, text in zip(axis.get_xticks(), axis.get_xticklabels(), strict=True)
        ]
        assert len(ticks) >= 4
        assert np.array([shown for _, shown in ticks]) == pytest.approx(
            factor * np.array([place for place, _ in ticks])
        )


def test_the_picture_has_the_moving_parts_in_it():
    """Nothing waits for an animation: what is drawn in a file differs from an empty view."""
    figure = draw_machine("cat215b")
    assert not any(artist.get_animated() for artist in figure.findobj())
    figure.savefig(io.BytesIO(), format="svg")


def test_what_cannot_be_drawn_is_named():
    with pytest.raises(InputError, match="units = 'imperial'"):
        draw_machine("cat215b", units="imperial")
    with pytest.raises(InputError, match="unknown parameter set 'nothing'"):
        draw_machine("nothing")
