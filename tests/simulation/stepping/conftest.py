import pytest

from helpers.small_crane import crane_text_with_effects
from polydraulic import load_machine


@pytest.fixture(scope="session")
def loader():
    """Two functions: the smallest machine that comes with the package."""
    return load_machine("wheel_loader")


@pytest.fixture(scope="session")
def worn_crane(tmp_path_factory):
    """Three functions with every effect that a file may declare."""
    path = tmp_path_factory.mktemp("worn") / "worn.toml"
    path.write_text(crane_text_with_effects(), encoding="utf-8")
    return load_machine(path)
