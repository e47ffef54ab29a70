"""Serves the page of a run on loopback, during the run and after it.

It reads the recording as it grows, so that the run knows nothing of it. Each viewer gets what has
changed since the edition that it has, when it has taken the last change: a slow one skips editions
and holds up nothing.
"""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Awaitable, Callable
from errno import EADDRINUSE
from functools import cached_property
from pathlib import Path
from socket import create_server
from typing import Any, Final, TypeAlias

from tornado.httpserver import HTTPServer
from tornado.iostream import IOStream
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from pirate_sm.core.errors import UsageError
from pirate_sm.views.report.acting import Acting, Refusal
from pirate_sm.views.report.changes import changes
from pirate_sm.views.report.contents import Report
from pirate_sm.views.report.live_report import Edition, LiveReport, edition_of
from pirate_sm.views.report.report_page import html

HOST: Final = "127.0.0.1"

PORT: Final = 8790
"""The port that is tried first, so that a page has the same address the next time."""

_MOST_HANDED_OUT = 16
"""So many pages may be loading at a time; a page that takes longer is loaded again."""

_PING_S = 10.0
"""A viewer that answers no ping is taken for closed."""

_ASKS_MOST = 1 << 10
"""The largest message that a viewer may send, bytes."""

_BEARER = "Bearer "
"""What precedes a token in a request (RFC 6750)."""


