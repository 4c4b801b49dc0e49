"""Networks from files go to the flow model, or to the shadow, that is made of networks."""

import pytest

from polydraulic import InputError
from polydraulic.cockpit.cab import Cab
from polydraulic.cockpit.own_networks import with_networks
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks.model.model_file import save_models


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    path = tmp_path_factory.mktemp("own") / "own.json"
    save_models(shipped_models(), path)
    return path


@pytest.mark.parametrize("which", [0, 1])
def test_networks_of_a_file_are_driven_or_follow(trained, which):
    given = ("polynomial", "exact") if which == 0 else ("exact", "polynomial")
    made = with_networks("cat215b", *given, [trained])
    assert made[1 - which] == "exact"
    assert (made[which].name, made[which].kernels) == ("polynomial", "networks")
    if which == 0:
        cab = Cab("cat215b", made[0])
        assert cab.flow == "polynomial"
        assert (
            cab.simulator.save().of == Cab("cat215b", "polynomial").simulator.save().of
        )  # the package's own, from a file


def test_files_that_belong_to_nobody_are_refused(trained):
    assert with_networks("cat215b", "exact", None, []) == ("exact", None)
    for flow, shadow in (("exact", None), ("exact", "tlm"), ("polynomial", "neural")):
        with pytest.raises(InputError, match="model files go with one flow model of networks"):
            with_networks("cat215b", flow, shadow, [trained])
    with pytest.raises(InputError, match="wheel_loader|tilt|lift|work"):
        with_networks("wheel_loader", "polynomial", None, [trained])
