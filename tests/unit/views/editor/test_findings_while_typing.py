"""An editor shows what `pirate check` says, at the same places, of texts that no file holds yet."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import chdir
from pathlib import Path
from typing import Any

import pytest

from benchmarks.mistakes import FILES, ODD, cases, written
from pirate_sm.checking.reports.check_report import end_column
from pirate_sm.core.documents import FileKind, kind_of_text
from tests.mistakes.test_mistakes import SAMPLE, mistake
from tests.representative import thorough_but

from .client import Client, Json, checks_as_the_command, served

ROOT = Path(__file__).resolve().parents[4]
FOLDERS = (
    "sequences",
    "hardware_profiles",
    "cameras",
    "panels",
    "campaigns",
    "demos",
    "docs",
    "tests/robots",
)
SHIPPED = [
    file.relative_to(ROOT).as_posix()
    for folder in FOLDERS
    for file in sorted((ROOT / folder).rglob("*.yaml"))
]
FEW = (
    "sequences/mitre_bend.yaml",
    "sequences/pipes/house.yaml",
    "hardware_profiles/pirate_ii/chart.yaml",
    "panels/nanokontrol2.yaml",
)
Found = tuple[Path, str, int, str, tuple[int, int], int, tuple[tuple[Path, int, str], ...]]


def said_by_the_check(path: Path) -> list[Found]:
    """What the check says of a file, in the form below; nothing of a file of no known kind."""
    if kind_of_text(path.read_text("utf-8", errors="replace")) is FileKind.OTHER:
        return []
    return sorted(
        (
            Path(each.place.file).resolve(),
            each.code,
            4 - each.severity,
            each.message,
            (max(each.place.line - 1, 0), max(each.place.column - 1, 0)),
            end_column(each) - 1 if each.place.line else 0,
            (
                *(
                    (Path(at.file).resolve(), max(at.line - 1, 0), what)
                    for at, what in each.related
                ),
                *(
                    (Path(each.place.file).resolve(), max(each.place.line - 1, 0), f"{n}. {what}")
                    for n, what in enumerate(each.story, 1)
                ),
            ),
        )
        for each in checks_as_the_command([str(path)]).open
    )


def shown_by(client: Client) -> list[Found]:
    """What an editor shows, with every place counted from 0."""

    def related(each: Json) -> Iterator[tuple[Path, int, str]]:
        for about in each["relatedInformation"]:
            place = about["location"]
            path = Path(place["uri"].removeprefix("file://")).resolve()
            yield path, place["range"]["start"]["line"], about["message"]

    return sorted(
        (
            path.resolve(),
            each["code"],
            each["severity"],
            each["message"].partition("\nwhy: ")[0].partition("\nfix: ")[0],
            (each["range"]["start"]["line"], each["range"]["start"]["character"]),
            each["range"]["end"]["character"],
            tuple(related(each)),
        )
        for path, found in client.shown.items()
        for each in found
    )


def compare(client: Client, path: Path, *, unsaved: bool) -> None:
    """Check a file and let an editor show it, perhaps one whose file is not there."""
    text = path.read_bytes().decode().removeprefix("\ufeff")
    due = said_by_the_check(path)
    if unsaved:
        path.unlink()

    client.write(path, text)

    assert shown_by(client) == due, path
    client.close(path)


@pytest.mark.parametrize("name", thorough_but(FEW, SHIPPED))
def test_a_shipped_file(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    with served() as client:
        client.begin(ROOT)

        compare(client, ROOT / name, unsaved=False)


def compare_mistakes(names: Collection[Any], folder: Path) -> None:
    with chdir(folder), served() as client:
        client.begin(folder)
        for number, case in enumerate(names):
            inner = folder / str(number)
            inner.mkdir()
            with chdir(inner):
                written(case)
            path = inner / case.path
            try:
                path.read_bytes().decode()
            except UnicodeDecodeError:
                continue  # no editor has it as a text
            if path.suffix in (".yaml", ".yml"):
                compare(client, path, unsaved=path.name != "profile.yaml")


def test_mistakes_in_files_that_are_not_there(tmp_path: Path) -> None:
    compare_mistakes([*map(mistake, SAMPLE)], tmp_path)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("file", [*FILES, ODD])
def test_all_mistakes(file: str, tmp_path: Path) -> None:
    compare_mistakes([*cases([file])], tmp_path)