_NOTHING = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta http-equiv="refresh" content="2">
<meta name="color-scheme" content="light dark"><title>No run yet</title></head>
<body style="font: 16px system-ui, sans-serif; margin: 2em"><h1>No run yet</h1>
<p>The page of a mission is shown here as soon as it is at hand. What is driven by hand without a
mission is not recorded, and is not shown.</p></body></html>
"""


class Editions:
    """The newest edition of the page of a run, for viewers that wait for the next one.

    Pages know an edition by a name that no other server gives: a page that stays open while
    another run is served at its address must not take the changes of that one.

    Attributes:
        run: A name of the run that no other one has.
        newest: The newest edition; None before the first.
        viewers: Number of pages that are open.
        streams: The connections over which changes are sent.
    """

    def __init__(self) -> None:
        self.viewers = 0
        self.streams = set[IOStream]()
        self._next = asyncio.get_running_loop().create_future()
        self.begin()

    def begin(self) -> None:
        """Begin with the editions of another run."""
        self.run = secrets.token_hex(8)
        self.newest: Edition | None = None
        self._encoded: dict[int, str] = {}
        self._handed_out: dict[int, Edition] = {}

    async def hand_out(self) -> Edition:
        """Return the newest edition for a page, which will ask for what follows it."""
        edition = await self.after(None)
        self._handed_out[edition.version] = edition
        while len(self._handed_out) > _MOST_HANDED_OUT:
            del self._handed_out[min(self._handed_out)]
        return edition

    def name(self, edition: Edition) -> str:
        """Return the name by which pages know an edition."""
        return f"{self.run}.{edition.version}"

    def handed_out(self, name: str) -> Edition | None:
        """Return the edition of this name that a page has; None if it is not kept."""
        return next((each for each in self._handed_out.values() if self.name(each) == name), None)

    def take(self, edition: Edition) -> None:
        """Make this the newest edition."""
        self.newest, self._encoded = edition, {}
        arrived, self._next = self._next, asyncio.get_running_loop().create_future()
        arrived.set_result(None)

    async def after(self, edition: Edition | None) -> Edition:
        """Return the newest edition, as soon as it is another one than this."""
        while self.newest is None or self.newest is edition:
            await asyncio.shield(self._next)
        return self.newest

    def changed(self, before: Edition, newest: Edition) -> str:
        """Return the message that turns a page of one edition into the newest."""
        if before.version not in self._encoded:
            parts = {
                name: text for name, text in newest.parts.items() if text != before.parts[name]
            }
            message = {
                "version": self.name(newest),
                "parts": parts,
                "changes": [*changes({"data": before.data}, {"data": newest.data})],
            }
            self._encoded[before.version] = json.dumps(message, separators=(",", ":"))
        return self._encoded[before.version]


class _OnLoopback(RequestHandler):
    """A request to this very server: one by another name comes from a foreign page."""

    def prepare(self) -> None:
        """Refuse a request for another host."""
        port = self.application.settings["port"]
        if self.request.host not in (f"{HOST}:{port}", f"localhost:{port}"):
            raise HTTPError(403, reason="This server is for pages of this computer only")

    def set_default_headers(self) -> None:
        """Let no other page show this one or read it."""
        self.set_header("X-Frame-Options", "DENY")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-store")

    @cached_property
    def editions(self) -> Editions:
        """Return the editions of the page."""
        found: Editions = self.application.settings["editions"]
        return found


class _Page(_OnLoopback):
    """The page as it is now."""

    async def get(self) -> None:
        """Answer with the page."""
        shows: Callable[[], str] | bool = self.application.settings["shows"]
        if callable(shows):
            self.finish(await asyncio.to_thread(shows))
            return
        if self.editions.newest is None and not shows:
            self.finish(_NOTHING)
            return
        edition = await self.editions.hand_out()
        acting: Acting | None = self.application.settings["acting"]
        buttons = acting.buttons if acting is not None else ()
        self.finish(html(edition.report, self.editions.name(edition), buttons))


class _Presses(_OnLoopback):
    """Takes what viewers press."""

    def post(self) -> None:
        """Pass a press on to the run, or say why not."""
        acting: Acting | None = self.application.settings["acting"]
        sent = self.request.headers.get("Authorization", "")
        token = sent.removeprefix(_BEARER) if sent.startswith(_BEARER) else ""
        if self.request.headers.get("Origin") != f"http://{self.request.host}":
            refusal: Refusal | None = Refusal(403, "Only the page itself may ask")
        elif acting is None:
            refusal = Refusal(409, "This page only shows: no run listens to it")
        else:
            refusal = acting.press(token, self.request.body.decode(errors="replace"))
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        if refusal is None:
            self.set_status(204)
        else:
            self.set_status(refusal.status)
            self.write(refusal.why)


class _Changes(_OnLoopback, WebSocketHandler):
    """Sends one viewer what changes."""

    def check_origin(self, origin: str) -> bool:
        """Return whether the page that asks comes from here."""
        return origin == f"http://{self.request.host}"

    def open(self, *_: str, **__: str) -> None:
        """Begin to send."""
        self.editions.viewers += 1
        if self.ws_connection is not None and self.ws_connection.stream is not None:
            self._stream = self.ws_connection.stream
            self.editions.streams.add(self._stream)
        self._sending = asyncio.ensure_future(self._send())

    def on_message(self, message: str | bytes) -> None:
        """Ignore it: viewers have nothing to say."""

    def on_close(self) -> None:
        """Stop sending."""
        self.editions.viewers -= 1
        self.editions.streams.discard(self._stream)
        self._sending.cancel()

    async def _send(self) -> None:
        run = self.editions.run
        edition = self.editions.handed_out(self.get_query_argument("since", ""))
        try:
            while edition is not None:
                newest = await self.editions.after(edition)
                if self.editions.run != run:
                    break
                # A viewer that leaves ends this task, but not the library's own writing.
                await asyncio.shield(self.write_message(self.editions.changed(edition, newest)))
                edition = newest
            await self.write_message("{}")  # it is to load the page again
        except WebSocketClosedError:
            pass


Shown: TypeAlias = Path | Report | Callable[[], str]
"""The recording of a run, which may be under way; a report; or what makes the page as HTML
whenever it is asked for, in a thread of its own."""


class PageServer:
    """The server of the page of a run.

    Args:
        port: The port; None: the default one, or any other that is free.
        acting: The buttons of the page; None: it only shows.

    Attributes:
        editions: The editions of the page.
        port: The port.
        failure: Gets the exception that leaves the server without a page.

    Raises:
        UsageError: The port is in use.
    """

    def __init__(self, port: int | None = None, acting: Acting | None = None) -> None:
        self.editions = Editions()
        self.failure = asyncio.get_running_loop().create_future()
        self._report: LiveReport | None = None
        try:
            own = create_server((HOST, PORT if port is None else port))
        except OSError as error:
            if port is not None or error.errno != EADDRINUSE:
                where = f"{HOST}:{PORT if port is None else port}"
                raise UsageError(
                    f"the page cannot be served on {where}: {error.strerror}"
                ) from None
            own = create_server((HOST, 0))
        own.setblocking(False)
        self.port: int = own.getsockname()[1]
        self._application = Application(
            [("/", _Page), ("/changes", _Changes), ("/presses", _Presses)],
            editions=self.editions,
            acting=acting,
            shows=False,
            port=self.port,
            websocket_ping_interval=_PING_S,
            websocket_max_message_size=_ASKS_MOST,
            log_function=lambda handler: None,
        )
        self._server = HTTPServer(self._application, max_body_size=_ASKS_MOST)
        self._server.add_sockets([own])

    @property
    def address(self) -> str:
        """Return the address for a browser."""
        return f"http://{HOST}:{self.port}/"

    async def show(self, shown: Shown, forecast: Path | None = None) -> None:
        """Serve the page of a recording, or a report; pages that show another one load again.

        Args:
            shown: What it shows.
            forecast: File with earlier runs to compare a recording with.

        Raises:
            RecordingError: It is not a recording.
        """
        await self._end_report()
        self.editions.begin()
        self._application.settings["shows"] = shown if callable(shown) else True
        if callable(shown):
            return
        if isinstance(shown, Report):
            self.editions.take(edition_of(shown))
            return
        loop = asyncio.get_running_loop()

        def take(edition: Edition) -> None:  # in the thread of the report
            loop.call_soon_threadsafe(self.editions.take, edition)

        def failed(error: Exception) -> None:  # in the thread of the report
            loop.call_soon_threadsafe(self._fail, error)

        self._report = LiveReport(shown, take, failed, forecast)
        self._report.start()

    def _fail(self, error: Exception) -> None:
        if not self.failure.done():
            self.failure.set_exception(error)

    async def _end_report(self) -> None:
        report, self._report = self._report, None
        if report is not None:
            await asyncio.to_thread(report.close)

    def close(self) -> None:
        """Stop listening."""
        self._server.stop()

    async def end(self) -> None:
        """Stop listening, close the connections of all viewers, and follow no recording."""
        self.close()
        for each in [*self.editions.streams]:
            each.close()
        await self._server.close_all_connections()
        await self._end_report()


async def serve(
    shown: Shown | None,
    port: int | None,
    said: Callable[[str], object],
    until: Callable[[PageServer], Awaitable[object]],
    acting: Acting | None = None,
    forecast: Path | None = None,
) -> None:
    """Serve a page.

    Args:
        shown: What it shows; None: nothing yet.
        port: The port; None: the default one, or any other that is free.
        said: Receives the address, once it can be opened.
        until: Returns when the server is to end, unless it is cancelled before.
        acting: The buttons of the page; None: it only shows.
        forecast: File with earlier runs to compare a recording with.

    Raises:
        RecordingError: The recording cannot be read; also if that is found after the address
            was said, but before there is a page.
        UsageError: The port is in use.
    """
    server = PageServer(port, acting)
    try:
        if shown is not None:
            await server.show(shown, forecast)
        said(server.address)
        await _first(asyncio.ensure_future(until(server)), server.failure)
    finally:
        await server.end()


async def _first(*awaited: asyncio.Future[Any]) -> None:
    """Wait until one of these is done, and cancel the others.

    Raises:
        Exception: The one that is done has raised it.
    """
    try:
        done, _ = await asyncio.wait(awaited, return_when=asyncio.FIRST_COMPLETED)
        for each in done:
            each.result()
    finally:
        for each in awaited:
            each.cancel()
