"""Reports what is wrong with files that another file names; quotes them only if they are ours."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path as FilePath

from pirate_sm.loading.problems import LoadError, Path, Problems
from pirate_sm.loading.source import LARGEST_FILE

MISSION = ("mission", "phases")
PIPE = ("pipe", "diameter", "segments")
"""Keys of which a file of ours has one, however broken it is."""


def tell(
    error: LoadError, file: FilePath, keys: tuple[str, ...], at: Path, problems: Problems
) -> None:
    """What is wrong with a file has been added; of a stranger only that it is one.

    A reference may lead anywhere, and messages quote what they are about: into the log of a build
    server, say.

    Args:
        error: What reading the file has raised.
        file: The file.
        keys: One of these it has, if it is of the kind that is meant.
        at: Where it is named, in the file that the problems are about.
        problems: Are added to.
    """
    if _has(file, keys):
        for problem in error.problems:
            problems.put(problem)
        return
    code = "mission.pipe" if keys is PIPE else "mission.call"
    problems.add(code, at, f"this leads to a file that is no {keys[0]}")


def _has(file: FilePath, keys: tuple[str, ...]) -> bool:
    """Whether one of the keys stands at the beginning of a line, or the file cannot be read."""
    with suppress(OSError, ValueError):
        with file.open("rb") as stream:
            text = stream.read(LARGEST_FILE).decode("utf-8-sig", errors="replace")
        names = "|".join(keys)
        return (
            not text.strip()
            or re.search(rf"""^[\s{{]*["']?(?:{names})["']?\s*:""", text, re.MULTILINE) is not None
        )
    return True
