from polydraulic import load_machine
from polydraulic.parameters.layout.skeleton import skeleton
from polydraulic.parameters.load import machine_text


def test_a_skeleton_is_a_machine_with_a_comment_for_each_kind_of_number(tmp_path):
    text = skeleton(machine_text("cat215b_bucket"), "cat215b_bucket")
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    assert load_machine(path) == load_machine("cat215b_bucket")
    comments = [line for line in text.split("\n") if line.startswith("# where this link's joint is")]
    assert len(comments) == 1
