import datetime

import numpy as np
import pytest

from polydraulic import units
from polydraulic.cli.application import METRIC
from polydraulic.display import (
    DEFAULT,
    SYSTEMS,
    amount,
    as_drawn,
    as_shown,
    moment,
    quantity_of,
    readable,
    shown_unit,
    time_axis,
    with_unit,
)
from polydraulic.errors import InputError


def test_every_unit_shown_measures_the_same_as_the_si_unit_it_stands_for():
    for system in SYSTEMS.values():
        assert all(units.si_unit(si) == si == units.si_unit(read) for si, read in system.items())
    assert SYSTEMS["metric"].keys() == SYSTEMS["field"].keys()
    assert METRIC == DEFAULT == "metric"


@pytest.mark.parametrize(
    ("value", "unit", "metric", "field", "si"),
    [
        (14.3e6, "Pa", "143 bar", "2074 psi", "14300000 Pa"),
        (0.0028, "m3/s", "168 l/min", "170.9 in3/s", "0.0028 m3/s"),
        (0.25, "m", "250 mm", "9.843 in", "0.25 m"),
        (np.pi / 3, "rad", "60 deg", "60 deg", "1.047 rad"),
        (25e3, "N/m", "25 N/mm", "142.8 lbf/in", "25000 N/m"),
        (0.5, "V", "0.5 V", "0.5 V", "0.5 V"),
        (90.0, "psi", "90 psi", "90 psi", "90 psi"),  # of a table of its own
        (0.3, "1", "0.3", "0.3", "0.3"),
        (np.float64(7.0), "", "7", "7", "7"),
    ],
)  # fmt: skip
def test_amounts_in_all_systems(value, unit, metric, field, si):
    assert (amount(value, unit), amount(value, unit, "field"), amount(value, unit, "si")) == (metric, field, si)


def test_another_system_is_named():
    with pytest.raises(InputError, match=r"units = 'imperial': choose one of \['metric', 'field', 'si'\]"):
        shown_unit("Pa", "imperial")


def test_numbers_are_written_out_where_they_can_be():
    assert [readable(value) for value in (0.0, 12345.6, 1e-9, -3.0e6, 2.5e9)] == [
        "0",
        "12350",
        "1e-09",
        "-3000000",
        "2.5e+09",
    ]


def test_labels_name_the_quantity():
    assert with_unit(quantity_of("boom.p_pump"), "bar") == "pump pressure [bar]"
    assert with_unit("share", "1") == with_unit("share", "") == "share"
    assert quantity_of("temperature") == "temperature"


def test_times_of_logs_with_a_date_are_dates():
    noon = datetime.datetime(2026, 3, 1, 12, tzinfo=datetime.UTC).timestamp()
    assert (moment(noon), moment(75.25)) == ("2026-03-01 12:00:00", "75.25 s")
    seconds = np.array([0.0, np.nan, 1.5])
    at, label = time_axis(seconds, noon)
    assert label == "time of day, 2026-03-01"
    assert time_axis(np.array([0.0, 90000.0]), noon)[1] == "date and time, 2026-03-01 to 2026-03-02"
    assert str(at[2]) == "2026-03-01T12:00:01.500000"
    assert np.isnat(at[1])
    at, label = time_axis(seconds)
    assert (at is seconds, label) == (True, "time [s]")
    assert as_shown(2e5, "Pa", "metric") == 2.0


def test_names_in_pictures_are_no_formulas_and_not_longer_than_the_picture():
    assert as_drawn(r"$x_{$") == r"\$x_{\$"
    assert as_drawn("p_{ %") == "p_{ %"
    assert as_drawn("q" * 300) == "q" * 79 + "…"
