"""The cockpit as a browser, or anything else on this computer, can reach it."""

import asyncio
import json
import struct
from contextlib import asynccontextmanager
from itertools import pairwise

import numpy as np
import pytest

aiohttp = pytest.importorskip("aiohttp")
from aiohttp import web  # noqa: E402

from polydraulic.cockpit.beat import Beat  # noqa: E402
from polydraulic.cockpit.description import machine_description  # noqa: E402
from polydraulic.cockpit.keeper import Keeper  # noqa: E402
from polydraulic.cockpit.open_cockpit import listen  # noqa: E402
from polydraulic.cockpit.protocol import HEAD, Flag  # noqa: E402
from polydraulic.cockpit.web.guard import Guard  # noqa: E402
from polydraulic.cockpit.web.server import application  # noqa: E402

PATIENCE = 10.0  # s for what takes none on an idle computer


class Cockpit:
    """A cockpit that is served, and a browser's cookies."""

    def __init__(self, beat, keeper, guard, session):
        self.beat, self.keeper, self.guard, self.session = beat, keeper, guard, session
        self.base = f"http://127.0.0.1:{guard.port}"
        self.columns = [c.name for c in beat.cab.view.columns]

    async def get(self, path, **more):
        async with self.session.get(self.base + path, allow_redirects=False, **more) as answer:
            return answer, await answer.read()

    async def enter(self):
        """Exchange the token for the cookie."""
        answer, _ = await self.get(f"/?token={self.guard.token}")
        assert answer.status == 302

    @asynccontextmanager
    async def page(self, **headers):
        headers = {"Origin": self.base} | headers
        async with self.session.ws_connect(self.base + "/live", headers=headers) as socket:
            page = Page(socket, self.columns)
            try:
                yield page
            finally:
                page.reading.cancel()


class Page:
    """What a page has seen."""

    def __init__(self, socket, columns):
        self.socket, self.columns = socket, columns
        self.frames, self.texts = [], []
        self.reading = asyncio.create_task(self._read())

    async def _read(self):
        async for message in self.socket:
            if message.type == aiohttp.WSMsgType.BINARY:
                self.frames.append(message.data)
            else:
                self.texts.append(json.loads(message.data))

    async def say(self, **message):
        await self.socket.send_json(message)

    async def until(self, holds, what):
        for _ in range(int(PATIENCE / 0.02)):
            if holds():
                return
            await asyncio.sleep(0.02)
        raise AssertionError(f"{what}; the last words were {self.texts[-3:]}")

    async def told(self, kind, **fields):
        def holds():
            return any(t["type"] == kind and all(t.get(k) == v for k, v in fields.items()) for t in self.texts)

        await self.until(holds, f"nothing said {kind} {fields}")

    async def refused(self, words):
        await self.until(
            lambda: any(t["type"] == "error" and words in t["text"] for t in self.texts), f"no error {words!r}"
        )

    @property
    def head(self):
        return HEAD.unpack_from(self.frames[-1])

    @property
    def values(self):
        return dict(zip(self.columns, np.frombuffer(self.frames[-1][HEAD.size :], "<f4").tolist(), strict=True))


def served(test, cab, folder):
    """Run a test with a cockpit that is served."""

    async def run():
        listening = listen(0)
        guard, beat = Guard(listening.getsockname()[1]), Beat(cab)
        keeper = Keeper(beat, folder, lambda line: None)
        runner = web.AppRunner(application(beat, keeper, guard, machine_description(cab)), shutdown_timeout=0.1)
        await runner.setup()
        await web.SockSite(runner, listening).start()
        beat.start()
        keeping = asyncio.create_task(keeper.run())
        try:
            async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
                await asyncio.wait_for(test(Cockpit(beat, keeper, guard, session)), 6 * PATIENCE)
        finally:
            keeping.cancel()
            beat.stop()
            await runner.cleanup()

    asyncio.run(run())


@pytest.fixture
def serve(cab, tmp_path):
    return lambda test: served(test, cab, tmp_path / "kept")


def test_who_has_no_token_gets_nothing(serve):
    async def test(cockpit):
        for path in (
            "/",
            "/machine.json",
            "/page/index.html",
            "/results.json",
            "/nothing",
            "/?token=",
            "/?token=wrong",
        ):
            answer, body = await cockpit.get(path)
            assert answer.status == 403, path
            assert cockpit.guard.token.encode() not in body
            assert b"machine" not in body
        with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
            async with cockpit.page():
                pass
        name, value = cockpit.guard.cookie
        for cookie in (f"{name}=wrong", f"{name}_1={value}", f"{name}=ä"):
            answer, _ = await cockpit.get("/", headers={"Cookie": cookie})
            assert answer.status == 403, cookie

    serve(test)


