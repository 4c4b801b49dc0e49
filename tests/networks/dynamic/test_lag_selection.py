from polydraulic.networks.dynamic.lag_selection import Choice, Options, select, select_terms

LADDER = (1, 2, 3, 4, 6, 8)


def options(**change):
    return Options(None, None, LADDER, (True, False), (None, 8))._replace(**change)


def chosen(error, **change):
    *tried, best = select(options(**change), error, lambda choice: None)
    return best, tried


def test_the_walk_goes_on_over_a_rung_that_does_not_help():
    best, tried = chosen(lambda c: 10.0 - (c.longest if c.longest != 2 else 0) - 0.01 * len(c.output_lags))
    assert best.longest == 8
    assert len(tried) == len({choice[:5] for choice in tried})


def test_a_larger_model_must_be_better_by_a_margin():
    best, _ = chosen(lambda c: 1.0 - 0.001 * len(c.input_lags))
    assert best == Choice((1,), (1,), True, None, None, 0.999)


def test_given_lags_stay():
    best, tried = chosen(lambda c: 1.0 + (c.horizon != 8) + c.increments, input_lags=(5,), output_lags=(1, 7))
    assert best[:4] == ((5,), (1, 7), False, 8)
    assert all(choice[:2] == ((5,), (1, 7)) for choice in tried)


def chosen_terms(error, **change):
    told = []
    settings = options(increments=(False,), horizons=(8, 16, 32, 64, 128))._replace(**change)

    def judge(choice):
        sizes = [choice._replace(terms=terms) for terms in range(2, 12)]
        return [one._replace(error=error(one)) for one in sizes]

    *tried, best = select_terms(settings, judge, told.append)
    return best, tried, told


def test_horizons_are_tried_as_long_as_they_help_and_then_more_lags():
    best, tried, told = chosen_terms(lambda c: 1.0 + abs(c.horizon - 16) - 0.1 * (c.longest == 8) + abs(c.terms - 7))
    assert (best.horizon, best.longest, best.terms) == (16, 8, 7)
    assert [(one.longest, one.horizon) for one in told] == [(3, 8), (3, 16), (3, 32), (3, 64), (8, 16)]
    assert len(tried) == 50


def test_few_terms_are_chosen_where_more_gain_little():
    best, _, _ = chosen_terms(lambda c: 1.0 - 0.001 * c.terms + (c.terms < 4), input_lags=(1,), output_lags=(2,))
    assert best.terms == 4


def test_given_lags_are_offered_as_they_are():
    _, tried, _ = chosen_terms(lambda c: 1.0, input_lags=(5,), output_lags=(1, 7))
    assert {choice[:2] for choice in tried} == {((5,), (1, 7))}
    assert {choice.horizon for choice in tried} == {8, 16, 32}
