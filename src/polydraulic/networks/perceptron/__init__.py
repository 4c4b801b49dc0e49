"""The baseline: one hidden layer, trained by `back_propagation`, kept as a network of sigmoid nodes."""
