import re

from polydraulic.measure import suggest_channels


def test_units_are_guessed_from_names_where_a_log_has_no_place_for_them(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text(
        "time,boom_speed_deg_per_sec,force_lift_MN,engine_speed_rps,p_A,lever [V],x_mm [m]\n"
        + "".join(f"{k},{k},{k},{k},{k},{k},{k}\n" for k in range(5))
    )
    text = suggest_channels(log)
    found = dict(re.findall(r'source = "(.*?)"\nrole = "input"\nunit = "(.*?)"', text))
    assert found == {
        "boom_speed_deg_per_sec": "deg/s", "force_lift_MN": "MN", "engine_speed_rps": "rev/s", "p_A": "", "lever": "V", "x_mm": "m",
    }  # fmt: skip
    assert text.count("from its name: the log itself does not tell") == 3
