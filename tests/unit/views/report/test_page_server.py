"""The server of a run's page: who is answered, and what a slow viewer costs the others."""

from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.acting import Acting
from pirate_sm.views.report.live_report import Edition
from pirate_sm.views.report.page_server import HOST, PageServer, serve
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.report_page import fragments, report_json


@pytest.fixture(scope="module")
def first(recording: Callable[[str], Path]) -> Edition:
    """The first edition of a page."""
    report = report_of(read_recording(recording("patrol")))
    return Edition(0, report, report_json(report), fragments(report))


def later(edition: Edition, version: int) -> Edition:
    """A later edition, in which much has changed."""
    parts = {**edition.parts, "facts": f"{version % 10}" * 4_000_000}
    return Edition(version, edition.report, {**edition.data, "duration": float(version)}, parts)


def run(work: Callable[[PageServer], Awaitable[None]]) -> None:
    """Do this with a server on a free port."""

    async def worked() -> None:
        server = PageServer(0)
        try:
            await work(server)
        finally:
            await server.end()

    asyncio.run(worked())


async def pressed(server: PageServer, button: str, **headers: str) -> tuple[int, str]:
    """The status and the words that a press is answered with."""
    request = HTTPRequest(f"{server.address}presses", "POST", headers, button)
    found = await AsyncHTTPClient(force_instance=True).fetch(request, raise_error=False)
    return found.code, found.body.decode() if found.body else ""


def test_only_who_has_the_token_may_press_a_button_and_only_on_the_page_itself() -> None:
    done: list[str] = []
    acting = Acting(["stop", "pause"], lambda name: bool(done.append(name)) or True)

    async def work() -> None:
        server = PageServer(0, acting)
        own = {"Origin": server.address.rstrip("/"), "Authorization": f"Bearer {acting.token}"}
        wrong = [
            {**own, "Authorization": ""},
            {**own, "Authorization": acting.token},
            {**own, "Authorization": f"Bearer {acting.token}x"},
            {**own, "Authorization": "Bearer \xe4"},
        ]
        elsewhere = [
            {**own, "Origin": "http://evil.example"},
            {**own, "Origin": "null"},
            {"Authorization": own["Authorization"]},
            {**own, "Host": "evil.example"},
        ]
        for headers in wrong:
            code, said = await pressed(server, "stop", **headers)
            assert (code, "open the address that the run printed" in said) == (403, True)
        for headers in elsewhere:
            assert (await pressed(server, "stop", **headers))[0] == 403
        assert await pressed(server, "stop\n", **own) == (
            400,
            "This page has other buttons: stop, pause",
        )
        assert (await pressed(server, "x" * 5_000, **own))[0] == 400
        assert not done
        assert await pressed(server, "stop", **own) == (204, "")
        assert done == ["stop"]
        await server.end()

    asyncio.run(work())


def test_a_page_without_a_run_listens_to_no_press(first: Edition) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        code, said = await pressed(server, "stop", Origin=server.address.rstrip("/"))
        assert (code, said) == (409, "This page only shows: no run listens to it")

    run(work)


def test_a_page_of_the_run_before_is_loaded_again_when_another_one_is_shown(
    first: Edition, recording: Callable[[str], Path]
) -> None:
    async def work(server: PageServer) -> None:
        assert "No run yet" in (await answer(server))[1]
        await server.show(first.report)
        _, page, _ = await answer(server)
        viewer = await listened(server)

        await server.show(recording("patrol"))

        assert await viewer.read_message() == "{}"
        newest = await server.editions.hand_out()
        assert f'"version":"{server.editions.name(newest)}"' not in page
        viewer.close()

    run(work)


def test_a_page_that_is_made_when_it_is_asked_for_is_made_again_each_time() -> None:
    made = iter(["<p>one", "<p>two"])

    async def work(server: PageServer) -> None:
        await server.show(lambda: next(made))
        assert [(await answer(server))[1] for _ in range(2)] == ["<p>one", "<p>two"]

    run(work)


async def answer(server: PageServer, **headers: str) -> tuple[int, str, Any]:
    """The status, the text and the headers that a request is answered with."""
    request = HTTPRequest(server.address, headers=headers)
    try:
        found = await AsyncHTTPClient(force_instance=True).fetch(request)
    except HTTPClientError as error:
        return error.code, "", {}
    return found.code, found.body.decode(), found.headers


def test_only_requests_to_this_very_server_are_answered(first: Edition) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        port = server.port

        assert (await answer(server))[0] == 200
        assert (await answer(server, Host=f"localhost:{port}"))[0] == 200
        for other in ("evil.example", f"evil.example:{port}", HOST, f"{HOST}.evil.example:{port}"):
            assert (await answer(server, Host=other))[0] == 403, other

    run(work)


