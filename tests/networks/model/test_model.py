from polydraulic.networks import Network, Node, Variable
from polydraulic.networks.model.model import describe


def test_equations_in_words():
    node = Node(1, (0, 1), (1.0, 0.0, -2.0, 0.0, 0.0, 3.0, 0.0, 0.5))
    lines = describe(
        Network((node,), (1.0, 2.0), (3.0, 4.0), (0.0, 0.0), (1.0, 1.0), 5.0, 6.0), [Variable("p"), Variable("q")]
    )
    assert lines[0] == "n1 = (p - 1) / 3"
    assert "-2 n2" in lines[2]
    assert "+3 n1 n2" in lines[2]
    assert lines[-1] == "y = 5 + 6 z1"
