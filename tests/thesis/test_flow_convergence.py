import io

import numpy as np
import pytest

from polydraulic import load_scenario
from polydraulic.thesis.flow_convergence import flow_convergence
from polydraulic.thesis.report.figures.volumes import convergence_figure


@pytest.mark.slow
def test_errors_fall_with_volume_and_delay(machine):
    found = flow_convergence(machine, load_scenario("pulse"))
    assert 0.9 < found.stiff.order < 1.1
    assert 0.9 < found.lines.order < 1.1
    assert 1.8 < found.delay.order < 2.2
    figure = convergence_figure(found, window=(0.0, 0.6))
    assert len(figure.data["pressure"]) == 121
    assert all(np.all(np.isfinite(values)) for table in figure.data.values() for values in table.columns.values())
    figure.draw().savefig(io.BytesIO(), format="svg")
