"""Reads the files of settings, and finds all their faults with their places."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection
from pathlib import Path
from typing import Any

from pirate_sm.checking.permissions import is_below
from pirate_sm.cli.settings import SETTINGS, SettingValue, expanded
from pirate_sm.core.documents import LoadError, Place, Problem, read_text
from pirate_sm.core.library import is_path, shown
from pirate_sm.core.on_disk import is_there
from pirate_sm.core.spelling import nearest, one_of

_AT = re.compile(r" \(at (?:line (\d+), column (\d+)|end of document)\)$")
_QUOTES = ('"', "'")
_UNCLOSED = 'this text is not closed: end it with a quote, as in runs = "recordings"'
_LINE = 'expected one setting in each line, such as runs = "recordings"'
_PLAIN = {
    "Illegal character '\\n'": _UNCLOSED,
    "Unterminated string": _UNCLOSED,
    'Expected "\'"': _UNCLOSED,
    "Cannot overwrite a value": "this is set twice: leave one of the two lines out",
    "Cannot declare": "this is set twice: leave one of the two out",
    "Invalid value": 'expected a value here, such as a text in quotes, "recordings"',
    "Expected newline": _LINE,
    "Expected '='": _LINE,
    "Invalid statement": _LINE,
}
"""What messages of the reader of TOML mean, by their beginnings; others are shown as they are."""


def read_settings(
    user: Path, project: Path | None
) -> tuple[dict[str, SettingValue], dict[str, SettingValue]]:
    """Return the settings of the user's file and of the project's.

    Raises:
        LoadError: A file has faults; it lists those of both.
    """
    problems: list[Problem] = []
    of_user = _read(user, problems, is_project=False) if is_there(user) else {}
    of_project = _read(project, problems, is_project=True) if project is not None else {}
    if problems:
        raise LoadError(problems)
    return of_user, of_project


def _read(path: Path, problems: list[Problem], *, is_project: bool) -> dict[str, SettingValue]:
    name = shown(path)
    if is_project and not is_below(path, path.parent):
        message = "this link leads out of the project's folder, so nothing of its file is read"
        problems.append(Problem("settings.outside", Place(str(path)), message))
        return {}
    try:
        text = read_text(path, name, "a TOML file")
    except LoadError as error:
        problems += error.problems
        return {}
    lines = ["", *text.splitlines()]
    try:
        content = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        line, column, message = _syntax(str(error), text)
        excerpt = lines[line] if line < len(lines) else ""
        place = Place(name, line, column)
        problems.append(Problem("settings.syntax", place, message, excerpt=excerpt))
        return {}
    values = {}
    for key, value in content.items():
        line, at_key, at_value = _place_of(text, key)
        fault = _fault(key, value, is_project=is_project)
        if fault is not None:
            problems.append(
                Problem(
                    place=Place(name, line, at_key if fault.pop("at_key") else at_value),
                    excerpt=lines[line],
                    **fault,
                )
            )
        else:
            values[key] = SettingValue(
                _placed(key, value, path.parent, is_project=is_project),
                f"{name}:{line}" if line else name,
                place=Place(name, line, at_value),
                excerpt=lines[line],
            )
    return values


def _syntax(said: str, text: str) -> tuple[int, int, str]:
    """Return line, column and the message of a fault that the reader of TOML has found."""
    found = _AT.search(said)
    message = _AT.sub("", said)
    known = next((plain for start, plain in _PLAIN.items() if message.startswith(start)), None)
    position = len(text.rstrip()) if found is None or not found[1] else None
    if known is _UNCLOSED:
        end = position
        if found is not None and found[1]:
            end = sum(map(len, text.splitlines(keepends=True)[: int(found[1])]))
        position = max(text.rfind(quote, 0, end) for quote in _QUOTES)
    if position is not None:
        before = text[: max(position, 0)]
        return before.count("\n") + 1, len(before) - before.rfind("\n"), known or message
    assert found is not None
    return int(found[1]), int(found[2]), known or message


def _fault(key: str, value: Any, *, is_project: bool) -> dict[str, Any] | None:
    """Return what is wrong with a setting as a part of a problem; None if it is right."""
    known = [name for name, each in SETTINGS.items() if not (is_project and each.only_user)]
    if key not in known:
        if key in SETTINGS:
            message = f"only the user's own file sets '{key}'"
            return {"code": "settings.forbidden", "message": message, "at_key": True}
        return _unknown("setting", key, known, "settings.unknown-key", at_key=True)
    if key == "trusted":
        if isinstance(value, list) and all(isinstance(each, str) and each for each in value):
            return None
        return _of_type("a list of folders", value)
    if not isinstance(value, str) or "\0" in value or (not value and key != "runs"):
        return _of_type("a text in quotes", value)
    names = SETTINGS[key].names
    if names is not None and value not in (valid := names()):
        return _unknown(key, value, valid, "settings.unknown-value", at_key=False)
    return None


def _unknown(
    what: str, name: str, known: Collection[str], code: str, *, at_key: bool
) -> dict[str, Any]:
    close = nearest(name, known)
    return {
        "code": code,
        "message": f"there is no {what} '{name}'",
        "suggestion": close or "",
        "expected": "" if close else one_of(known),
        "at_key": at_key,
    }


def _of_type(expected: str, value: Any) -> dict[str, Any]:
    message = f"the value is {_written(value)}"
    return {"code": "settings.type", "message": message, "expected": expected, "at_key": False}


def _written(value: Any) -> str:
    """Return a value as TOML has it, or what kind of value it is."""
    if isinstance(value, dict | list):
        return "a table" if isinstance(value, dict) else "a list"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else str(value)


def _placed(key: str, value: Any, folder: Path, *, is_project: bool) -> Any:
    """Return the value; a path in a project's file begins at the folder of that file."""
    if key == "trusted":
        return tuple(value)
    path = key == "runs" or (key == "robot" and is_path(value))
    value = expanded(value) if path else value
    return str(folder / value) if is_project and value and path else value


def _place_of(text: str, name: str) -> tuple[int, int, int]:
    """Return line, column and the column of the value of a key or table in a TOML text."""
    pattern = rf"""^\s*\[*\s*["']?({re.escape(name)})["']?\s*([.=\]]\s*)"""
    for number, line in enumerate(text.splitlines(), 1):
        if match := re.match(pattern, line):
            return number, match.start(1) + 1, match.end(2) + 1
    return 0, 0, 0
