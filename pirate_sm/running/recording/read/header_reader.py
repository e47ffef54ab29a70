"""Reads the header of a recording: the set-up of the run and its texts."""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path

from mcap.records import Attachment

from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import ALPHABET_VERSION, READABLE_ALPHABETS
from pirate_sm.core.files import shown
from pirate_sm.running.recording.format.header import (
    FORMAT,
    READABLE_FORMATS,
    RUN,
    RunHeader,
    header_from_json,
)
from pirate_sm.running.recording.read.mcap_content import Content


def read_header(path: Path, content: Content) -> RunHeader:
    """Return the header of the recording, with every text.

    Raises:
        RecordingError: The header is damaged, missing or of another version.
    """
    attached = content.attachments
    if RUN not in attached:
        raise _lacking(path, content, f"{RUN} is missing")
    data = attached[RUN].data
    _check_versions(path, data)
    try:
        header = header_from_json(data, _texts(attached))
    except KeyError:
        raise _lacking(path, content, "a text that the run was made from is missing") from None
    except ValueError:
        raise damaged(path, f"{RUN} has unexpected content") from None
    for file in header.files:
        if sha256(file.text.encode()).hexdigest() != file.sha256:
            raise damaged(path, f"{file.name} is not the text that was run")
    return header


def _lacking(path: Path, content: Content, what: str) -> RecordingError:
    """Return the error for a part of the header that is not there: damaged, or not yet written."""
    if content.damage:
        return damaged(path, content.damage)
    if content.complete or content.pieces:
        return damaged(path, what)
    return RecordingError(f"{shown(path)} was interrupted before anything was recorded")


def _texts(attached: dict[str, Attachment]) -> dict[str, str]:
    return {name: each.data.decode(errors="replace") for name, each in attached.items()}


def _check_versions(path: Path, data: bytes) -> None:
    try:
        plain = json.loads(data)
        found = plain["format"], plain["alphabet"]
        version = str(plain["version"])
    except (ValueError, KeyError, TypeError):
        raise damaged(path, f"{RUN} has unexpected content") from None
    if found[0] not in READABLE_FORMATS or found[1] not in READABLE_ALPHABETS:
        raise RecordingError(
            f"{shown(path)} was recorded by version {version} "
            f"(format {found[0]}, alphabet {found[1]}), "
            f"which this version cannot read (format {FORMAT}, alphabet {ALPHABET_VERSION})"
        )


def damaged(path: Path, how: str) -> RecordingError:
    """Return the error for a damaged recording."""
    return RecordingError(f"{shown(path)} is damaged: {how}")


class DamagedInsideError(RecordingError):
    """Is raised if the beginning of a recording is usable, but not all that follows.

    Attributes:
        how: Description of the damage.
    """

    def __init__(self, path: Path, how: str) -> None:
        super().__init__(f"{shown(path)} is damaged: {how}; pirate repair saves what is whole")
        self.how = how
