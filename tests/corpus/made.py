"""Cases too large, too odd or too deep to be written down: made when they are needed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

from .seeding import copied

MISSION = """\
format: 1
mission: m
robot: {robot}
start: a
phases:
  a:
    do: {do}
    go: e
ends:
  e: {{succeed: Done}}
"""


class Made(NamedTuple):
    """A case that is made.

    Attributes:
        make: Puts files into a folder.
        finds: Code, file and line of what must be found.
        check: What is given to the check.
        limits: Limits of the program that are lower for this case, so that it takes no minutes.
    """

    make: Callable[[Path], None]
    finds: tuple[str, str, int]
    check: str = "."
    limits: Mapping[str, int] = {}


def _mission(do: str, robot: str = "pirate_ii") -> str:
    return MISSION.format(do=do, robot=robot)


def _written(name: str, content: str | bytes) -> Callable[[Path], None]:
    def make(folder: Path) -> None:
        data = content.encode() if isinstance(content, str) else content
        (folder / name).write_bytes(data)

    return make


def _folder_as_file(folder: Path) -> None:
    (folder / "m.yaml").write_text(_mission("[{call: ./part.yaml}]"), encoding="utf-8")
    (folder / "part.yaml").mkdir()


def _broken_link(folder: Path) -> None:
    (folder / "m.yaml").symlink_to("nowhere.yaml")


def _link_in_a_circle(folder: Path) -> None:
    (folder / "m.yaml").symlink_to("m.yaml")


def _deep_folders(folder: Path) -> None:
    deep = folder.joinpath(*["d"] * 40)
    deep.mkdir(parents=True)
    (deep / "m.yaml").write_text(_mission("[ClampFront]"), encoding="utf-8")


def _many_files(folder: Path) -> None:
    for number in range(5):
        text = _mission("[ClampFront]").replace("mission: m", f"mission: m{number}")
        (folder / f"m{number}.yaml").write_text(text, encoding="utf-8")


def _nested_calls(robot: str) -> Callable[[Path], None]:
    """Seventeen missions, each of which calls the next one."""

    def make(folder: Path) -> None:
        for number in range(17):
            do = f"[{{call: ./m{number + 1}.yaml}}]" if number < 16 else "[{log: Here}]"
            text = _mission(do, robot).replace("mission: m", f"mission: m{number}")
            (folder / f"m{number}.yaml").write_text(text, encoding="utf-8")

    return make


def _robot(name: str) -> Callable[[Path], None]:
    """A shipped robot whose chart nobody has explored before."""

    def make(folder: Path) -> None:
        copied(name, folder)
        chart = folder / "chart.yaml"
        chart.write_text(chart.read_text("utf-8") + "# too large\n", encoding="utf-8")

    return make


def mission_with_faults(number: int) -> str:
    """A mission with so many steps that are none."""
    return _mission("[" + ", ".join(["{clamp: front}"] * number) + "]")


CLAMP = _mission("[ClampFront]")
BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + n)}: &{chr(98 + n)} [{', '.join([f'*{chr(97 + n)}'] * 10)}]\n" for n in range(5)
)

MADE: dict[str, Made] = {
    "a call leads to a folder": Made(_folder_as_file, ("mission.call", "m.yaml", 7), "m.yaml"),
    "a link leads nowhere": Made(_broken_link, ("file", "m.yaml", 0), "m.yaml"),
    "a link leads to itself": Made(_link_in_a_circle, ("file", "m.yaml", 0), "m.yaml"),
    "a mission is written in UTF-16": Made(
        _written("m.yaml", CLAMP.encode("utf-16")), ("encoding", "m.yaml", 0)
    ),
    "a pipe is written in Latin-1": Made(
        _written(
            "p.yaml", "pipe: p\ndiameter: 120 mm\ndescription: 5° to the left\n".encode("latin-1")
        ),
        ("encoding", "p.yaml", 3),
    ),
    "a line ends in CR alone": Made(
        _written("m.yaml", _mission("[Fly]").replace("\n", "\r").encode()),
        ("mission.command", "m.yaml", 7),
    ),
    "a file has more than a mebibyte": Made(
        _written("m.yaml", CLAMP + "# \n" * 400_000), ("too-large", "m.yaml", 0)
    ),
    "aliases stand for a hundred thousand values": Made(
        _written("m.yaml", BOMB + CLAMP), ("too-large", "m.yaml", 5)
    ),
    "brackets are nested without end": Made(
        _written("m.yaml", _mission("[" * 50 + "]" * 50)), ("too-deep", "m.yaml", 7)
    ),
    "steps are nested without end": Made(
        _written("m.yaml", _mission("[{repeat: {times: 1, do: " * 20 + "[Brake]" + "}}]" * 20)),
        ("too-deep", "m.yaml", 7),
    ),
    "a step is repeated by aliases": Made(
        _written("m.yaml", _mission("[&c ClampFront, " + "*c, " * 120 + "Brake]")),
        ("aliases", "m.yaml", 7),
    ),
    "a segment is repeated by aliases": Made(
        _written(
            "p.yaml",
            "pipe: p\ndiameter: 120 mm\nsegments:\n  - &s {straight: 1 m}\n" + "  - *s\n" * 110,
        ),
        ("aliases", "p.yaml", 105),
    ),
    "calls are nested too deeply": Made(
        _nested_calls("pirate_ii"), ("mission.depth", "m15.yaml", 7)
    ),
    "calls are nested too deeply with the other robot": Made(
        _nested_calls("../newt"), ("mission.depth", "m15.yaml", 7)
    ),
    "a folder holds more files than are looked at": Made(
        _many_files,
        ("check.folder", ".", 0),
        limits={"pirate_sm.checking.project_files.MOST_FILES": 4},
    ),
    "the chart of the PIRATE has too many combinations": Made(
        _robot("pirate_ii"),
        ("chart.too_large", "chart.yaml", 21),
        limits={"pirate_sm.core._loading.chart_exploration.MOST_CONFIGURATIONS": 100},
    ),
    "the chart of the newt has too many combinations": Made(
        _robot("newt"),
        ("chart.too_large", "chart.yaml", 2),
        limits={"pirate_sm.core._loading.chart_exploration.MOST_CONFIGURATIONS": 10},
    ),
    "a mission can come to more situations than are looked at": Made(
        _written("m.yaml", _mission("[ClampFront, ClampRear, DriveForward, Brake]")),
        ("check.too_large", "m.yaml", 2),
        limits={"pirate_sm.checking.exploring.explore.MOST_WORK": 5},
    ),
    "a mission of the other robot can come to too many": Made(
        _written("m.yaml", _mission("[HoldNose, HoldTail, GoAhead, Rest]", "../newt")),
        ("check.too_large", "m.yaml", 2),
        limits={"pirate_sm.checking.exploring.explore.MOST_WORK": 5},
    ),
    "folders are nested too deeply": Made(_deep_folders, ("check.folder", "/".join(["d"] * 33), 0)),
}
