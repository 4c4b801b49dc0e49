"""A payload as a picture: windows in which it is known, and the mean."""

import numpy as np

from polydraulic.identification import PayloadEstimate, plot_payload

FOUND = PayloadEstimate(
    np.array([1.0, 3.0, 5.0]), np.array([1000.0, np.nan, 1040.0]), np.array([20.0, np.inf, 30.0]), 1012.0, 17.0
)


def test_windows_that_are_known_are_drawn_with_the_mean():
    axis = plot_payload(FOUND).axes[0]
    (points, _, _) = axis.containers[0]
    np.testing.assert_array_equal(points.get_xydata(), [[1.0, 1000.0], [5.0, 1040.0]])
    assert "mean of the log, 1012 ± 17" in {text.get_text() for text in axis.get_legend().get_texts()}
    assert axis.get_ylabel() == "payload [kg]"
