"""What an editor can do with the mission in a file: run, rehearse and draw it.

Each is the ordinary command in a process of its own, always with the simulator: no editor moves a
real robot. One at a time runs for a file, and it can be stopped.
"""

from __future__ import annotations

import asyncio
import os
import re
import signal
import sys
import tempfile
from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping
from contextlib import asynccontextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, Final, NamedTuple
from uuid import uuid4

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from pirate_sm.core.documents import FileKind, kind_of_text
from pirate_sm.core.errors import ExitCode
from pirate_sm.views.editor.shown_findings import text_on_disk

_PROGRAM: Final = (sys.executable, "-P", "-c", "from pirate_sm.cli.start import main; main()")
"""Starts the command without looking for modules in the folder that the editor has opened."""

_TO_END_S: Final = 5.0
"""How long a stopped process may take to end. [decided]"""

_MISSION = re.compile(r"^mission[ ]*:", re.MULTILINE)

FILE, OUT = "{file}", "{out}"
"""In a line: the mission's file, and the new file for what is made of it, without its ending."""


class MissionUse(NamedTuple):
    """What can be done with a mission.

    Attributes:
        title: What the editor calls it.
        lines: The commands that do it, one after the other.
        shown: The ending of the file that is shown then.
    """

    title: str
    lines: tuple[tuple[str, ...], ...]
    shown: str


_RUN = ("run", FILE, "--backend", "sim", "--yes", "--quiet", "--record", f"{OUT}.mcap")
USES: Final = {
    "pirate_sm.simulate": MissionUse(
        "Run in the simulator",
        (_RUN, ("report", f"{OUT}.mcap", "--output", f"{OUT}.html")),
        ".html",
    ),
    "pirate_sm.rehearse": MissionUse("Rehearse", (("check", FILE, "--rehearse"),), ".txt"),
    "pirate_sm.graph": MissionUse(
        "Show the graph", (("graph", FILE, "--output", f"{OUT}.svg"),), ".svg"
    ),
}
STOP: Final = "pirate_sm.stop"


