"""A cockpit that is driven for long: simulated time goes with the clock but for what was given up, memory stays as it is."""

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from polydraulic.cockpit.cab import DT
from polydraulic.cockpit.protocol import HEAD
from polydraulic.cockpit.recorded.drives import ENDING, drive_names, read_drive

SECONDS = float(os.environ.get("POLYDRAULIC_DRIVEN_SECONDS", "60"))  # an hour: 3600
WINDOW = 0.1  # of the whole, at either end, in which the least delay is looked for
DRIFT = 0.02  # s
GROWTH = 8.0  # MB


def resident(pid):
    """Memory of a process in MB."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


async def driven(aiohttp, url, pid):
    """Random levers for a while: (clock, simulated time, overruns) of every frame, and memory now and then."""
    base, rng, frames, memory = url.partition("/?")[0], np.random.default_rng(11), [], []
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
        await session.get(url)
        async with session.ws_connect(f"{base}/live", headers={"Origin": base}) as page:

            async def read():
                async for message in page:
                    if message.type == aiohttp.WSMsgType.BINARY:
                        _, seq, simulated, overruns, _ = HEAD.unpack_from(message.data)
                        frames.append((time.perf_counter(), simulated, overruns, seq))
                    else:
                        assert json.loads(message.data)["type"] != "error", message.data

            reading = asyncio.create_task(read())
            for message in ({"type": "drive"}, {"type": "lock", "on": False}, {"type": "record", "on": True}):
                await page.send_json(message)
            begun, seq = time.perf_counter(), 0
            while (now := time.perf_counter() - begun) < SECONDS:
                seq += 1
                await page.send_json({"type": "sticks", "seq": seq, "axes": rng.uniform(-1.0, 1.0, 6).tolist()})
                if not memory or now - memory[-1][0] > SECONDS / 100.0:
                    memory.append((now, resident(pid)))
                await asyncio.sleep(1.0 / 60.0)
            reading.cancel()
    return np.array(frames), np.array(memory)


@pytest.mark.slow
def test_time_does_not_drift_and_memory_does_not_grow(tmp_path):
    aiohttp = pytest.importorskip("aiohttp")
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
        frames, memory = asyncio.run(driven(aiohttp, url, run.pid))
        run.send_signal(signal.SIGINT)
        _, err = run.communicate(timeout=60)
    finally:
        run.kill()
    assert (run.returncode, err) == (0, "")
    clock, simulated, overruns, seq = frames.T
    delay = clock - simulated - overruns * DT  # but for a constant: how late a frame is seen
    n = int(WINDOW * len(delay))
    drift, growth = delay[-n:].min() - delay[:n].min(), memory[-10:, 1].mean() - memory[20:30, 1].mean()
    print(
        f"{clock[-1] - clock[0]:.0f} s: {len(frames)} frames, drift {1e3 * drift:.2f} ms, {overruns[-1]:.0f} overruns, "
        f"memory {memory[25, 1]:.1f} MB, {growth:+.2f} MB"
    )
    assert abs(drift) < DRIFT
    assert growth < GROWTH
    assert (np.diff(seq) >= 0).all()
    (name,) = drive_names(tmp_path)
    drive = read_drive(tmp_path / f"{name}{ENDING}")
    assert drive.whole
    assert abs(drive.end * DT - (simulated[-1] - simulated[0])) < 2.0  # what was given up is not in it
