"""Reads what a page of the documentation tells its reader to do: its files, its commands."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

ORDER = re.compile(
    r"([Ii]n|New file|[Ss]ave this as|At the end of)\s`([^`]+)`"
    r"(?:, (before|after|instead of|replace the line|insert below the line)"
    r"(?: that begins with)? (`+) ?(.+?)\4(?: with)?)?:\n"
)
"""The end of the paragraph before a block of code: where the block goes."""

BELOW = {"after", "insert below the line"}
ABOVE = {"before"}

BLOCK = re.compile(r"^( *)```(\w+)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


class Edit(NamedTuple):
    """A block that is a file, or goes into one at the one line that begins with the anchor."""

    file: str
    how: str
    anchor: str
    text: str


class Command(NamedTuple):
    """A command, the code that it exits with, and what the page shows of what it prints."""

    line: str
    exits: int
    prints: list[str]


def steps(text: str) -> list[Edit | Command]:
    """Return what the text tells its reader to do, in order.

    A block of the kind `sh` has commands alone, `text` lines that the last command prints, and
    `console` commands after `$`, each above all that it prints. Every other block is an edit.
    """
    found: list[Edit | Command] = []
    end = 0
    for block in BLOCK.finditer(text):
        order = next(ORDER.finditer(text, end, block.start()), None)
        indent, kind, code = block.groups()
        code = re.sub(rf"^{indent}", "", code, flags=re.MULTILINE)
        if kind == "sh":
            found += [_command(line) for line in code.splitlines()]
        elif kind == "text":
            _prints(found).extend(code.splitlines())
        elif kind == "console":
            for line in code.splitlines():
                if line.startswith("$ "):
                    found.append(_command(line[2:]))
                else:
                    _prints(found).append(line)
        else:
            assert order is not None, f"no line says where this goes:\n{code}"
            where, file, how, _, anchor = order.groups()
            found.append(Edit(file, how or where, anchor or "", code))
        end = block.end()
    return found


def _command(text: str) -> Command:
    line, _, exits = text.partition(" # exit ")
    return Command(line.strip(), int(exits or 0), [])


def _prints(found: list[Edit | Command]) -> list[str]:
    last = found[-1]
    assert isinstance(last, Command), f"no command before this output: {last}"
    return last.prints


def apply(edit: Edit, folder: Path) -> None:
    """Write the block where its sentence says."""
    file = folder / edit.file
    if edit.how.lower() == "save this as":
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(edit.text, encoding="utf-8")
        return
    if edit.how in ("New file", "At the end of"):
        assert file.exists() == (edit.how != "New file"), edit.file
        before = file.read_text("utf-8") if file.exists() else ""
        file.write_text(before + edit.text, encoding="utf-8")
        return
    lines = file.read_text("utf-8").splitlines(keepends=True)
    found = [at for at, line in enumerate(lines) if line.strip().startswith(edit.anchor)]
    assert len(found) == 1, f"{edit.file}: {len(found)} lines begin with `{edit.anchor}`"
    first = found[0] + (edit.how in BELOW)
    lines[first : found[0] + (edit.how not in ABOVE)] = [edit.text]
    file.write_text("".join(lines), encoding="utf-8")
