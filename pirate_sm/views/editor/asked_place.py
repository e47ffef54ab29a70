"""The place in a file that an editor asks about, and the word there."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path
from pygls.workspace import PositionCodec

from pirate_sm.core.errors import PirateError
from pirate_sm.core.loading import UNFINISHED, load_mission, references
from pirate_sm.core.on_disk import unsaved
from pirate_sm.views.editor.completions import gap
from pirate_sm.views.editor.known_mission import KnownMission, marked
from pirate_sm.views.editor.names import NameAt
from pirate_sm.views.editor.positions import Positions
from pirate_sm.views.editor.shown_findings import text_on_disk


@dataclass
class AskedPlace:
    """A question about a position in a file, with all that it takes to answer it in a thread.

    Attributes:
        path: The path of the file.
        texts: The texts of the open files by their paths.
        uris: How the editor calls them.
    """

    path: str
    position: types.Position
    texts: Mapping[str, str]
    uris: Mapping[str, str]
    codec: PositionCodec

    def __post_init__(self) -> None:
        """Find the word."""
        text = self.text_of(self.path)
        self.start, end = gap(text, Positions(text, self.codec).index_of(self.position))
        self.word = text[self.start : end]

    @property
    def spot(self) -> NameAt:
        """Return where the word begins."""
        return NameAt(self.path, self.start)

    def mission(self, text: str) -> KnownMission | None:
        """Return the mission of another text of the file, with all that it lacks; None if none."""
        texts = {each: content_of(it) for each, it in {**self.texts, self.path: text}.items()}
        with unsaved(texts), suppress(PirateError), references.kept_inside(wanted=True):
            return KnownMission(load_mission(Path(self.path), tolerated=UNFINISHED))
        return None

    def marked_mission(self) -> KnownMission | None:
        """Return the mission with a mark at the place: as a step if one may be there."""
        text = self.text_of(self.path)
        texts = marked(text, self.start, self.start + len(self.word))
        return next(filter(None, map(self.mission, texts)), None)

    def text_of(self, path: str, texts: Mapping[str, str] | None = None) -> str:
        """Return the text of a file; an empty one if it cannot be read."""
        known = (texts or self.texts).get(path)
        return text_on_disk(path) if known is None else known

    def range(self, at: NameAt, word: str) -> types.Range:
        """Return the range of a word at a place."""
        positions = Positions(self.text_of(at.path), self.codec)
        return positions.between(at.start, at.start + len(word))

    def location(self, at: NameAt, word: str) -> types.Location:
        """Return a word's range with its file."""
        return types.Location(self.uri(at.path), self.range(at, word))

    def uri(self, path: str) -> str:
        """Return how the editor calls a file."""
        return self.uris.get(path) or str(from_fs_path(path))


def content_of(text: str) -> bytes:
    """Return a text as a file holds it; an editor may send what no file can hold."""
    return text.encode(errors="surrogatepass")