class MissionRuns:
    """Runs commands for an editor, and offers them above each mission.

    Args:
        server: The server; the commands become commands of it.
        opened: Returns the open files by their paths.
    """

    def __init__(self, server: LanguageServer, opened: Callable[[], Mapping[str, Any]]) -> None:
        self._server, self._opened = server, opened
        self._running: dict[str, asyncio.Task[None]] = {}
        self._folder = tempfile.TemporaryDirectory(prefix="pirate_sm-")
        for name in (*USES, STOP):
            server.command(name)(self._command(name))
        server.feature(types.TEXT_DOCUMENT_CODE_LENS)(partial(self._lenses))

    def close(self) -> None:
        """Remove what the commands have made."""
        self._folder.cleanup()

    def actions(self, uri: str, text: str, wanted: types.Range) -> Iterator[types.CodeAction]:
        """Yield what can be done with a mission as actions, for editors that show no lenses."""
        for place, command in self._offered(uri, text):
            if wanted.start.line <= place.start.line <= wanted.end.line:
                yield types.CodeAction(command.title, command=command)

    def _lenses(self, asked: types.CodeLensParams) -> list[types.CodeLens]:
        uri = asked.text_document.uri
        text = self._server.workspace.get_text_document(uri).source
        return [types.CodeLens(place, command) for place, command in self._offered(uri, text)]

    def _offered(self, uri: str, text: str) -> Iterator[tuple[types.Range, types.Command]]:
        """Yield what can be done now, with the line of the mission's name."""
        found = _MISSION.search(text)
        if found is None or kind_of_text(text) is not FileKind.MISSION:
            return
        at = types.Position(len(re.findall(r"\r\n|\r|\n", text[: found.start()])), 0)
        titles = {name: use.title for name, use in USES.items()}
        for name, title in ({STOP: "Stop it"} if uri in self._running else titles).items():
            yield types.Range(at, at), types.Command(title, name, arguments=[uri])

    def _not_saved(self) -> list[str]:
        """Return the names of files of known kinds whose text is not the one that is saved."""
        return [
            os.path.relpath(path)
            for path, file in self._opened().items()
            if text_on_disk(path) != file.source and kind_of_text(file.source) is not FileKind.OTHER
        ]

    def _command(self, name: str) -> Callable[..., None]:
        """Return what the server does for a command: it begins, and reports later how it ended."""

        def command(*arguments: Any) -> None:
            uri = arguments[0] if arguments and isinstance(arguments[0], str) else ""
            path = uri and to_fs_path(uri)
            task = self._running.get(uri)
            if name == STOP:
                if task is not None:
                    task.cancel()
            elif task is not None:
                self._say("This mission is in use already; stop that first", wrong=True)
            elif not path or not Path(path).is_file():
                self._say("There is no file of a mission to do this with: save it", wrong=True)
            elif names := self._not_saved():
                self._say(f"Not saved: {', '.join(names)}; save, then try again", wrong=True)
            else:
                self._running[uri] = asyncio.ensure_future(self._use(USES[name], uri, path))
                self._offer_again()

        return command

    async def _use(self, use: MissionUse, uri: str, path: str) -> None:
        """Do something with a mission, and show what comes of it."""
        stem = Path(path).stem
        try:
            async with self._progress(f"{use.title}: {stem}"):
                folder = await asyncio.to_thread(tempfile.mkdtemp, dir=self._folder.name)
                await self._made(use, path, Path(folder) / stem)
        except asyncio.CancelledError:
            self._say(f"{use.title}: {stem} has been stopped")
        except OSError as error:
            self._say(f"{use.title}: {stem}: {error}", wrong=True)
        finally:
            del self._running[uri]
            self._offer_again()

    async def _made(self, use: MissionUse, path: str, out: Path) -> None:
        """Run the commands, and show what they make."""
        shown, said = out.with_name(f"{out.name}{use.shown}"), ""
        for number, line in enumerate(use.lines):
            code, output, errors = await _ended(each.format(file=path, out=out) for each in line)
            if code not in (ExitCode.SUCCEEDED, ExitCode.FAILED):
                return self._say(errors or output or f"It ended with exit code {code}", wrong=True)
            said = said if number else output
        if not shown.exists():
            shown.write_text(said, "utf-8")
            said = said.strip().rpartition("\n")[2]
        said = said.strip() or f"{use.title}: {out.name}"
        window = self._server.client_capabilities.window
        if not (window and window.show_document and window.show_document.support):
            return self._say(f"{said}\nIt is in {shown}")
        self._say(said)
        uri, outside = str(from_fs_path(str(shown))), use.shown != ".txt"
        params = types.ShowDocumentParams(uri, external=outside, take_focus=True)
        self._server.window_show_document(params)
        return None

    @asynccontextmanager
    async def _progress(self, title: str) -> AsyncIterator[None]:
        """Return a context in which the editor shows that something runs, and can stop it."""
        window = self._server.client_capabilities.window
        if not (window and window.work_done_progress):
            yield
            return
        progress, token, task = (
            self._server.work_done_progress,
            str(uuid4()),
            asyncio.current_task(),
        )
        await progress.create_async(token)
        progress.begin(token, types.WorkDoneProgressBegin(title, cancellable=True))
        wish = progress.tokens[token]
        wish.add_done_callback(lambda _: task and task.cancel())
        try:
            yield
        finally:
            del progress.tokens[token]
            progress.end(token, types.WorkDoneProgressEnd())

    def _offer_again(self) -> None:
        """Let the editor ask what is offered above missions."""
        wide = self._server.client_capabilities.workspace
        if wide and wide.code_lens and wide.code_lens.refresh_support:
            self._server.workspace_code_lens_refresh(None)

    def _say(self, text: str, *, wrong: bool = False) -> None:
        kind = types.MessageType.Error if wrong else types.MessageType.Info
        self._server.window_show_message(types.ShowMessageParams(kind, text.strip()))


async def _ended(line: Iterable[str]) -> tuple[int, str, str]:
    """Return the exit code of a command, and what it writes; stop it if this is cancelled."""
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(
        *_PROGRAM,
        *line,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=pipe,
        stderr=pipe,
        start_new_session=True,
    )
    try:
        output, errors = await process.communicate()
    finally:
        if process.returncode is None:
            await _stop(process)
    return process.returncode or 0, output.decode(errors="replace"), errors.decode(errors="replace")


async def _stop(process: asyncio.subprocess.Process) -> None:
    """End a process with its children: as for a signal to end, and by force if that takes long."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGTERM)
        with suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), _TO_END_S)
        os.killpg(process.pid, signal.SIGKILL)
