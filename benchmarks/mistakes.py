"""How many mistakes of `tests/mistakes` the check reports on their line: `make mistakes`.

The files there were written from the documentation alone. A group of cases has a `base`, a file of
`bases` or one of a new robot (`robot:profile.yaml`), and each case is one edit of it: `replace` and
`with`, and perhaps a second one under `and`. `robot: true` adds the files of the new robot. A
mistake is due on the line that holds `at` (a text, or several that are equally right; `which`
counts its occurrences), by default the first line of the edit. An error or a warning on one of
these lines counts. In `odd.yaml` any is a false alarm.
"""

from __future__ import annotations

import argparse
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import yaml

from pirate_sm.cli.commands.check import run_check
from pirate_sm.cli.commands.new import write_robot
from pirate_sm.cli.options.checks import CheckOptions
from pirate_sm.cli.options.files import NewRobotOptions
from pirate_sm.cli.settings import RUNS_VARIABLE
from pirate_sm.core.errors import PirateError

HERE = Path(__file__).parents[1] / "tests" / "mistakes"
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # that in Python takes ten times as long
FILES = ("missions", "robots", "pipes", "projects", "second")
ODD = "odd"
SOUGHT = 0.94
"""The least share of the mistakes that is reported on its line (issue 36)."""


@dataclass(frozen=True)
class Mistake:
    """One file with one mistake, or an odd one without.

    Attributes:
        kind: The file of cases and the group, `missions.syntax`.
        path: The file that the edit is in, relative to the folder that is checked.
        files: All files by their paths, as bytes.
        lines: The lines of ``path`` on which a finding is right; none in an odd file.
    """

    kind: str
    name: str
    path: str
    files: Mapping[str, bytes]
    lines: frozenset[int]
    why: str


@dataclass(frozen=True)
class CheckedCase:
    """What the check says of a case: errors and warnings as (file, line, text)."""

    case: Mistake
    found: Sequence[tuple[str, int, str]]

    @property
    def on_line(self) -> bool:
        """Return whether one of them is where the mistake is."""
        case = self.case
        return any(file == case.path and line in case.lines for file, line, _ in self.found)

    def __str__(self) -> str:
        """Return the case and what is said of it."""
        head = f"{self.case.kind}.{self.case.name}: {self.case.why}".rstrip(": ")
        said = (f"    {file}:{line}: {text}" for file, line, text in self.found)
        return "\n".join((head, *said))

    @property
    def answer(self) -> str:
        """Return how well the mistake is reported: `on its line`, `elsewhere` or `missed`."""
        return "on its line" if self.on_line else "elsewhere" if self.found else "missed"


def cases(which: Sequence[str] = FILES) -> Iterator[Mistake]:
    """Read the cases of these files of `tests/mistakes`."""
    for file in which:
        groups = yaml.load((HERE / f"{file}.yaml").read_text("utf-8"), Loader=_LOADER)
        for group, content in groups.items():
            for name, edit in content["cases"].items():
                yield _case(f"{file}.{group}", name, content, edit)


def checked(case: Mistake) -> CheckedCase:
    """Write the files of a case into a folder of their own and check it."""
    with TemporaryDirectory() as folder, chdir(folder):
        written(case)
        return CheckedCase(case, list(_findings(case)))


def written(case: Mistake) -> None:
    """Write the files of a case into the working directory."""
    for path, content in case.files.items():
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_bytes(content)


def _findings(case: Mistake) -> Iterator[tuple[str, int, str]]:
    whole = "." if "profile.yaml" in case.files or case.path == "pirate.toml" else case.path
    out = StringIO()
    try:
        with redirect_stdout(out), redirect_stderr(StringIO()), patch.dict(os.environ):
            os.environ.pop(RUNS_VARIABLE, None)  # it takes the place of the project's setting
            run_check(CheckOptions(paths=[whole], format="json"))
    except PirateError as error:
        for match in re.finditer(r"^ *(\S+?):(\d+):(?:\d+:)? (.*)", str(error), re.MULTILINE):
            yield os.path.relpath(match[1]), int(match[2]), match[3]
        return
    for each in json.loads(out.getvalue())["findings"]:
        if each["severity"] in ("error", "warning") and not each.get("allowed"):
            yield os.path.relpath(each["file"]), each["line"], f"[{each['code']}] {each['message']}"


