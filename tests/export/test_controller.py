"""A controller as C next to the package: the same bits at every call."""

import ctypes
import subprocess

import numpy as np
import pytest

from polydraulic import InputError, Simulator, load_machine
from polydraulic.control import ControlSettings, CoordinatedControl, run_controlled, straight_line
from polydraulic.export.controller import controller_c, export_controller

CHECKED = ["-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]


class CController:
    """The exported controller as a shared library."""

    def __init__(self, control, folder):
        export_controller(control, folder)
        library = folder / "controller.so"
        subprocess.run(
            ["gcc", *CHECKED, "-shared", "-fPIC", "controller.c", "-o", library, "-lm"], cwd=folder, check=True
        )
        self._library, self._n = ctypes.CDLL(str(library)), len(control.names)
        self._library.controller_share.restype = ctypes.c_double
        self.state = np.zeros(control.parts.n_live + control.parts.n_scratch)
        self.begin()

    def begin(self):
        self._library.controller_init(self._at(self.state))

    @staticmethod
    def _at(array):
        return array.ctypes.data_as(ctypes.c_void_p)

    def step(self, measured, wanted):
        volts = np.ones(self._n)
        status = self._library.controller_step(*map(self._at, (self.state, measured, wanted, volts)))
        return status, volts

    @property
    def share(self):
        return self._library.controller_share(self._at(self.state))


@pytest.fixture(scope="module")
def control():
    return CoordinatedControl(load_machine("cat215b"), settings=ControlSettings(delay=0.04))


@pytest.fixture(scope="module")
def exported(control, tmp_path_factory):
    return CController(control, tmp_path_factory.mktemp("controller"))


class Noted:
    """A controller whose calls are remembered."""

    def __init__(self, control):
        self._control, self.dt, self.lag, self.reference, self.share = (
            control,
            control.dt,
            control.lag,
            control.reference,
            control.share,
        )
        self.reset, self.calls = control.reset, []

    def step(self, measured, wanted):
        volts = self._control.step(measured, wanted)
        self.calls.append((measured.copy(), wanted.copy(), volts.copy(), float(self.share)))
        return volts


def test_a_closed_run_has_the_bits_of_the_package(control, exported):
    noted = Noted(control)
    line = {"start": {"boom.angle": -0.1, "stick.angle": -0.8}, "limit": 3.0}
    with pytest.warns(UserWarning, match="when the limit of 3 s came"):
        run_controlled("cat215b", noted, lambda tip: straight_line(tip, length=2.8, speed=1.2), **line)
    assert min(share for *_, share in noted.calls) < 0.9  # flow runs short
    exported.begin()
    for measured, wanted, volts, share in noted.calls:
        status, found = exported.step(measured, wanted)
        assert status == 0
        assert np.array_equal(found.view(np.int64), volts.view(np.int64))
        assert exported.share == share


def test_what_is_no_number_closes_the_valves(exported):
    measured, wanted = np.array([0.0, 0.3, -1.6, *[2e6] * 6]), np.array([0.3, 0.0, 0.0, 0.0])
    exported.step(measured, wanted)
    assert exported.state.any()
    for bad in ((np.full(9, np.nan), wanted), (measured, np.array([np.inf, 0.0, 0.0, 0.0]))):
        status, volts = exported.step(*bad)
        assert status == 8
        assert not volts.any()
        assert not exported.state.any()


def test_names_that_are_no_identifiers_are_refused(control):
    with pytest.raises(InputError, match="must be a C identifier"):
        controller_c(control, name="2nd controller")


def test_a_controller_that_keeps_its_machine_from_tipping_gives_the_same_bits(tmp_path):
    light = load_machine("wheel_loader").with_values({"chassis.mass": 5000.0})
    control = CoordinatedControl(light, settings=ControlSettings(tip_margin=0.1, payload=1000.0))
    exported, shares = CController(control, tmp_path), []
    with Simulator(light, load={"payload": 1000.0}) as simulator:
        simulator.reset({"lift.angle": 0.5})
        for _ in range(60):
            measured, wanted = control.measured(simulator).copy(), np.array([0.0, -0.4, 0.0, 0.0])
            volts = control.step(measured, wanted)
            status, own = exported.step(measured, wanted)
            assert status == 0
            assert own.tobytes() == volts.tobytes()
            assert exported.share == float(control.share)
            simulator.step(volts, n=2)
            shares.append(float(control.share))
    assert min(shares) < 1.0
