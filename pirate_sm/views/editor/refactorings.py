"""Changes of a mission that no finding asks for, or that leave a choice."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, Final

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path

from pirate_sm.checking.findings import Severity
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.core.documents import Document, FileKind, LoadError, kind_of_text, parse_document
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.loading import load_mission
from pirate_sm.core.on_disk import is_there, unsaved
from pirate_sm.views.editor.asked_place import content_of
from pirate_sm.views.editor.extracted_mission import Extracted, extracted, selected_phases
from pirate_sm.views.editor.missing_limits import missing_limits
from pirate_sm.views.editor.positions import Positions

EXTRACT: Final = "pirate_sm.extract"


class Refactorings:
    """Offers changes to an editor, and makes them.

    Args:
        server: The server.
        opened: Returns the open files by their paths.
        check: Checks files.
    """

    def __init__(
        self,
        server: LanguageServer,
        opened: Callable[[], Mapping[str, Any]],
        check: Callable[[list[str]], CheckReport],
    ) -> None:
        self._server, self._opened, self._check = server, opened, check
        server.command(EXTRACT)(partial(self._extract))

    def actions(self, uri: str, text: str, wanted: types.Range) -> Iterator[types.CodeAction]:
        """Yield the changes for a part of a file, if that is a mission that can be read."""
        document = _mission(text, uri)
        if document is None:
            return
        positions = Positions(text, self._server.workspace.position_codec)
        for limit in missing_limits(document):
            if positions.between(limit.start, limit.end).end < wanted.start:
                continue
            if wanted.end < positions.at(limit.start):
                continue
            edit = types.TextEdit(positions.between(limit.end, limit.end), limit.text)
            made = types.WorkspaceEdit(changes={uri: [edit]})
            kind = types.CodeActionKind.QuickFix
            yield types.CodeAction("Add the missing `within`", kind, edit=made)
        names = _selected(document, positions, wanted)
        if names and wanted.start.line < wanted.end.line:
            title = f"Extract {', '.join(names)} as a mission"
            lines = [
                wanted.start.line,
                wanted.start.character,
                wanted.end.line,
                wanted.end.character,
            ]
            command = types.Command(title, EXTRACT, arguments=[uri, *lines])
            yield types.CodeAction(title, types.CodeActionKind.RefactorExtract, command=command)

    async def _extract(self, *arguments: Any) -> None:
        """Move phases into a new mission, or say why that cannot be done."""
        try:
            uri, *numbers = arguments
            first, second, third, fourth = map(int, numbers)
            wanted = types.Range(types.Position(first, second), types.Position(third, fourth))
            edit = await asyncio.to_thread(self._edit, str(uri), wanted, self._texts())
        except (ValueError, TypeError):
            return self._say("Select the phases, then choose this again")
        except PirateError as error:
            return self._say(f"These phases stay where they are: {error}")
        self._server.workspace_apply_edit(types.ApplyWorkspaceEditParams(edit))
        return None

    def _texts(self) -> dict[str, str]:
        return {path: file.source for path, file in self._opened().items()}

    def _edit(self, uri: str, wanted: types.Range, texts: Mapping[str, str]) -> types.WorkspaceEdit:
        """Return the change of the project that moves phases into a mission.

        Raises:
            PirateError: The mission has faults, or these phases cannot be moved.
        """
        path = os.path.realpath(to_fs_path(uri) or "")
        document = _mission(texts.get(path, ""), path)
        if document is None:
            raise UsageError("this is not a mission that can be read")
        positions = Positions(texts[path], self._server.workspace.position_codec)
        names = _selected(document, positions, wanted)
        if not names:
            raise UsageError("select phases first")
        before = {each: content_of(text) for each, text in texts.items()}
        with unsaved(before):
            loaded = load_mission(Path(path))
            new = _new_name(Path(path), f"{document.data['mission']}_{names[0]}")
            made = extracted(loaded, names, new.stem)
            known = {each.code for each in self._check([path]).open}
        after = {**before, path: content_of(made.caller), str(new): content_of(made.called)}
        with unsaved(after):
            found = self._check([path, str(new)]).open
        wrong = [each for each in found if each.severity > Severity.POSSIBLE]
        for each in wrong:
            if each.code not in known:
                raise UsageError(f"the check would then say of {each.place}: {each.message}")
        return self._written(uri, positions.everything, str(from_fs_path(str(new))), made)

    def _written(
        self, uri: str, whole: types.Range, new: str, made: Extracted
    ) -> types.WorkspaceEdit:
        """Return the change of two files in the form that the editor knows."""
        start = types.Position(0, 0)
        called, caller = (
            types.TextEdit(types.Range(start, start), made.called),
            types.TextEdit(whole, made.caller),
        )
        able = self._server.client_capabilities.workspace
        edits = able and able.workspace_edit
        if not (edits and types.ResourceOperationKind.Create in (edits.resource_operations or ())):
            return types.WorkspaceEdit(changes={new: [called], uri: [caller]})
        named = types.OptionalVersionedTextDocumentIdentifier
        return types.WorkspaceEdit(
            document_changes=[
                types.CreateFile(new),
                types.TextDocumentEdit(named(new), [called]),
                types.TextDocumentEdit(named(uri), [caller]),
            ]
        )

    def _say(self, text: str) -> None:
        params = types.ShowMessageParams(types.MessageType.Error, text)
        self._server.window_show_message(params)


def _mission(text: str, name: str) -> Document | None:
    """Return a mission as a document; None if it is none, or cannot be read."""
    if kind_of_text(text) is not FileKind.MISSION:
        return None
    try:
        document = parse_document(text, name)
    except LoadError:
        return None
    return document if isinstance(document.data, dict) else None


def _selected(document: Document, positions: Positions, wanted: types.Range) -> list[str]:
    return selected_phases(
        document, positions.index_of(wanted.start), positions.index_of(wanted.end)
    )


def _new_name(beside: Path, wanted: str) -> Path:
    """Return a path for a mission next to another one, at which nothing is."""
    names = (f"{wanted[:60]}{number or ''}.yaml" for number in count())
    return next(path for name in names if not is_there(path := beside.with_name(name)))
