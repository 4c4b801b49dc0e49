"""Start a cockpit: compile, listen, say where, and end it cleanly."""

import asyncio
import errno
import signal
import socket
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

PORT = 8642
FOLDER = Path("cockpit")
_TAKEN = 1.0  # s that another program has to say what it is


class ReadyCockpit(NamedTuple):
    """A cockpit that is compiled and has a port.

    Attributes
    ----------
    listening : socket
    url : str
        With the token.
    app : aiohttp application
    beat, keeper
        The machine's thread, not yet started, and who writes what it shows.
    title : str
    """

    listening: socket.socket
    url: str
    app: Any
    beat: Any
    keeper: Any
    title: str


def ready_cockpit(
    machine: LayoutMachine | str | Path,
    flow: str = "exact",
    *,
    shadow: str | None = None,
    models: Sequence[Path] = (),
    study: str | Path | None = None,
    port: int = PORT,
    folder: str | Path = FOLDER,
    say: Callable[[str], None] = print,
    progress: Progress = quiet,
) -> ReadyCockpit:
    """Take a port, and compile all that driving needs.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str
        Flow model of the machine that is driven.
    shadow : str, optional
        Flow model that does the same beside it, to see its error.
    models : sequence of Path
        Files of networks for the one of both that is ``"polynomial"`` or ``"neural"``.
    study : str or Path, optional
        File of a study (`polydraulic.cockpit.study.plan`): who is to try what in which order.
    port : int
        Of this computer alone; 0 for any that is free.
    folder : str or Path
        For recordings and results; made when there are some.
    say : function (line)
        What people at the terminal are told while it runs.
    progress : function (what, done, total)

    Raises
    ------
    InputError
        A machine or a flow model that cannot be used, a study that asks for what the machine has not, a port that is taken, no aiohttp.
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
    from polydraulic.cockpit.keeper import Keeper
    from polydraulic.cockpit.own_networks import with_networks
    from polydraulic.cockpit.study.plan import check_study, read_study
    from polydraulic.cockpit.web.guard import Guard
    from polydraulic.cockpit.web.server import application

    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is no folder; recordings and results need one")
    asked = None if study is None else read_study(study)
    listening = listen(port)
    try:
        progress("compile (once after an installation)", 0, 2)
        cab = Cab(machine, *with_networks(machine, flow, shadow, models))
        cab.warm_up()
        progress("describe the machine", 1, 2)
        guard, beat = Guard(listening.getsockname()[1]), Beat(cab)
        if asked is not None:
            check_study(asked, cab.name, cab.exercises, "" if cab.coordination else cab.uncoordinated)
        keeper = Keeper(beat, folder, say, asked)
        app = application(beat, keeper, guard, machine_description(cab, shadow, study=asked is not None))
        progress("serve", 2, 2)
    except BaseException:
        listening.close()
        raise
    return ReadyCockpit(listening, guard.url, app, beat, keeper, cab.machine.title)


def serve(ready: ReadyCockpit, *, browser: bool = True, say: Callable[[str], None] = print) -> None:
    """Serve until Ctrl-C, and end cleanly: what is recorded is written."""
    from aiohttp import web

    with ready.listening:
        asyncio.run(_serve(ready, web, browser, say))


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
                f"port {port} is taken by {_taken_by(port)}; choose another with --port N, or --port 0 for one that is free"
            ) from error
        raise InputError(f"port {port} cannot be used: {error.strerror}; choose another with --port N") from error
    return made


def _taken_by(port: int) -> str:
    """Who has a port."""
    answer = b""
    with suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=_TAKEN) as asked:
        asked.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1:%d\r\nConnection: close\r\n\r\n" % port)
        while part := asked.recv(4096):
            answer += part
            if len(answer) > 65536:
                break
    return (
        "a cockpit that runs already (its terminal shows its URL)"
        if b"that the cockpit printed" in answer
        else "another program"
    )


async def _serve(ready: ReadyCockpit, web: Any, browser: bool, say: Callable[[str], None]) -> None:
    ended, loop = asyncio.Event(), asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, ended.set)
    runner = web.AppRunner(ready.app, access_log=None, shutdown_timeout=1.0)
    await runner.setup()
    beat = ready.beat
    try:
        await web.SockSite(runner, ready.listening).start()
        beat.start()
        keeping = asyncio.create_task(ready.keeper.run())
        say(f"cockpit of {ready.title}: {ready.url}")
        if browser and not await asyncio.to_thread(_opened, ready.url):
            say("no browser could be opened; open this URL in one on this computer")
        say("Ctrl-C ends it")
        while not ended.is_set() and beat.failed is None:
            with suppress(TimeoutError):
                await asyncio.wait_for(ended.wait(), 1.0)
        beat.wanted = beat.wanted._replace(recording=0)  # the tape is closed
        await asyncio.sleep(0.1)
        beat.stop()
        keeping.cancel()
        with suppress(asyncio.CancelledError):
            await keeping
    finally:
        beat.stop()
        await runner.cleanup()
        for number in (signal.SIGINT, signal.SIGTERM):
            loop.remove_signal_handler(number)
    if beat.failed is not None:
        raise beat.failed
    say(f"ended after {beat.made * 0.005:.1f} s of driving, {beat.overruns} steps of 5 ms given up")


def _opened(url: str) -> bool:
    try:
        return webbrowser.open(url)
    except webbrowser.Error:
        return False
