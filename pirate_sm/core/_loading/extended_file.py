"""Read a YAML file that may extend another one: `extends: ../newt/profile.yaml`."""

from __future__ import annotations

from pathlib import Path as FilePath

from pirate_sm.core._loading import references
from pirate_sm.core._loading.problems import LoadError, Problems
from pirate_sm.core._loading.yaml.document import Document, read_document
from pirate_sm.core.errors import UsageError

KEY = "extends"
"""The key that names the file below, relative to the folder of the file above."""


def read_extended(path: FilePath) -> Document:
    """Return the document of a file, laid over the one that it extends, if it extends one.

    Mappings are merged; a list, a text or a number replaces what is below.

    Raises:
        LoadError: A file cannot be read, or the files extend each other; holds all faults.
    """
    return _read(path, ())


def extended_folders(path: FilePath) -> tuple[FilePath, ...]:
    """Return the folders of a sound file and of all files that it extends, itself first."""
    data = read_document(path).data
    given = data.get(KEY) if isinstance(data, dict) else None
    below = extended_folders(path.parent / str(given)) if given else ()
    return path.parent.resolve(), *below


def _read(path: FilePath, above: tuple[FilePath, ...]) -> Document:
    document = read_document(path)
    given = document.data.get(KEY) if isinstance(document.data, dict) else None
    if given is None:
        return document
    problems = Problems(document)
    if not isinstance(given, str) or not given:
        problems.add("robot.extends", (KEY,), "expected the path of the file that this one extends")
        problems.raise_errors()
    below, files = path.parent / str(given), (*above, path.resolve())
    if below.resolve() in files:
        problems.add("robot.extends", (KEY,), "these files extend each other")
        problems.raise_errors()
    try:
        return document.extending(_read(references.followed(below, path.parent), files), KEY)
    except UsageError as error:
        problems.add(references.code_of(error, "robot.extends"), (KEY,), str(error))
    except LoadError as error:
        problems.take(error, "robot.extends", (KEY,))
    problems.raise_errors()
    raise AssertionError("raise_errors raises here")
