"""Places of a mission's parts in its files, and findings there."""

from __future__ import annotations

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.problems import Path, Place


class Places:
    """Finds the places.

    Args:
        loaded: The mission; its own file is the first of its documents.
    """

    def __init__(self, loaded: LoadedMission) -> None:
        self._own = loaded.documents[0]
        self._documents = {document.name: document for document in loaded.documents}

    def read(self, text: str) -> Place:
        """The place that ``file:line:col`` names."""
        file, line, column = text.rsplit(":", 2)
        return Place(file, int(line), int(column))

    def of(self, path: Path, *, key: bool = False) -> Place:
        """Where a part of the mission's own file stands."""
        return self._own.place_of(path, key=key)

    def mission(self) -> Place:
        """Where the mission's name stands."""
        return self.of(("mission",))

    def finding(
        self,
        place: Place,
        code: str,
        severity: Severity,
        message: str,
        *,
        mend: str = "",
        related: tuple[tuple[Place, str], ...] = (),
        story: tuple[str, ...] = (),
    ) -> Finding:
        """A finding with the line that stands at its place."""
        document = self._documents.get(place.file)
        excerpt = document.excerpt(place.line) if document else ""
        return Finding(
            code, severity, place, message, mend=mend, excerpt=excerpt, related=related, story=story
        )