def _case(kind: str, name: str, group: Mapping[str, Any], edit: Mapping[str, Any]) -> Mistake:
    files, path = _base(group["base"])
    path = group.get("path", path)
    text = files.pop(next(iter(files)))
    changed = _edited(text, edit, f"{kind}.{name}")
    lines = frozenset() if kind.startswith(ODD) else _lines(text, changed, edit)
    if edit.get("crlf"):
        changed = changed.replace("\n", "\r\n")
    if group.get("robot"):
        files |= _new_robot()
    names = group.get("with_files", ())
    beside = {each: (HERE / "bases" / each).read_text("utf-8") for each in names}
    texts = {path: changed, **files, **beside}
    encoded = {each: content.encode() for each, content in texts.items()}
    if edit.get("bom"):
        encoded[path] = b"\xef\xbb\xbf" + encoded[path]
    return Mistake(kind, name, path, encoded, lines, edit.get("why", ""))


def _base(base: str) -> tuple[dict[str, str], str]:
    """Return the files of a base, the one that is edited first, and that one's path."""
    origin, _, file = base.rpartition(":")
    if origin:
        robot = _new_robot()
        return {file: robot[file], **{each: robot[each] for each in robot if each != file}}, file
    return {base: (HERE / "bases" / base).read_text("utf-8")}, base


@cache
def _new_robot() -> Mapping[str, str]:
    """Return the files of the robot that `pirate new robot` writes."""
    with TemporaryDirectory() as folder, chdir(folder), redirect_stdout(StringIO()):
        write_robot(NewRobotOptions(name="beast"))
        written = Path("beast")
        return {
            each.relative_to(written).as_posix(): each.read_text("utf-8")
            for each in sorted(written.rglob("*.yaml"))
        }


def _edited(text: str, edit: Mapping[str, Any], name: str) -> str:
    for each in (edit, edit.get("and")):
        if each and "replace" in each:
            count = text.count(each["replace"])
            if count != 1:
                raise ValueError(f"{name}: {each['replace']!r} is {count} times in the base")
            text = text.replace(each["replace"], str(each["with"]))
    return text


def _lines(before: str, after: str, edit: Mapping[str, Any]) -> frozenset[int]:
    """Return the lines, from 1, on which a finding is right."""
    if "at" not in edit:
        return frozenset({before[: before.index(edit["replace"])].count("\n") + 1})
    found = set()
    for text in [edit["at"]] if isinstance(edit["at"], str) else edit["at"]:
        having = [n for n, line in enumerate(after.split("\n"), 1) if text in line]
        if not having:
            raise ValueError(f"no line has {text!r}")
        which = edit.get("which", 1)
        found.add(having[-1 if which == "last" else min(which, len(having)) - 1])
    return frozenset(found)


def table(outcomes: Sequence[CheckedCase]) -> str:
    """Return the shares by kind of file and mistake."""
    kinds = dict.fromkeys(each.case.kind for each in outcomes)
    rows = [f"{'kind':24} {'mistakes':>8} {'on line':>8} {'elsewhere':>9} {'missed':>7}"]
    for kind in [*kinds, "all"]:
        answers = [each.answer for each in outcomes if kind in (each.case.kind, "all")]
        on, elsewhere, missed = map(answers.count, ("on its line", "elsewhere", "missed"))
        share = f"{on / len(answers):.0%}"
        rows.append(f"{kind:24} {len(answers):8} {share:>8} {elsewhere:9} {missed:7}")
    return "\n".join(rows)


def main() -> int:
    """Check all cases and print the table; return 1 below the share or with a false alarm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--missed", action="store_true", help="list what is not on its line")
    parser.add_argument("--only", default="", help="cases whose name has this text")
    options = parser.parse_args()
    wanted = [each for each in cases() if options.only in f"{each.kind}.{each.name}"]
    outcomes = [checked(each) for each in wanted]
    odd = [checked(each) for each in cases([ODD]) if options.only in f"{each.kind}.{each.name}"]
    alarms = [each for each in odd if each.found]
    if options.missed:
        for each in outcomes:
            if not each.on_line:
                print(f"{each.answer}: {each}")
    for each in alarms:
        print(f"false alarm: {each}")
    if outcomes:
        print(table(outcomes))
    print(f"{len(alarms)} false alarms in {len(odd)} odd files")
    share = sum(each.on_line for each in outcomes) / max(len(outcomes), 1)
    return int(share < SOUGHT or bool(alarms))


if __name__ == "__main__":
    raise SystemExit(main())
