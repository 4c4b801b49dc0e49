from polydraulic.networks.model.lags import Dynamics, Lag


def test_lags_have_names_and_say_how_many_rows_a_run_needs():
    lags = (Lag("u", 0), Lag("y", 3))
    assert [str(lag) for lag in lags] == ["u[t]", "y[t-3]"]
    assert Dynamics(lags).warm_up == 3
    assert Dynamics(lags[:1]).warm_up == 1