def test_the_token_is_exchanged_for_a_cookie_that_no_script_and_no_other_site_gets(serve):
    async def test(cockpit):
        answer, _ = await cockpit.get(f"/?token={cockpit.guard.token}")
        cookie = answer.headers["Set-Cookie"]
        assert answer.headers["Location"] == "/"
        assert str(cockpit.guard.port) in cookie.partition("=")[0]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        assert cockpit.guard.token not in cookie
        answer, body = await cockpit.get("/")
        assert (answer.status, body[:15].lower()) == (200, b"<!doctype html>")
        policy = answer.headers["Content-Security-Policy"]
        assert policy.startswith("default-src 'none'")
        assert "unsafe" not in policy
        for name, value in (
            ("X-Content-Type-Options", "nosniff"),
            ("Referrer-Policy", "no-referrer"),
            ("Cross-Origin-Opener-Policy", "same-origin"),
            ("Cross-Origin-Resource-Policy", "same-origin"),
            ("Cache-Control", "no-store"),
        ):
            assert answer.headers[name] == value

    serve(test)


def test_other_hosts_other_origins_and_other_methods_are_refused(serve):
    async def test(cockpit):
        await cockpit.enter()
        for host in ("evil.example", f"evil.example:{cockpit.guard.port}", "127.0.0.1", "127.0.0.1:1", ""):
            answer, _ = await cockpit.get("/machine.json", headers={"Host": host})
            assert answer.status in (400, 403), host
        answer, _ = await cockpit.get("/machine.json", headers={"Host": f"localhost:{cockpit.guard.port}"})
        assert answer.status == 200
        for origin in (
            "null",
            "http://evil.example",
            "http://127.0.0.1:1",
            f"https://127.0.0.1:{cockpit.guard.port}",
            "",
        ):
            with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                async with cockpit.page(Origin=origin):
                    pass
        with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
            async with cockpit.session.ws_connect(cockpit.base + "/live"):
                pass
        async with cockpit.session.post(cockpit.base + "/machine.json") as answer:
            assert answer.status == 405

    serve(test)


def test_only_files_of_the_page_are_served(serve, tmp_path):
    async def test(cockpit):
        await cockpit.enter()
        answer, body = await cockpit.get("/page/index.html")
        assert (answer.status, answer.content_type) == (200, "text/html")
        assert body
        for path in (
            "..%2f__init__.py",
            "%2e%2e/__init__.py",
            "..%2f..%2f..%2fetc%2fpasswd",
            "/etc/passwd",
            "__init__.py",
            "x",
        ):
            async with cockpit.session.get(aiohttp.client.URL(f"{cockpit.base}/page/{path}", encoded=True)) as answer:
                assert answer.status == 404, path

    serve(test)


def test_the_machine_is_described_and_frames_come(serve):
    async def test(cockpit):
        await cockpit.enter()
        _, body = await cockpit.get("/machine.json")
        described = json.loads(body)
        assert [c["name"] for c in described["columns"]] == cockpit.columns
        async with cockpit.page() as page:
            await page.until(lambda: len(page.frames) > 20, "frames do not come")
            heads = [HEAD.unpack_from(frame) for frame in page.frames]
            assert all(b[0] > a[0] and b[2] >= a[2] for a, b in pairwise(heads))
            assert len(page.frames[0]) == HEAD.size + 4 * len(cockpit.columns)
            assert heads[-1][4] & Flag.LOCKED
            await page.told("status", driver="nobody", locked=True)

    serve(test)


def test_levers_move_the_machine_of_the_driver_alone(serve):
    async def test(cockpit):
        await cockpit.enter()
        async with cockpit.page() as first, cockpit.page() as second:
            await first.say(type="sticks", seq=1, axes=[0, 0, 0, -1, 0, 0])
            await first.refused("ask to drive first")
            await first.say(type="drive")
            await first.told("status", driver="you")
            await second.told("status", driver="other")
            await second.say(type="drive")
            await second.refused("another page drives")
            await second.say(type="lock", on=False)
            await second.refused("watches")
            await first.say(type="lock", on=False)
            await second.told("status", locked=False)
            begun = second.values["lift.angle"] if second.frames else 0.0
            for k in range(30):
                await first.say(type="sticks", seq=k + 2, axes=[0, 0, 0, -1, 0, 0])
                await asyncio.sleep(0.03)
            await second.until(lambda: second.values["lift.angle"] > begun + 0.02, "the lift does not rise")
            assert first.head[1] > 1
            assert first.head[4] & Flag.DRIVER
            assert not second.head[4] & Flag.DRIVER
            await second.until(lambda: second.values["lift.voltage"] == 0.0, "silence does not release the levers")
            await first.socket.close()
            await second.told("status", driver="nobody", locked=True)
            await second.say(type="drive")
            await second.told("status", driver="you", locked=True)

    serve(test)


