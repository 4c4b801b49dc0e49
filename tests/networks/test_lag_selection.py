from polydraulic.networks.lag_selection import Choice, Options, select

LADDER = (1, 2, 3, 4, 6, 8)


def chosen(error, **change):
    options = Options(None, None, LADDER, (True, False), (2, 0), (None, 8), 2)._replace(**change)
    *tried, best = select(options, error, lambda choice: None)
    return best, tried


def test_the_walk_goes_on_over_a_rung_that_does_not_help():
    best, tried = chosen(lambda c: 10.0 - (c.longest if c.longest != 2 else 0) - 0.01 * len(c.output_lags))
    assert best.longest == 8
    assert len(tried) == len({choice[:5] for choice in tried})


def test_a_larger_model_must_be_better_by_a_margin():
    best, _ = chosen(lambda c: 1.0 - 0.001 * len(c.input_lags))
    assert best == Choice((1,), (1,), True, (0, 0), None, 0.999)


def test_each_output_has_its_own_layers_and_given_lags_stay():
    best, tried = chosen(
        lambda c: 1.0 + (c.layers != (0, 2)) + (c.horizon != 8) + c.increments, input_lags=(5,), output_lags=(1, 7)
    )
    assert best[:5] == ((5,), (1, 7), False, (0, 2), 8)
    assert all(choice[:2] == ((5,), (1, 7)) for choice in tried)
