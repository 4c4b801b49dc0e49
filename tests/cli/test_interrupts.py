"""How commands end when they cannot go on: the tests call the program as a shell does."""

import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest

PROGRAM = [sys.executable, "-m", "polydraulic"]


@pytest.mark.parametrize("buffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["scenarios"], ["--help"]])
def test_a_full_standard_output_is_an_error(arguments, buffered):
    with Path("/dev/full").open("w") as full:
        run = subprocess.run(
            [*PROGRAM, *arguments], stdout=full, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": buffered}
        )  # fmt: skip
    assert run.stderr == "error: cannot write to the standard output: No space left on device\n"
    assert run.returncode == 2


@pytest.mark.parametrize("buffered", ["", "1"])
@pytest.mark.parametrize("arguments", [["scenarios"], ["--help"], ["record", "--example"]])
def test_a_pipe_that_nobody_reads_ends_a_command_in_silence(arguments, buffered):
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as pipe:
        run = subprocess.run(
            [*PROGRAM, *arguments], stdout=pipe, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": buffered}
        )  # fmt: skip
    assert (run.returncode, run.stderr) == (1, "")


# what a command may be doing when it is interrupted: waiting, computing in compiled code, or not heeding
BUSY = {
    "python": "import time; time.sleep(60)",
    "compiled": """
import numba, numpy as np
@numba.njit(nogil=True)
def spin(n):
    x = 0.0
    for i in range(n):
        x = np.sin(x + i)
    return x
spin(10)
began()
spin(1 << 40)""",
    "stubborn": """
import time
try:
    began()
    time.sleep(60)
except BaseException:
    time.sleep(60)""",
}


@pytest.mark.parametrize("busy", BUSY)
def test_an_interrupt_ends_a_command_at_once(busy, tmp_path):
    text = BUSY[busy] if "began()" in BUSY[busy] else "began()\n" + BUSY[busy]
    body = "".join(f"        {line}\n" for line in text.splitlines())
    code = f"""
import sys
from polydraulic import cli
from polydraulic.files import replacing

def app():
    began = lambda: print("busy", flush=True)
    with replacing({str(tmp_path / "out.txt")!r}) as temporary:
        temporary.write_text("half")
{body}
cli.app = app
cli.main()
"""
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert run.stdout.readline() == "busy\n"
    time.sleep(0.1)
    run.send_signal(signal.SIGINT)
    began = time.monotonic()
    _, errors = run.communicate(timeout=30)
    assert (run.returncode, errors) == (130, "interrupted\n")
    assert time.monotonic() - began < 5.0
    assert not (tmp_path / "out.txt").exists()


def test_the_word_stands_in_place_of_a_progress_bar_in_a_terminal():
    code = """
import time
from polydraulic import cli, terminal

terminal.PATIENCE = 0.0

def app():
    with terminal.progress_bar("work") as progress:
        progress("waiting", 0, 1)
        print("busy", flush=True)
        time.sleep(60)
cli.app = app
cli.main()
"""
    ours, theirs = os.openpty()
    run = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=theirs, env={**os.environ, "TERM": "xterm", "COLUMNS": "60"})  # fmt: skip
    os.close(theirs)
    assert run.stdout.readline() == b"busy\n"
    time.sleep(0.3)
    run.send_signal(signal.SIGINT)
    shown = b""
    with suppress(OSError):  # what a closed terminal gives
        while part := os.read(ours, 65536):
            shown += part
    os.close(ours)
    assert run.wait(30) == 130
    run.stdout.close()
    assert b"work: waiting" in shown
    assert b"\r\x1b[2Kinterrupted\r\n" in shown


def test_the_handler_of_whoever_calls_is_put_back(call):
    before = signal.getsignal(signal.SIGINT)
    assert call("scenarios")[0] == 0
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.set_wakeup_fd(-1) == -1


def test_an_error_of_the_system_is_one_line(call, monkeypatch):
    def app():
        raise OSError(24, "Too many open files", "table.csv")

    monkeypatch.setattr("polydraulic.cli.app", app)
    assert call("scenarios") == (2, "", "error: table.csv: Too many open files\n")


def test_warnings_are_one_line():
    code = """
import warnings
from polydraulic import cli
cli.app = lambda: warnings.warn("unlikely")
cli.main()
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "warning: unlikely\n")