def test_what_is_no_message_changes_nothing_and_too_much_ends_the_page(serve, caplog):
    async def test(cockpit):
        await cockpit.enter()
        async with cockpit.page() as page:
            await page.say(type="drive")
            for text, says in (
                ("{", "no JSON"),
                ('{"type": "lock", "on": "no"}', "true or false"),
                ('{"type": "sticks", "seq": 1, "axes": [0, 0, 0, NaN, 0, 0]}', "no JSON"),
                ('{"type": "fault", "name": "sabotage", "on": true}', "no fault 'sabotage'"),
                ('{"type": "exercise", "name": "dig", "action": "start", "subject": ""}', "no exercise 'dig'"),
                ('{"type": "exercise", "name": "trench", "action": "start", "subject": "Ann B."}', "nothing personal"),
                ('{"type": "replay", "name": "../../etc/passwd", "action": "play"}', "no recording"),
                ('{"type": "replay", "name": "x", "action": "pause"}', "no recording"),
                ('{"type": "payload", "mass": 1e9}', "at most"),
                ('{"type": "mode", "mode": "coordinated", "pattern": "iso"}', "no coordinated control"),
                ('{"type": "guard", "on": true}', "no guard against tipping"),
            ):
                await page.socket.send_str(text)
                await page.refused(says)
            await page.socket.send_bytes(b"\x00")
            await page.refused("as text")
            assert cockpit.beat.wanted.locked
            assert not cockpit.beat.wanted.faults
            await page.socket.send_str('{"type": "reset", "x": "' + 5000 * "x" + '"}')
            await page.until(lambda: page.socket.closed, "a message that is too long is taken")
        async with cockpit.page() as page:
            await page.told("status", driver="nobody")
        assert not caplog.records  # nothing failed in the server

    serve(test)


def test_a_drive_is_recorded_replayed_and_taken_over(serve):
    async def test(cockpit):
        await cockpit.enter()
        async with cockpit.page() as page:
            for message in ({"type": "drive"}, {"type": "lock", "on": False}, {"type": "record", "on": True}):
                await page.say(**message)
            for k in range(60):
                await page.say(type="sticks", seq=k, axes=[0, 0, 0, -1, 0, 0])
                await asyncio.sleep(0.03)
            assert page.head[4] & Flag.RECORDING
            await page.say(type="record", on=False)
            await page.until(lambda: cockpit.keeper.drives, "nothing was recorded")
            (name,) = cockpit.keeper.drives
            await page.say(type="replay", name=name, action="play")
            await page.until(lambda: page.head[4] & Flag.REPLAY, "nothing is replayed")
            await page.say(type="reset")
            await page.refused("not for a replay")
            await page.say(type="replay", name=name, action="seek", time=0.5)
            await page.say(type="replay", name=name, action="pause")
            await page.until(
                lambda: any((t.get("replay") or {}).get("playing") is False for t in page.texts), "no pause"
            )
            await page.say(type="replay", name=name, action="restart", time=0.0)
            await page.until(lambda: not page.head[4] & Flag.REPLAY, "the replay is not left")
            assert page.values["lift.angle"] > -0.2

    serve(test)


def test_results_are_served(serve):
    async def test(cockpit):
        await cockpit.enter()
        async with cockpit.page() as page:
            await page.say(type="drive")
            await page.say(type="exercise", name="trench", action="start", subject="S-7")
            await page.told("score", exercise="trench", running=True)
            await page.say(type="exercise", name="trench", action="stop")
            await page.told("score", exercise="trench", running=False, finished=False)
            for _ in range(100):
                _, body = await cockpit.get("/results.json")
                found = json.loads(body)
                if found["attempts"]:
                    break
                await asyncio.sleep(0.05)
            assert found["attempts"][0]["subject"] == "S-7"

    serve(test)


def test_a_page_that_does_not_read_holds_nobody_up(serve):
    async def test(cockpit):
        await cockpit.enter()
        name, value = cockpit.guard.cookie
        reader, writer = await asyncio.open_connection("127.0.0.1", cockpit.guard.port)
        lines = [
            "GET /live HTTP/1.1",
            f"Host: 127.0.0.1:{cockpit.guard.port}",
            f"Origin: {cockpit.base}",
            f"Cookie: {name}={value}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
        ]
        writer.write(("\r\n".join(lines) + "\r\n\r\n").encode())
        await writer.drain()
        assert b"101" in await reader.readline()
        async with cockpit.page() as page:
            await page.until(lambda: len(page.frames) > 60, "frames do not come")
        writer.close()

    serve(test)


def test_frames_are_as_the_protocol_says():
    assert HEAD.size == struct.calcsize("<IIdII") == 24
