import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.machine.tree.link_checks import check_tree
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.simulation.layout.text import layout_of
from polydraulic.simulation.layout.tree import tree_of


@pytest.fixture
def crane(tmp_path):
    return load_machine(write_crane(tmp_path))


def test_a_payload_is_a_point_mass_at_the_tip(crane):
    arm = with_payload(crane, 80.0).link("arm")
    assert arm.mass == 200.0
    assert arm.cg["x"] == pytest.approx((120 * 0.6 + 80 * 1.5) / 200)
    away = 120 * 80 / 200 * (1.5 - 0.6) ** 2  # reduced mass times distance squared
    assert arm.inertia["yy"] == pytest.approx(40 + away)
    assert arm.inertia["xx"] == pytest.approx(2.0)


def test_machines_with_any_payload_share_a_layout(crane):
    empty = with_payload(crane, 0.0).link("arm")
    assert empty.mass == 120.0
    assert empty.cg == crane.link("arm").cg
    assert layout_of(with_payload(crane, 0.0)) == layout_of(with_payload(crane, 80.0))


def test_a_tip_off_the_line_gives_products_of_inertia(crane):
    aside = with_payload(crane._replace(tip=("arm", {"x": 1.5, "z": -0.4})), 50.0)
    arm = aside.link("arm")
    assert arm.inertia["xz"] == pytest.approx(120 * 50 / 170 * 0.9 * 0.4)  # minus the integral of x z
    check_tree(tree_of(aside))
