"""Networks of any shape, as hypothesis draws them."""

from hypothesis import strategies as st

from polydraulic.networks import Model, Network, Node, Variable, grid
from polydraulic.networks.model.nodes import terms

value = st.floats(-3.0, 3.0).map(lambda v: round(v, 6))


@st.composite
def networks(draw, n_input=None):
    n_input = draw(st.integers(1, 4)) if n_input is None else n_input
    nodes = []
    for number in range(draw(st.integers(0, 4))):
        kind = draw(st.sampled_from([0, 1, 2, 3, 4, 5]))
        size = kind + 1 if kind < 3 else draw(st.integers(1, 5))
        slots = tuple(draw(st.integers(0, n_input + number - 1)) for _ in range(size))
        coef = tuple(draw(value) for _ in terms(kind, size))
        nodes.append(Node(kind, slots, coef))
    numbers = [draw(value) for _ in range(n_input)]
    return Network(
        nodes=tuple(nodes),
        x_mean=tuple(numbers),
        x_scale=tuple(draw(st.floats(0.1, 3.0)) for _ in range(n_input)),
        x_low=tuple(-1.0 for _ in range(n_input)),
        x_high=tuple(1.5 for _ in range(n_input)),
        y_mean=draw(value),
        y_scale=draw(st.floats(0.1, 3.0)),
        y_low=-50.0,
        y_high=draw(st.sampled_from([40.0, 1e300])),
    )


def model_of(*found, edges=None):
    inputs = tuple(Variable(f"x{i}") for i in range(found[0].n_inputs))
    return Model(inputs, Variable("y"), found, grid(edges or {}))
