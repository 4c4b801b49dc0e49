import pytest

from polydraulic.errors import InputError
from polydraulic.export import export_c
from polydraulic.export.model_bundle import bundle
from polydraulic.networks import Model, Network, Node, Variable


def test_models_that_do_not_go_together_are_refused(exported_models, tmp_path):
    model = exported_models["single"][0]
    clash = Model((Variable("x0", "bar"), *model.inputs[1:]), Variable("z"), model.networks)
    chain = Model((Variable("y"), *model.inputs[1:]), Variable("z"), model.networks)
    twice = Model((model.inputs[0],) * 3, Variable("z"), model.networks)
    for models, message in [
        ([], "no model"),
        ([model, model], "they must differ"),
        ([model, clash], "is in '' for one model and in 'bar' for another"),
        ([model, chain], "'y' is an output of one model and an input of another"),
        ([twice], "need different names"),
    ]:
        with pytest.raises(InputError, match=message):
            export_c(models, tmp_path)
    with pytest.raises(InputError, match="real = 'half'"):
        export_c([model], tmp_path, real="half")
    huge = Network((Node(0, (0,), (1e300, 1.0, 0.0, 0.0)),), (0.0,), (1.0,), (0.0,), (1.0,), 0.0, 1.0)
    with pytest.raises(InputError, match="does not fit into a float"):
        export_c([Model((Variable("x"),), Variable("y"), (huge,))], tmp_path, real="float")
    assert list(tmp_path.iterdir()) == []


def test_of_many_names_that_differ_a_few_are_said():
    constant = Network((Node(0, (0,), (1.0, 1.0, 0.0, 0.0)),), (0.0,), (1.0,), (0.0,), (1.0,), 0.0, 1.0)

    def notes(n):
        models = [Model((Variable("x"),), Variable(f"y.{k}"), (constant,)) for k in range(n)]
        return bundle(models, name="m").name_notes()

    assert notes(3) == ["names: y.0 is y_0, y.1 is y_1, y.2 is y_2"]
    assert notes(80) == ["names: y.0 is y_0, y.1 is y_1, y.2 is y_2 and 77 more"]
