"""Lags in words."""

from dataclasses import replace

from polydraulic.networks import Dynamics, JointStrength, Lag, Model, Network, Variable
from polydraulic.networks.model.lag_words import dynamic_notes, lags_in_words, strength_in_words

CONSTANT = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0)


def dynamic(output, *lags, raster=0.02):
    return Model(
        (Variable("x"),),
        Variable(output),
        (CONSTANT,),
        dynamics=Dynamics(tuple(Lag(*lag) for lag in lags), (-1.0, 2.5), raster),
    )


def test_numbers_that_follow_each_other_are_a_range():
    dynamics = Dynamics(tuple(Lag(*lag) for lag in [("u", 3), ("u", 1), ("u", 2), ("y", 1), ("y", 4)]))
    assert lags_in_words(dynamics) == "u 1 to 3; y 1, 4 rows ago"
    assert lags_in_words(Dynamics((Lag("u", 0), Lag("u", 1)))) == "u 0, 1 rows ago"


def test_models_of_the_same_lags_share_a_note_and_static_ones_have_none():
    static = Model((Variable("x"),), Variable("s"), (CONSTANT,))
    assert dynamic_notes([static]) == []
    (note,) = dynamic_notes([dynamic("y", ("u", 1)), static, dynamic("z", ("u", 1))])
    assert note == (
        "dynamic, a function of lagged values: u 1 rows ago, rows 0.02 s apart. Whoever calls it shifts them from row to row, "
        "and lets the output change from the last one y by -1 to 2.5, z by -1 to 2.5 at most"
    )
    assert len(dynamic_notes([dynamic("y", ("u", 1)), dynamic("z", ("u", 2), raster=None)])) == 2
    (angle,) = dynamic_notes([replace(dynamic("y", ("u", 1)), output=Variable("y", "rad"))])
    assert angle.endswith("y by -1 to 2.5 rad at most")


def test_what_is_known_of_strengths_is_said():
    model = dynamic("boom", ("u", 1))
    assert strength_in_words(model.dynamics) == ""
    known = replace(model.dynamics, strength=JointStrength(32, 0.034, 0.051, 2560.0, 1e-4))
    said = strength_in_words(known)
    assert "by 3.4% both ways and 5.1% of one way against the other" in said
    assert "for about 51.2 s;" in said
    assert "stays for about 2560 rows;" in strength_in_words(replace(known, raster=None))
    longer = replace(known, strength=replace(known.strength, memory=74321.0))
    assert "stays for about 1490 s;" in strength_in_words(longer)
    lasting = replace(known, strength=replace(known.strength, memory=2.5e6))
    assert "stays for hours;" in strength_in_words(lasting)
    first, second = dynamic_notes([replace(model, dynamics=known), dynamic("y", ("u", 1))])
    assert first.startswith("dynamic, a function")
    assert second.startswith("boom: as strong as in the mean; a run in Python or C, or as an FMU, follows strengths")
