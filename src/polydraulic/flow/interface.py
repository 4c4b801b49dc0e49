"""What a flow model says of a step."""

OK, NOT_CONVERGED, OUT_OF_DOMAIN = 0, 1, 2
