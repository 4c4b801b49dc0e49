import json
import re

from helpers.logs_made import healthy, imported, lose, put
from polydraulic.display import readable
from polydraulic.measure import write_quality
from polydraulic.measure.checks.channel_check import value_in


def frozen(columns):
    return put(columns, "p_head", slice(1000, 1300), columns["p_head"][999])


def test_faults_stand_in_the_report(tmp_path):
    columns = frozen(put(healthy(), "p_head", [10, 20], 999.0))
    found = imported(tmp_path, lose(columns, slice(2000, 2050)))
    write_quality(found, tmp_path / "quality.html")
    data = json.loads((tmp_path / "quality.json").read_text())
    assert [(f["kind"], f["channel"]) for f in data["findings"]] == [
        ("implausible", "p_head"), ("gap", "time"), ("frozen", "p_head"),
    ]  # fmt: skip
    page = (tmp_path / "quality.html").read_text()
    assert "1 error(s), 2 warning(s)" in page
    assert "1000 to 1300" in page
    assert page.count("<svg") == 2  # signals, and the map of both inputs
    assert "http" not in re.sub(
        r'xmlns(:\w+)?="[^"]*"|<!DOCTYPE[^>]*>|<metadata>.*?</metadata>', "", page, flags=re.DOTALL
    )


def test_the_picture_tells_the_ends_of_every_channel(tmp_path):
    columns = put(healthy(), "p_head", slice(None), 123.0)
    found = imported(tmp_path, columns)
    write_quality(found, tmp_path / "quality.html")
    picture = (tmp_path / "quality.html").read_text().split("<svg")[1]
    assert "nan" not in picture
    texts = [text.strip() for text in re.findall(r"<text[^>]*>([^<]*)</text>", picture)]
    for check in found.checks:
        unit = found.shown("metric")[check.channel.name]
        ends = {readable(value_in(check, unit, end), 3) for end in (check.low, check.high)}
        assert ends <= set(texts)
    assert texts.count("123") == 1  # a channel that never changes has one value
