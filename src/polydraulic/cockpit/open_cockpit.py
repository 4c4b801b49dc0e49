"""Start a cockpit: compile, listen, say where, and end it cleanly."""

import asyncio
import errno
import signal
import socket
import webbrowser
from collections.abc import Callable
from pathlib import Path

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

PORT = 8642


def told(line: str) -> None:
    """Print a line at once, also into a file."""
    print(line, flush=True)


def run_cockpit(
    machine: LayoutMachine | str | Path,
    flow: str = "exact",
    *,
    port: int = PORT,
    browser: bool = True,
    say: Callable[[str], None] = told,
    progress: Progress = quiet,
) -> None:
    """Serve a cockpit until it is interrupted.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str
        Flow model.
    port : int
        Of this computer alone; 0 for any that is free.
    browser : bool
        Open a browser, if there is one.
    say : function (line)
    progress : function (what, done, total)

    Raises
    ------
    InputError
        A machine or a flow model that cannot be used, a port that is taken, no aiohttp.
    """
    try:
        import aiohttp  # noqa: F401
    except ImportError as error:
        raise InputError(
            "aiohttp is not installed; the cockpit is an extra: pip install 'polydraulic[cockpit]'"
        ) from error
    from polydraulic.cockpit.beat import Beat
    from polydraulic.cockpit.cab import Cab
    from polydraulic.cockpit.description import machine_description
    from polydraulic.cockpit.guard import Guard

    listening = listen(port)
    with listening:
        progress("compile (once after an installation)", 0, 2)
        cab = Cab(machine, flow)
        cab.warm_up()
        progress("describe", 1, 2)
        guard, name = Guard(listening.getsockname()[1]), machine if isinstance(machine, str) else cab.machine.title
        description = machine_description(cab, str(name), flow)
        progress("serve", 2, 2)
        asyncio.run(_serve(Beat(cab), guard, description, listening, browser, say))


def listen(port: int) -> socket.socket:
    """A socket on this computer's own address.

    Raises
    ------
    InputError
        A port that is no port, or is taken.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"port = {port}: must be from 0 to 65535; 0 takes one that is free")
    made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind(("127.0.0.1", port))
        made.listen(128)
    except OSError as error:
        made.close()
        if error.errno == errno.EADDRINUSE:
            raise InputError(
                f"port {port} is taken{_taken_by(port)}; choose another with --port N, or --port 0 for one that is free"
            ) from error
        raise InputError(f"port {port} cannot be used: {error.strerror}; choose another with --port N") from error
    return made


def _taken_by(port: int) -> str:
    """Whether it is a cockpit that has a port."""
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=1.0) as asked:
            asked.settimeout(1.0)
            asked.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n\r\n" % port)
            answer = asked.recv(4096)
    except OSError:
        return " by another program"
    return " by a cockpit that runs already" if b"that the cockpit printed" in answer else " by another program"


async def _serve(beat, guard, description, listening, browser, say) -> None:
    from aiohttp import web

    from polydraulic.cockpit.server import application

    ended, loop = asyncio.Event(), asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    runner = web.AppRunner(application(beat, guard, description), access_log=None, shutdown_timeout=1.0)
    await runner.setup()
    try:
        await web.SockSite(runner, listening).start()
        beat.start()
        say(f"cockpit of {description['title']}: {guard.url}")
        if browser and not await asyncio.to_thread(_opened, guard.url):
            say("no browser could be opened; open this URL in one on this computer")
        say("Ctrl-C ends it")
        while not ended.is_set():
            try:
                await asyncio.wait_for(ended.wait(), 1.0)
            except TimeoutError:
                if beat.failed is not None:
                    raise beat.failed
    finally:
        beat.stop()
        await runner.cleanup()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.remove_signal_handler(number)


def _opened(url: str) -> bool:
    try:
        return webbrowser.open(url)
    except webbrowser.Error:
        return False
