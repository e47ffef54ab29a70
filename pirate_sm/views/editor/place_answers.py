"""Answers about a place in a file: what may be written there, what it means, where it is named.

Each is found in a thread, on the texts as they are when it is asked.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.lsp.server import LanguageServer

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.project_files import find_targets
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.core.documents import FileKind, LoadError, Problem, kind_of_text
from pirate_sm.core.errors import PirateError
from pirate_sm.core.loading import TOLERABLE, load_mission, references
from pirate_sm.core.on_disk import noting, unsaved
from pirate_sm.core.spelling import compared_with
from pirate_sm.views.editor import hover
from pirate_sm.views.editor.asked_place import AskedPlace, content_of
from pirate_sm.views.editor.completion_items import items
from pirate_sm.views.editor.completions import offers, opening
from pirate_sm.views.editor.editor_wishes import EditorWishes
from pirate_sm.views.editor.known_mission import KnownMission, may_be_mission
from pirate_sm.views.editor.names import FileSaid, NameAt, Names


class PlaceAnswers:
    """Answers an editor that asks about a place.

    Args:
        server: The server.
        opened: Returns the open files by their paths.
        check: Checks files.
        wishes: What the editor can do.
        checked: Returns the mission at a path as it was checked last.
    """

    def __init__(
        self,
        server: LanguageServer,
        opened: Callable[[], Mapping[str, Any]],
        check: Callable[[list[str]], CheckReport],
        wishes: EditorWishes,
        checked: Callable[[str], KnownMission | None],
    ) -> None:
        self._server, self._open, self._check = server, opened, check
        self._wishes, self._checked = wishes, checked
        begins = types.CompletionOptions(trigger_characters=[" ", "$"])
        server.feature(types.TEXT_DOCUMENT_COMPLETION, begins)(partial(self._completions))
        server.feature(types.TEXT_DOCUMENT_HOVER)(partial(self._hover))
        server.feature(types.TEXT_DOCUMENT_DEFINITION)(partial(self._definition))
        server.feature(types.TEXT_DOCUMENT_REFERENCES)(partial(self._references))
        server.feature(types.TEXT_DOCUMENT_RENAME)(partial(self._rename))

    async def _completions(self, asked: types.CompletionParams) -> list[types.CompletionItem]:
        """Return the words that are possible at a place; loading is asked in a thread."""
        question = self._question(asked)
        is_mission = may_be_mission(question.text_of(question.path))

        def compared(changed: str, word: str) -> list[str]:
            with compared_with(word) as names:
                if is_mission:
                    question.mission(changed)
                else:
                    self._loaded(question, {question.path: changed}, question.path)
            return [*names]

        def work() -> list[types.CompletionItem]:
            text, start = question.text_of(question.path), question.start
            end, place = start + len(question.word), question.range(question.spot, question.word)
            known = question.marked_mission() if is_mission else None
            words = offers(text, start, end, compared)
            return [
                *items(words, place, known, fills=self._wishes.fills, opening=opening(text, start))
            ]

        return await asyncio.to_thread(work)

    async def _hover(self, asked: types.HoverParams) -> types.Hover | None:
        """Return what is known of a word of a mission."""
        question = self._question(asked)

        def work() -> types.Hover | None:
            text = question.text_of(question.path)
            known = self._checked(question.path)
            known = known or (question.mission(text) if may_be_mission(text) else None)
            line = asked.position.line + 1 if known and known.text == text else 0
            said = hover.about(known, question.word, line) if known and question.word else ""
            content = types.MarkupContent(types.MarkupKind.Markdown, said)
            place = question.range(question.spot, question.word)
            return types.Hover(content, place) if said else None

        return await asyncio.to_thread(work)

    async def _definition(self, asked: types.DefinitionParams) -> types.Location | None:
        question = self._question(asked)

        def work() -> types.Location | None:
            names, at, word = self._names(question), question.spot, question.word
            if not word:
                return None
            found = names.declaration(at, word)
            if found is None and (file := names.file(at, word)) is not None:
                return question.location(NameAt(file, 0), "")
            found = found or names.key(at, word)
            return question.location(found, word) if found else None

        return await asyncio.to_thread(work)

    async def _references(self, asked: types.ReferenceParams) -> list[types.Location]:
        question = self._question(asked)

        def work() -> list[types.Location]:
            spots = self._spots(question, self._names(question))
            spots = spots if asked.context.include_declaration else spots[1:]
            return [question.location(each, question.word) for each in spots]

        return await asyncio.to_thread(work)

    async def _rename(self, asked: types.RenameParams) -> types.WorkspaceEdit | None:
        """Return the change that gives a name another spelling; None if it would be refused."""
        question = self._question(asked)

        def work() -> types.WorkspaceEdit | None:
            names, word = self._names(question), question.word
            spots = self._spots(question, names)
            if not spots or not names.renamed(spots, word, asked.new_name):
                return None
            edits: dict[str, list[types.TextEdit]] = {}
            for each in spots:
                edit = types.TextEdit(question.range(each, word), asked.new_name)
                edits.setdefault(question.uri(each.path), []).append(edit)
            return types.WorkspaceEdit(changes=edits)

        return await asyncio.to_thread(work)

    def _question(self, asked: Any) -> AskedPlace:
        """Return a question about a position, with the texts as they are now."""
        files = self._open()
        file = self._server.workspace.get_text_document(asked.text_document.uri)
        texts = {path: each.source for path, each in files.items()}
        uris = {path: each.uri for path, each in files.items()}
        codec = self._server.workspace.position_codec
        return AskedPlace(os.path.realpath(file.path), asked.position, texts, uris, codec)

    def _names(self, question: AskedPlace) -> Names:
        return Names(partial(self._loaded, question), question.text_of)

    def _spots(self, question: AskedPlace, names: Names) -> list[NameAt]:
        """Return where a name is declared, and all its uses in open missions and in the project."""
        declared = question.word and names.declaration(question.spot, question.word)
        if not declared:
            return []
        targets = find_targets(()).targets
        missions = (each.path for each in targets if each.kind is FileKind.MISSION)
        others = dict.fromkeys([*question.texts, *map(os.path.realpath, missions)])
        others.pop(question.path)
        return [declared, *names.uses(declared, question.word, others)]

    def _loaded(self, question: AskedPlace, changed: Mapping[str, str], path: str) -> FileSaid:
        """Load a file with changed texts; a mission without exploring it."""
        texts = {**question.texts, **changed}
        errors: Iterable[Finding | Problem] = ()
        with unsaved({each: content_of(text) for each, text in texts.items()}), noting() as asked:
            if kind_of_text(question.text_of(path, texts)) is FileKind.MISSION:
                try:
                    with references.kept_inside(wanted=True):
                        errors = load_mission(Path(path), tolerated=TOLERABLE).problems
                except LoadError as error:
                    errors = error.problems
                except PirateError:
                    pass
            else:
                errors = self._check([path]).open
        wrong = (each for each in errors if each.severity is Severity.ERROR)
        read = map(os.path.realpath, asked.contents)
        found = frozenset((each.place, each.message) for each in wrong)
        return FileSaid(found, tuple(dict.fromkeys(read)))
