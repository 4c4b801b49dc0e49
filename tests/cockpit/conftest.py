import pytest

from polydraulic.cockpit.cab import Cab


@pytest.fixture
def cab():
    """Two functions: the smallest machine that comes with the package."""
    return Cab("wheel_loader")
