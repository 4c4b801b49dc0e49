import io

from polydraulic.simulation import plot_run, simulate


def test_the_plot_has_a_panel_a_quantity(machine, scenario):
    runs = {name: simulate(machine, name, scenario, t_end=0.2) for name in ("exact", "polynomial")}
    figure = plot_run(runs)
    labels = [axis.get_ylabel() for axis in figure.axes]
    assert [label.split("\n")[1] for label in labels] == ["[in]", "[in3/s]", "[psi]", "[deg]", "[deg/s]"]
    assert len(figure.axes[1].lines) == 4
    figure.savefig(io.BytesIO(), format="svg")
