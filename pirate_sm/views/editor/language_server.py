"""The language server: checks the open files after each change, and answers the editor.

The loop of events takes texts and answers questions. Checks are made one after the other in a
thread, each on the texts as they are when it begins. What it finds is shown if the texts are
still the same when it ends.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import to_fs_path

from pirate_sm import __version__
from pirate_sm.checking.kept_results import KeptInMemory
from pirate_sm.checking.mission.check_mission import noting_missions
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.core.documents import (
    Document,
    FileKind,
    LoadError,
    kind_of_text,
    parse_document,
)
from pirate_sm.core.errors import PirateError
from pirate_sm.core.on_disk import unsaved
from pirate_sm.views.editor import expression_tokens, inlay_hints, outline
from pirate_sm.views.editor.asked_place import content_of
from pirate_sm.views.editor.editor_wishes import EditorWishes
from pirate_sm.views.editor.known_mission import KnownMission
from pirate_sm.views.editor.mission_runs import MissionRuns
from pirate_sm.views.editor.place_answers import PlaceAnswers
from pirate_sm.views.editor.positions import Positions
from pirate_sm.views.editor.refactorings import Refactorings
from pirate_sm.views.editor.shown_findings import SOURCE, CheckedTexts, of_kinds

R = TypeVar("R")

Check = Callable[[list[str]], CheckReport]
"""Checks files by their paths."""

_PAUSE_S = 0.04
"""How long nothing must be typed before a check begins. [decided]"""


class Editor:
    """The server of one editor.

    Args:
        check: Checks files.
    """

    def __init__(self, check: Check) -> None:
        self._check, self._memory = check, KeptInMemory()
        self._server = LanguageServer(
            SOURCE, __version__, text_document_sync_kind=types.TextDocumentSyncKind.Full
        )
        self._changed = asyncio.Event()
        self._work: asyncio.Task[None] | None = None
        self._last: CheckedTexts | None = None
        self._shown: set[str] = set()
        self._unread: set[str] = set()
        self._outlined: dict[str, tuple[Document, Positions]] = {}
        self._missions: dict[str, KnownMission] = {}
        self._wishes = EditorWishes(self._server)
        answers: dict[str, Callable[[Any], Any]] = {
            types.INITIALIZE: self._enter_project,
            types.INITIALIZED: self._begin,
            types.TEXT_DOCUMENT_DID_OPEN: self._note_change,
            types.TEXT_DOCUMENT_DID_CHANGE: self._note_change,
            types.TEXT_DOCUMENT_DID_SAVE: self._note_change,
            types.TEXT_DOCUMENT_DID_CLOSE: self._close,
            types.WORKSPACE_DID_CHANGE_WATCHED_FILES: self._note_change,
            types.TEXT_DOCUMENT_DOCUMENT_SYMBOL: self._symbols,
            types.TEXT_DOCUMENT_FOLDING_RANGE: self._folds,
            types.TEXT_DOCUMENT_INLAY_HINT: self._inlay_hints,
            types.WORKSPACE_DID_CHANGE_CONFIGURATION: self._wishes.change,
        }
        for name, answer in answers.items():
            self._server.feature(name)(partial(answer))
        self._runs = MissionRuns(self._server, self._open)
        self._refactorings = Refactorings(self._server, self._open, check)
        kind = types.CodeActionKind
        kinds = [kind.QuickFix, kind.SourceFixAll, kind.RefactorExtract]
        offered = types.CodeActionOptions(code_action_kinds=kinds)
        self._server.feature(types.TEXT_DOCUMENT_CODE_ACTION, offered)(partial(self._actions))
        PlaceAnswers(self._server, self._open, check, self._wishes, self._mission)
        legend = types.SemanticTokensLegend([each.value for each in expression_tokens.TYPES], [])
        self._server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, legend)(
            partial(self._tokens)
        )

    def serve(self, messages: BinaryIO, answers: BinaryIO) -> None:
        """Answer until the editor ends.

        Args:
            messages: Where messages come from.
            answers: Where answers go; it is closed then.
        """
        try:
            self._server.start_io(messages, answers)
        finally:
            self._runs.close()

    # --- the editor and its files ---

    def _enter_project(self, said: types.InitializeParams) -> None:
        """Work in the folder of the project, from which files have their names."""
        self._wishes.take(said.initialization_options)
        folders = [*self._server.workspace.folders] or [self._server.workspace.root_uri]
        root = folders[0] and to_fs_path(folders[0])
        with suppress(OSError):
            os.chdir(root or ".")

    def _begin(self, _: types.InitializedParams) -> None:
        self._work = asyncio.ensure_future(self._keep_checking())
        files = self._server.client_capabilities.workspace
        watched = files and files.did_change_watched_files
        if watched and watched.dynamic_registration:
            every = types.FileSystemWatcher("**/*.{yaml,yml,toml}")
            wanted = types.DidChangeWatchedFilesRegistrationOptions([every])
            name = types.WORKSPACE_DID_CHANGE_WATCHED_FILES
            registration = types.Registration(name, name, wanted)
            self._server.client_register_capability(types.RegistrationParams([registration]))

    def _note_change(self, _: Any) -> None:
        self._changed.set()

    def _close(self, closed: types.DidCloseTextDocumentParams) -> None:
        self._outlined.pop(closed.text_document.uri, None)
        self._changed.set()

    def _open(self) -> dict[str, Any]:
        """Return the open files by their paths; not what only the editor calls a file."""
        files = self._server.workspace.text_documents.values()
        return {os.path.realpath(file.path): file for file in files if _may_be_file(file.uri)}

    def _mission(self, path: str) -> KnownMission | None:
        return self._missions.get(path)

    # --- checks ---

    async def _keep_checking(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            await asyncio.sleep(_PAUSE_S)
            if self._changed.is_set():
                continue
            try:
                await self._check_all()
            except Exception as error:  # the next text may do
                self._say(error)

    async def _check_all(self) -> None:
        """Check the open files, and show what is found if they are still the same then."""
        files = self._open()
        texts = {path: content_of(file.source) for path, file in files.items()}
        uris = {path: file.uri for path, file in files.items()}
        loop, unread = asyncio.get_running_loop(), frozenset(self._unread & texts.keys())
        last = self._last.texts if self._last else {}
        self._unread = {path for path in texts if path in unread or texts[path] != last.get(path)}

        def loaded(file: Path) -> None:
            path = os.path.realpath(file)
            self._unread.discard(path)
            if path in unread:
                loop.call_soon_threadsafe(self._withdraw, uris[path])

        checked, shown = await asyncio.to_thread(self._checked, texts, uris, loaded)
        if not self._changed.is_set():
            self._last = checked
            self._show(shown, {file.uri: file.version for file in files.values()})
            self._wishes.refresh_hints()

    def _checked(
        self, texts: dict[str, bytes], uris: dict[str, str], loaded: Callable[[Path], None]
    ) -> tuple[CheckedTexts, dict[str, list[types.Diagnostic]]]:
        """Return what the check says of the open files of known kinds."""
        known = [
            path
            for path, content in texts.items()
            if kind_of_text(content.decode(errors="replace")) is not FileKind.OTHER
        ]
        with unsaved(texts), self._memory.used(), noting_missions(loaded) as noted:
            report = self._check(known) if known else CheckReport((), ())
        last = {path: each for path, each in self._missions.items() if path in texts}
        for file, each in noted.items():
            if each.loaded is not None:
                last[os.path.realpath(file)] = KnownMission.checked(each.loaded, each.explored)
        self._missions = last
        checked = CheckedTexts(report, texts, uris, self._server.workspace.position_codec)
        return checked, checked.diagnostics()

    def _withdraw(self, uri: str) -> None:
        """Show no longer why a mission cannot be loaded; what else is found takes longer."""
        if uri in self._shown and not self._changed.is_set():
            self._server.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, []))

    def _show(
        self, shown: dict[str, list[types.Diagnostic]], versions: dict[str, int | None]
    ) -> None:
        """Show findings, in open files last, and no longer those of files that have none now."""
        for uri in self._shown - shown.keys():
            shown[uri] = []
        for uri, found in sorted(shown.items(), key=lambda each: each[0] in versions):
            params = types.PublishDiagnosticsParams(uri, found, versions.get(uri))
            self._server.text_document_publish_diagnostics(params)
        self._shown = {uri for uri, found in shown.items() if found}

    def _say(self, error: Exception) -> None:
        known = isinstance(error, PirateError)
        text = str(error) if known else f"an internal error: {type(error).__name__}: {error}"
        params = types.ShowMessageParams(types.MessageType.Error, text)
        self._server.window_show_message(params)

    # --- questions ---

    def _actions(self, asked: types.CodeActionParams) -> list[types.CodeAction]:
        """Return what can be done with a part of a file; findings count if they are of its text."""
        file = self._server.workspace.get_text_document(asked.text_document.uri)
        path, last = os.path.realpath(file.path), self._last
        about = asked.text_document.uri, file.source, asked.range
        offered = [*self._refactorings.actions(*about), *self._runs.actions(*about)]
        if last is not None and last.texts.get(path) == content_of(file.source):
            offered = [*last.actions(path, asked.range), *offered]
        return of_kinds(offered, asked.context.only or [])

    def _symbols(self, asked: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
        return self._outline(asked.text_document.uri, outline.symbols)

    def _folds(self, asked: types.FoldingRangeParams) -> list[types.FoldingRange]:
        return self._outline(asked.text_document.uri, outline.folds)

    def _tokens(self, asked: types.SemanticTokensParams) -> types.SemanticTokens:
        """Return the words of the conditions in a file."""
        found = self._parsed(asked.text_document.uri)
        return types.SemanticTokens(expression_tokens.encoded(*found) if found else [])

    async def _inlay_hints(self, asked: types.InlayHintParams) -> list[types.InlayHint]:
        uri = asked.text_document.uri
        if not self._wishes.hints or (found := self._parsed(uri)) is None:
            return []
        document, positions = found
        path = os.path.realpath(self._server.workspace.get_text_document(uri).path)
        known = self._missions.get(path)
        known = known if known and known.text == document.text else None
        part = positions.index_of(asked.range.start), positions.index_of(asked.range.end)
        return await asyncio.to_thread(
            lambda: [*inlay_hints.hints(document, positions, known, *part)]
        )

    def _parsed(self, uri: str) -> tuple[Document, Positions] | None:
        """Return a file of a known kind with its positions; None while it cannot be read."""
        file = self._server.workspace.get_text_document(uri)
        with suppress(LoadError):
            document = parse_document(file.source, file.path)
            if kind_of_text(document.text) is not FileKind.OTHER:
                return document, Positions(document.text, self._server.workspace.position_codec)
        return None

    def _outline(self, uri: str, of: Callable[[Document, Positions], list[R]]) -> list[R]:
        """Return an outline of a file; while it cannot be read, of its last text that could."""
        file = self._server.workspace.get_text_document(uri)
        with suppress(LoadError):
            document = parse_document(file.source, file.path)
            positions = Positions(document.text, self._server.workspace.position_codec)
            self._outlined[uri] = document, positions
        known = self._outlined.get(uri)
        return of(*known) if known else []


def _may_be_file(uri: str) -> bool:
    """Return whether a document can be a file, and is no older version of one, as in ``git:``."""
    return "\0" not in (to_fs_path(uri) or "\0")
