from helpers.smooth_run import end_by_runge_kutta, end_by_the_loop, order, smooth_start


def test_the_semi_implicit_loop_is_of_first_order(machine):
    moving = smooth_start(machine)
    truth = end_by_runge_kutta(machine, moving, 160)
    assert 0.9 < order(lambda n: end_by_the_loop(machine, moving, n), truth, [80, 160, 320]) < 1.1