def test_no_other_page_may_read_it_show_it_or_listen(first: Edition) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        _, _, headers = await answer(server)
        assert headers["X-Frame-Options"] == "DENY"
        assert "Access-Control-Allow-Origin" not in headers
        for origin in ("http://evil.example", "null", f"http://{HOST}.evil.example"):
            with pytest.raises(HTTPClientError, match="403"):
                await listened(server, origin)
        (await listened(server)).close()

    run(work)


async def listened(server: PageServer, origin: str = "", since: str | None = None) -> Any:
    """A connection that listens to changes since an edition, else since the newest."""
    newest = server.editions.newest
    since = since if since is not None or newest is None else server.editions.name(newest)
    url = f"ws://{HOST}:{server.port}/changes?since={since}"
    headers = {"Origin": origin or server.address.rstrip("/")}
    return await websocket_connect(HTTPRequest(url, headers=headers), max_message_size=1 << 28)


def test_a_page_gets_what_has_changed_since_it_was_made(first: Edition) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        _, page, _ = await answer(server)
        name = server.editions.name(first)
        assert f'"version":"{name}"' in page
        server.editions.take(later(first, 1))
        viewer = await listened(server, since=name)

        message = json.loads(await viewer.read_message())

        assert message["version"] == server.editions.name(later(first, 1)) != name
        assert message["changes"] == [[["data", "duration"], 1.0]]
        assert [*message["parts"]] == ["facts"]
        viewer.close()

    run(work)


def test_a_page_of_an_edition_that_is_not_known_is_loaded_again(first: Edition) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        _, page, _ = await answer(server)
        for since in ("7", "0", "x", "-1", "", "9" * 5_000):
            assert f'"version":"{since}"' not in page
            viewer = await listened(server, since=since)
            assert await viewer.read_message() == "{}"
            viewer.close()

    run(work)


def test_a_viewer_that_takes_nothing_holds_up_no_other_and_costs_no_more_memory(
    first: Edition, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        await answer(server)
        slow = socket.create_connection((HOST, server.port))  # it asks, and never reads
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4_096)
        slow.sendall(
            f"GET /changes?since={server.editions.name(first)} HTTP/1.1\r\n"
            f"Host: {HOST}:{server.port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Origin: http://{HOST}:{server.port}\r\n"
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        quick = await listened(server)
        while server.editions.viewers < 2:
            await asyncio.sleep(0.01)
        made, changed = [0, 0], server.editions.changed

        def counted(before: Edition, newest: Edition) -> str:
            made[before.version == newest.version - 1] += 1
            return changed(before, newest)

        monkeypatch.setattr(server.editions, "changed", counted)
        for version in range(1, 13):
            server.editions.take(later(first, version))
            assert json.loads(await quick.read_message())["changes"][-1][-1] == version

        assert sum(made) < 20  # the slow one got what fits into its connection, and no more
        slow.close()
        quick.close()

    run(work)


def test_a_page_of_another_run_at_this_address_is_loaded_again(first: Edition) -> None:
    async def work(server: PageServer) -> None:
        server.editions.take(first)
        await answer(server)
        other = PageServer(0)
        try:
            other.editions.take(first)
            await answer(other)
            server.editions.take(later(first, 1))
            viewer = await listened(server, since=other.editions.name(first))
            assert await viewer.read_message() == "{}"
            viewer.close()
        finally:
            await other.end()

    run(work)


def test_a_port_that_is_asked_for_must_be_free() -> None:
    async def work(server: PageServer) -> None:
        with pytest.raises(UsageError, match="Address already in use"):
            PageServer(server.port)

    run(work)


def test_the_server_is_there_before_the_first_report(
    recording: Callable[[str], Path],
) -> None:
    said: list[str] = []

    async def until(server: Any) -> None:
        request = HTTPRequest(said[0], request_timeout=60.0)  # a busy computer takes its time
        found = await AsyncHTTPClient(force_instance=True).fetch(request)
        assert "</html>" in found.body.decode()

    async def work() -> None:
        await serve(recording("patrol"), 0, said.append, until)
        with pytest.raises(ConnectionRefusedError):  # it has closed its port
            await asyncio.open_connection(HOST, int(said[0].rstrip("/").rpartition(":")[2]))

    asyncio.run(work())

    assert said[0].startswith(f"http://{HOST}:")


def test_who_waits_for_the_page_of_a_damaged_recording_is_not_left_waiting(
    recording: Callable[[str], Path], tmp_path: Path
) -> None:
    source, path = recording("patrol"), tmp_path / "run.mcap"
    damaged, piece = bytearray(source.read_bytes()), read_recording(source).content.pieces[3]
    damaged[piece.at + piece.size // 2] ^= 0xFF
    path.write_bytes(damaged)

    with pytest.raises(RecordingError, match="is damaged"):
        asyncio.run(serve(path, 0, lambda _: None, lambda _: asyncio.Event().wait()))
