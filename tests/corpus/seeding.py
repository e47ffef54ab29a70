"""Reads the corpus: clean files, and for each case the one fault that is put into them.

A case of ``cases/*.yaml`` has these keys:

- ``it``: What its author did, in a few words; its name in the test run.
- ``base``: A folder of ``bases``, or ``pirate_ii`` or ``newt``, that robot; its files are copied.
  Without one the case brings all of its files itself. The base of the file holds unless said.
- ``in``: The file of the base that ``change`` is about; of a mission's or pipe's folder the first.
- ``change``: Texts of that file and what stands in their place.
- ``also``: The same for further files by name, where one fault needs a change in two places.
- ``beside``: The robot whose files stand beside, in a folder of its name.
- ``files``: Further files by name, or whole ones instead of those of the base.
- ``check``: What is given to the check; else the folder that holds it all.
- ``severity``: Where it is another one than the code usually has.
- ``finds``: ``CODE at FILE``, or ``CODE at FILE:LINE``, where no comment can mark the line.

The fault stands on the line that ends in ``# fault: CODE``.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
ROBOTS = {
    "pirate_ii": ROOT / "hardware_profiles" / "pirate_ii",
    "newt": ROOT / "tests" / "robots" / "newt",
}
NEEDED = ("profile.yaml", "chart.yaml", "messages")
KEYS = {"it", "base", "in", "change", "files", "check", "finds", "also", "beside", "severity"}
MARK = re.compile(r"# fault: ([a-z_.-]+)$", re.MULTILINE)


@dataclass(frozen=True)
class Case:
    """One fault in otherwise clean files.

    Attributes:
        check: Paths that are given to the check.
        finds: Code, file and line where no comment can mark it; empty otherwise.
    """

    name: str
    base: str = ""
    file: str = ""
    change: Mapping[str, str] = field(default_factory=dict)
    also: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    beside: str = ""
    severity: str = ""
    check: Sequence[str] = (".",)
    finds: str = ""

    @property
    def seeds(self) -> str:
        """The code of the fault."""
        if self.finds:
            return _place(self.finds)[0]
        texts = (*self.change.values(), *self.files.values())
        return next(mark[1] for text in texts for mark in MARK.finditer(text))

    def write(self, folder: Path) -> set[tuple[str, str, int]]:
        """Everything that the case is about lies in the folder; what must be found is returned."""
        names = copied(self.base, folder)
        for name, text in self.files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")
        if self.change:
            put(folder / (self.file or names[0]), self.change)
        for name, change in self.also.items():
            put(folder / name, change)
        if self.beside:
            (folder / self.beside).mkdir()
            copied(self.beside, folder / self.beside)
        return {_place(self.finds)} if self.finds else set(_marks(folder))


def copied(base: str, folder: Path) -> list[str]:
    """The files of a base lie in the folder; the first of them is what most changes are about."""
    if not base:
        return []
    if base in ROBOTS:
        for name in NEEDED:
            source = ROBOTS[base] / name
            copy = shutil.copytree if source.is_dir() else shutil.copy
            copy(source, folder / name)
        return list(NEEDED[:2])
    shutil.copytree(HERE / "bases" / base, folder, dirs_exist_ok=True)
    return sorted(path.name for path in (HERE / "bases" / base).iterdir())


def put(file: Path, change: Mapping[str, str]) -> None:
    """Each text has been replaced where it stands first."""
    text = file.read_text(encoding="utf-8")
    for old, new in change.items():
        assert old in text, f"not in {file.name}: {old}"
        text = text.replace(old, new, 1)
    file.write_text(text, encoding="utf-8")


def _place(text: str) -> tuple[str, str, int]:
    code, _, place = text.partition(" at ")
    file, _, line = place.partition(":")
    return code, file, int(line or 0)


def _marks(folder: Path) -> Iterator[tuple[str, str, int]]:
    for file in sorted(folder.rglob("*.yaml")):
        text = file.read_text(encoding="utf-8")
        for mark in MARK.finditer(text):
            line = text.count("\n", 0, mark.start()) + 1
            yield mark[1], str(file.relative_to(folder)), line


def cases() -> list[Case]:
    """Every case of the corpus."""
    return [case for file in sorted((HERE / "cases").glob("*.yaml")) for case in _cases(file)]


def _cases(file: Path) -> Iterator[Case]:
    content: dict[str, Any] = yaml.load(
        file.read_text(encoding="utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    )
    usual = {key: content[key] for key in ("base", "in") if key in content}
    for given in content["cases"]:
        other = given.get("base", "") not in {"", *ROBOTS}
        said = given if other else {**usual, **given}
        assert said.keys() <= KEYS, f"{file.name}: {said.keys() - KEYS}"
        yield Case(
            name=f"{file.stem}: {said['it']}",
            base=said.get("base", ""),
            file=said.get("in", ""),
            change=said.get("change", {}),
            also=said.get("also", {}),
            files=said.get("files", {}),
            beside=said.get("beside", ""),
            severity=said.get("severity", ""),
            check=said.get("check", (".",)),
            finds=said.get("finds", ""),
        )
