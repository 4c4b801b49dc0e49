"""The commands of the cockpit: what keeps one from being opened, and how one ends."""

import asyncio
import builtins
import re
import signal
import socket
import subprocess
import sys
import threading

import pytest

from helpers.random_drive import random_drive
from polydraulic.cockpit.cab import Cab
from polydraulic.cockpit.open_cockpit import ready_cockpit
from polydraulic.cockpit.recorded.drives import ENDING
from polydraulic.tables import read_table


def test_a_port_that_is_taken_is_named_with_what_to_do(call):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        other.settimeout(5.0)
        talk = threading.Thread(target=lambda: other.accept()[0].close())
        talk.start()
        code, _, err = call("cockpit", "--machine", "wheel_loader", "--no-browser", "--port", port)
        talk.join()
    assert code == 2
    assert f"port {port} is taken by another program; choose another with --port N" in err


def test_a_second_cockpit_on_the_same_port_is_told_of_the_first(call, tmp_path):
    pytest.importorskip("aiohttp")
    ready = ready_cockpit("wheel_loader", port=0, folder=tmp_path)
    port = ready.listening.getsockname()[1]
    ended = threading.Event()

    async def serve_first():
        from aiohttp import web

        runner = web.AppRunner(ready.app, shutdown_timeout=0.1)
        await runner.setup()
        await web.SockSite(runner, ready.listening).start()
        while not ended.is_set():
            await asyncio.sleep(0.02)
        await runner.cleanup()

    first = threading.Thread(target=lambda: asyncio.run(serve_first()))
    first.start()
    try:
        code, _, err = call("cockpit", "--machine", "wheel_loader", "--no-browser", "--port", port)
    finally:
        ended.set()
        first.join()
    assert code == 2
    assert f"port {port} is taken by a cockpit that runs already" in err


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--port", 70000), "from 0 to 65535"),
        (("--port", 0, "--machine", "digger"), "digger"),
        (("--port", 0, "--machine", "wheel_loader", "--flow", "magic"), "magic"),
        (("--port", 0, "--machine", "wheel_loader", "--shadow", "polynomial"), "polynomial"),
    ],
)
def test_what_cannot_be_driven_is_named_before_anything_is_served(call, options, says):
    code, out, err = call("cockpit", "--no-browser", *options)
    assert code == 2
    assert says in err
    assert out == ""


def test_a_folder_that_is_none_is_named(call, tmp_path):
    (tmp_path / "x").touch()
    code, _, err = call("cockpit", "--no-browser", "--port", 0, "--record", tmp_path / "x")
    assert (code, "is no folder" in err) == (2, True)


def test_without_its_extra_the_cockpit_says_how_to_get_it(call, monkeypatch):
    load = builtins.__import__

    def without(name, *more):
        if name == "aiohttp":
            raise ImportError(name)
        return load(name, *more)

    monkeypatch.setattr(builtins, "__import__", without)
    code, _, err = call("cockpit", "--no-browser")
    assert code == 2
    assert "pip install 'polydraulic[cockpit]'" in err


def test_a_drive_becomes_a_scenario_that_is_simulated(call, tmp_path):
    drive = tmp_path / f"x{ENDING}"
    random_drive(Cab("wheel_loader"), drive, 3, 40)
    code, out, err = call(
        "cockpit-export", drive, "--scenario", tmp_path / "s.toml", "--log", tmp_path / "l.csv", "--raster", 0.05
    )
    assert (code, err) == (0, "")
    assert re.search(r"x\.drive\.jsonl: [\d.]+ s$", out, re.MULTILINE)
    assert len(read_table(tmp_path / "l.csv")) > 10
    code, out, _ = call("simulate", tmp_path / "s.toml", "--out", tmp_path / "r.csv")
    assert code == 0
    assert "s on wheel_loader: Drive x" in out


@pytest.mark.slow
def test_a_cockpit_is_ended_by_an_interrupt_and_what_is_recorded_is_whole(tmp_path):
    """Ctrl-C while a page drives and records."""
    aiohttp = pytest.importorskip("aiohttp")
    from polydraulic.cockpit.recorded.drives import drive_names, read_drive

    command = [
        sys.executable,
        "-m",
        "polydraulic",
        "cockpit",
        "--machine",
        "wheel_loader",
        "--no-browser",
        "--port",
        "0",
    ]
    run = subprocess.Popen(
        [*command, "--record", str(tmp_path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        url = re.search(r"http://\S+", run.stdout.readline())[0]
        base = url.partition("/?")[0]

        async def drive():
            async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
                await session.get(url)
                async with session.ws_connect(f"{base}/live", headers={"Origin": base}) as page:
                    for message in ({"type": "drive"}, {"type": "lock", "on": False}, {"type": "record", "on": True}):
                        await page.send_json(message)
                    for k in range(20):
                        await page.send_json({"type": "sticks", "seq": k, "axes": [0, 0, 0, -1, 0, 0]})
                        await asyncio.sleep(0.05)
                    run.send_signal(signal.SIGINT)
                    await asyncio.sleep(0.5)

        asyncio.run(drive())
        out, err = run.communicate(timeout=60)
    finally:
        run.kill()
    assert (run.returncode, err) == (0, "")
    assert "ended after" in out
    (name,) = drive_names(tmp_path)
    drive = read_drive(tmp_path / f"{name}{ENDING}")
    assert drive.whole
    assert drive.end > 100


def test_a_study_or_networks_that_cannot_be_are_named(call, tmp_path):
    pytest.importorskip("aiohttp")
    code, _, err = call("cockpit", "--no-browser", "--port", 0, "--study", tmp_path / "none.toml")
    assert code == 2
    assert "none.toml: cannot be read" in err
    code, _, err = call("cockpit", "--no-browser", "--port", 0, "--machine", "wheel_loader", "--model", "own.json")
    assert code == 2
    assert "model files go with one flow model of networks: flow is 'exact' and shadow None" in err
