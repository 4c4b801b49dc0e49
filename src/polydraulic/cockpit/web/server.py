"""What the browser is served: the page's files, the machine's description, and the websocket."""

import asyncio
import json
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from polydraulic.cockpit.beat import Beat
from polydraulic.cockpit.keeper import Keeper
from polydraulic.cockpit.protocol import FRAMES, MOST_BYTES, Flag, frame, read_message
from polydraulic.cockpit.web.guard import Guard
from polydraulic.cockpit.web.news import News
from polydraulic.cockpit.web.page_files import page_files
from polydraulic.cockpit.web.seat import Seat
from polydraulic.errors import InputError

if TYPE_CHECKING:
    from aiohttp import web

_MOST_PAGES = 16  # that watch at once
_MOST_WAITING = 65536  # bytes that a page has not read; further frames are dropped
_HEARTBEAT = 5.0  # s


def application(beat: Beat, keeper: Keeper, guard: Guard, description: dict[str, Any]) -> "web.Application":
    """All that is served.

    Parameters
    ----------
    beat : Beat
        Running, or not yet.
    keeper : Keeper
    guard : Guard
    description : dict
        ``/machine.json``.
    """
    from aiohttp import WSMsgType, web

    app = web.Application(middlewares=[_guarded(guard)], client_max_size=MOST_BYTES)
    files, described, seat = page_files(), json.dumps(description, allow_nan=False).encode(), Seat(beat, keeper)

    async def index(request: web.Request) -> web.StreamResponse:
        if "token" in request.query:
            answer: web.StreamResponse = web.HTTPFound("/")
            name, value = guard.cookie
            answer.set_cookie(name, value, httponly=True, samesite="Strict", path="/")
            return answer
        return _file("index.html")

    async def page(request: web.Request) -> web.StreamResponse:
        return _file(request.match_info["name"])

    def _file(name: str) -> web.Response:
        if name not in files:
            raise web.HTTPNotFound(text=f"the page has no file {name[:64]!r}")
        return web.Response(body=files[name].content, content_type=files[name].type, charset="utf-8")

    async def machine(request: web.Request) -> web.StreamResponse:
        return web.Response(body=described, content_type="application/json")

    async def results(request: web.Request) -> web.StreamResponse:
        found = await asyncio.to_thread(keeper.compared_results)
        return web.json_response(found)

    async def live(request: web.Request) -> web.StreamResponse:
        if not guard.is_origin(request.headers.get("Origin")):
            raise web.HTTPForbidden(text="another page's script")
        if len(seat.pages) >= _MOST_PAGES:
            raise web.HTTPServiceUnavailable(text=f"{_MOST_PAGES} pages are open; close one of them")
        socket = web.WebSocketResponse(heartbeat=_HEARTBEAT, max_msg_size=MOST_BYTES, compress=False)
        await socket.prepare(request)
        number = seat.enter()
        showing = asyncio.create_task(_show(request, socket, seat, number))
        try:
            with suppress(ConnectionError):  # a page that has gone cannot be answered
                async for message in socket:
                    if message.type == WSMsgType.ERROR:  # too long, or no websocket's: aiohttp has closed it
                        break
                    if message.type != WSMsgType.TEXT:
                        await socket.send_json({"type": "error", "text": "messages are JSON as text"})
                        continue
                    try:
                        said = read_message(message.data)
                        if (name := seat.drive_to_read(number, said)) is not None:
                            seat.begin_replay(number, await asyncio.to_thread(seat.read, name))
                        seat.hear(number, said)
                    except InputError as error:
                        await socket.send_json({"type": "error", "text": str(error)})
        finally:
            seat.leave(number)
            showing.cancel()
        return socket

    app.router.add_get("/", index)
    app.router.add_get("/page/{name}", page)
    app.router.add_get("/machine.json", machine)
    app.router.add_get("/results.json", results)
    app.router.add_get("/live", live)
    return app


async def _show(request: "web.Request", socket: "web.WebSocketResponse", seat: Seat, number: int) -> None:
    """Send frames at their pace, and what has changed; a page that does not read gets the next ones."""
    loop, count, news = asyncio.get_running_loop(), 0, News(seat, number)
    begun = loop.time()
    with suppress(ConnectionError):
        while not socket.closed:
            await asyncio.sleep(max(begun + (count + 1) / FRAMES - loop.time(), 0.0))
            count = max(int((loop.time() - begun) * FRAMES), count + 1)
            transport = request.transport
            if transport is None:
                return
            if transport.get_write_buffer_size() > _MOST_WAITING:
                continue
            shown = seat.beat.cab.shown
            flags = shown.flags | (Flag.DRIVER if seat.driver == number else 0)
            await socket.send_bytes(frame(count, shown.seq, shown.time, shown.overruns, flags, shown.values))
            for text in news.of(shown):
                await socket.send_json(text)


def _guarded(guard: Guard) -> Any:
    from aiohttp import web

    @web.middleware
    async def middleware(request: web.Request, handler: Any) -> web.StreamResponse:
        refused = _refusal(request, guard)
        if refused is None:
            try:
                answer: web.StreamResponse = await handler(request)
            except web.HTTPException as error:
                answer = error
        else:
            answer = refused
        if not answer.prepared:
            answer.headers.update(guard.headers)
        if isinstance(answer, web.HTTPException):
            raise answer
        return answer

    return middleware


def _refusal(request: "web.Request", guard: Guard) -> "web.HTTPException | None":
    """Why a request is not answered; None if it is."""
    from aiohttp import web

    hosts = request.headers.getall("Host", [])
    if len(hosts) != 1 or not guard.is_host(hosts[0]):
        return web.HTTPForbidden(text="another host's name")
    if request.method != "GET":
        return web.HTTPMethodNotAllowed(request.method, ["GET"])
    if request.path == "/" and guard.is_token(request.query.get("token")):
        return None
    if "token" in request.query or not guard.is_cookie(request.cookies.get(guard.cookie[0])):
        return web.HTTPForbidden(text="open the URL that the cockpit printed when it started")
    return None
