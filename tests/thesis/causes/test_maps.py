"""Maps of sections B and C and outlets, with one change at a time."""

import pytest

from polydraulic.thesis.cache import Cache, Lab
from polydraulic.thesis.causes.maps import (
    bypass_of_boom,
    fewer_points,
    map_errors_as_printed,
    outlet_error,
    outlets_without_border,
)
from polydraulic.thesis.three_links import three_link_study


@pytest.mark.slow
def test_what_the_notes_name_changes_the_errors(machine):
    study = three_link_study(Lab(machine, Cache(None), Cache(None)))
    usual = map_errors_as_printed(study.machine(), study.historical())
    assert bypass_of_boom(study).b_shut < 0.5 * usual.b_shut
    assert fewer_points(study).c_largest > 15.0 > usual.c_largest  # 15 in3/s is printed
    for link, error in outlets_without_border(study).items():
        assert abs(error.spool) == pytest.approx(0.376, abs=0.01)
        assert abs(error.q_pop) > 10.0 * abs(outlet_error(study.machine(), link, study.historical()).q_pop)
