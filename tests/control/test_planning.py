"""Whether a machine can follow a path between its stops: by name what ends it, and what would do."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.control import check_path, joints_at, run_controlled, straight_line, tip_path
from polydraulic.control.planning import followed_path

DIGGER = load_machine("cat215b_crossover")
PLACE = {"reach": 7.2, "height": -1.6, "pitch": -1.6}
TIP = [PLACE["reach"], PLACE["height"], 0.0, PLACE["pitch"]]


@pytest.fixture(scope="module")
def joints():
    return np.array(list(joints_at(DIGGER, **PLACE).values()))


def line(**changes):
    return straight_line(TIP, **({"length": 4.0, "slope": -0.3} | changes))


def test_a_line_that_the_bucket_cannot_follow_is_named_with_what_can_be_done(joints):
    words = r"after 2\.\d\d m of its 4\.00 m bucket comes to its high stop, at 25 deg; it can if its pitch turns by -45 deg on the way; or shorten it"
    with pytest.raises(InputError, match=words):
        check_path(DIGGER, line(), joints)
    check_path(DIGGER, line(turn=np.radians(-45.0)), joints)
    check_path(DIGGER, line(length=2.0), joints)
    with pytest.raises(InputError, match="bucket comes to its high stop"):
        check_path(DIGGER, line(turn=np.radians(-35.0)), joints)


def test_what_is_found_is_where_positions_of_its_places_reach_the_stop(joints):
    """The same line, place by place, by the search for joints at a place."""
    way, stop = followed_path(DIGGER, line(), joints).way, DIGGER.function("bucket").stops.high
    for share, inside in ((way - 0.05, True), (way + 0.05, False)):
        at = {"reach": 7.2 - share * np.cos(-0.3), "height": -1.6 + share * np.sin(-0.3), "pitch": -1.6}
        if inside:
            assert joints_at(DIGGER, **at)["bucket"] < stop
        else:
            with pytest.raises(InputError, match="cannot be brought"):
                joints_at(DIGGER, **at)


def test_an_arm_that_does_not_reach_further_is_named(machine):
    place = joints_at(machine, reach=7.0, height=-1.5)
    joints = np.array(list(place.values()))
    with pytest.raises(InputError, match=r"after 0\.46 m of its 9\.00 m stick comes to its high stop"):
        check_path(machine, straight_line([7.0, -1.5, 0.0, 0.0], length=-9.0), joints)
    with pytest.raises(InputError, match="stick comes to its low stop, at -145 deg; shorten it, or begin it elsewhere"):
        check_path(machine, straight_line([7.0, -1.5, 0.0, 0.0], length=6.0), joints)
    turned = tip_path([[7.0, -1.5, 0.0, 0.0], [7.0, -1.5, 400.0, 0.0]])  # rad of a swing without an end
    assert followed_path(machine, turned, joints) == (400.0, 400.0, None)
    # stops beyond what its linkage allows: the arm is stretched before one is met
    loose = tuple(f._replace(stops=f.stops._replace(high=3.0)) for f in machine.functions)
    longer = machine._replace(functions=loose)
    with pytest.raises(InputError, match="does not reach further; shorten it"):
        check_path(longer, straight_line([7.0, -1.5, 0.0, 0.0], length=-9.0), joints)
    # a leg on which the tip only turns has no metres
    far = tip_path([[7.0, -1.5, 0.0, 0.0], [7.0, -1.5, 1.0, 0.0], [16.0, -1.5, 1.0, 0.0]])
    with pytest.raises(InputError, match="after 15% of it stick comes to its high stop"):
        check_path(machine, far, joints)
    with pytest.raises(InputError, match="must be 3 finite positions, of swing, boom, stick"):
        check_path(machine, turned, joints[:2])


def test_an_arm_of_one_joint_goes_by_the_height():
    loader = load_machine("wheel_loader")
    start = np.array([-0.45, 0.3])
    up = straight_line([0.0, 0.0, 0.0, 0.0], length=0.5, slope=0.5 * np.pi)
    from polydraulic.control.runs import _tip

    tip = _tip(loader)(start)
    check_path(loader, up._replace(points=up.points + tip), start)
    far = straight_line(tip, length=9.0, slope=0.5 * np.pi)
    with pytest.raises(InputError, match=r"after 2\.96 m of its 9\.00 m lift comes to its high stop"):
        check_path(loader, far, start)


class Untouched:
    """A controller that nobody may call."""

    dt, lag, share, reference = 0.01, 0.0, np.ones(()), np.zeros(4)

    def reset(self):
        raise AssertionError("it began")


@pytest.mark.slow_to_compile
def test_a_run_along_it_does_not_begin(joints):
    start = {f"{name}.angle": at for name, at in zip(DIGGER.names, joints, strict=True)}
    with pytest.raises(InputError, match="bucket comes to its high stop"):
        run_controlled(
            DIGGER, Untouched(), lambda tip: straight_line(tip, length=4.0, slope=-0.3), start=start, settle=0.005
        )
