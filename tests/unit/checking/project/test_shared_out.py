"""Processes check missions and campaigns as one process does, and what they ask counts."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from checking.robots import NEWT, ROOT
from pirate_sm.checking.check_project import FEWEST
from pirate_sm.checking.project_files import CheckTarget
from pirate_sm.checking.shared_out import _groups
from pirate_sm.core.documents import FileKind

MISSION = """\
format: 1
mission: m{n}
robot: ../newt
start: first
phases:
  first: {{do: [{{call: called{m}}}], go: done}}
ends:
  done: {{succeed: Done}}
"""
CALLED = """\
format: 1
mission: called{m}
robot: ../newt
start: hold
phases:
  hold: {{do: [HoldNose], go: held}}
ends:
  held: {{succeed: It holds}}
"""
CODE = """\
import os, sys
if sys.argv[1] == "1":
    os.sched_getaffinity = lambda _: {0}
from pirate_sm.checking import check_file, kept_results
kept_results._BEGAN_S = float("inf")
part = check_file.FileCheck.part
check_file.FileCheck.part = lambda self, target: made.append(target.path.name) or part(self, target)
made = []
import atexit
atexit.register(lambda: print(*made, file=sys.stderr))
sys.argv = ["pirate", "check", *sys.argv[2:]]
from pirate_sm.cli.start import main
main()
"""


@pytest.fixture
def here(tmp_path: Path) -> Path:
    """A project of more missions than one process checks."""
    shutil.copytree(NEWT, tmp_path / "newt")
    (tmp_path / "sequences").mkdir()
    for n in range(FEWEST):
        text = MISSION.format(n=n, m=n % 2)
        (tmp_path / "sequences" / f"m{n}.yaml").write_text(text, "utf-8")
    for m in range(2):
        path = tmp_path / "sequences" / f"called{m}.yaml"
        path.write_text(CALLED.format(m=m), "utf-8")
    return tmp_path


@pytest.fixture
def checked(here: Path) -> Callable[..., tuple[str, set[str]]]:
    def checked(processors: int, cache: str) -> tuple[str, set[str]]:
        """Return the report, and which files this process has checked itself."""
        ran = subprocess.run(
            [sys.executable, "-c", CODE, str(processors), "--format", "json", "sequences"],
            capture_output=True,
            check=False,
            text=True,
            cwd=here,
            env={**os.environ, "PYTHONPATH": str(ROOT), "PIRATE_SM_CACHE": cache},
        )
        assert ran.returncode in {0, 1}, ran.stderr
        return ran.stdout, set(ran.stderr.split())

    return checked


needs_processors = pytest.mark.skipif(
    sys.platform != "linux" or len(os.sched_getaffinity(0)) < 2, reason="one processor"
)


@needs_processors
def test_processes_find_the_same_in_the_same_order(
    checked: Callable[..., tuple[str, set[str]]],
) -> None:
    alone, made_alone = checked(1, "")
    shared, made_here = checked(2, "")

    assert shared == alone
    assert made_alone >= {f"m{n}.yaml" for n in range(FEWEST)}
    assert not made_here


@pytest.mark.thorough
@needs_processors
def test_what_a_process_has_asked_of_the_disk_is_asked_again(
    here: Path, checked: Callable[..., tuple[str, set[str]]]
) -> None:
    first, _ = checked(2, "kept")
    again, made = checked(2, "kept")
    assert (again, made) == (first, set())

    changed = here / "sequences" / "called1.yaml"
    changed.write_text(changed.read_text("utf-8").replace("HoldNose", "HoldNos"), "utf-8")
    found, made = checked(2, "kept")

    assert made == {"called1.yaml", "m1.yaml", "m3.yaml", "m5.yaml"}  # too few for processes
    assert found == checked(1, "")[0] != first


OTHER_REFUSALS = (
    "import multiprocessing.synchronize as s; s.SemLock.__init__ = lambda *_, **k: open('/no')",
    "import threading; threading.Thread.start = lambda _: (_ for _ in ()).throw(RuntimeError)",
    "import os; os.listdir = lambda _: open('/nowhere')",
)


@pytest.mark.thorough
@needs_processors
@pytest.mark.parametrize(
    "refused",
    [
        "import os; os.fork = lambda: open('/nowhere')",
        *(pytest.param(each, marks=pytest.mark.thorough) for each in OTHER_REFUSALS),
    ],
    ids=["process", "semaphore", "thread", "task"],
)
def test_where_the_system_refuses_processes_the_command_checks_alone(
    refused: str, here: Path, checked: Callable[..., tuple[str, set[str]]]
) -> None:
    report, _ = checked(1, "")

    ran = subprocess.run(
        [sys.executable, "-c", f"{refused}\n{CODE}", "2", "--format", "json", "sequences"],
        capture_output=True,
        check=False,
        text=True,
        cwd=here,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PIRATE_SM_CACHE": ""},
    )

    assert ran.stdout == report
    assert {*ran.stderr.split()} >= {f"m{n}.yaml" for n in range(FEWEST)}
    assert "Traceback" not in ran.stderr


@needs_processors
def test_ctrl_c_while_processes_begin_ends_the_command(here: Path) -> None:
    heard = (
        "import os, signal; signal.signal(signal.SIGINT, signal.SIG_DFL)"  # if it is ignored here
    )
    code = f"{heard}; os.register_at_fork(before=lambda: os.kill(os.getpid(), 2))\n{CODE}"

    ran = subprocess.run(
        [sys.executable, "-c", code, "2", "sequences"],
        capture_output=True,
        check=False,
        text=True,
        cwd=here,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PIRATE_SM_CACHE": ""},
    )

    assert ran.returncode == 130
    assert ran.stderr.startswith("interrupted\n")
    assert "Traceback" not in ran.stderr


def test_a_campaign_is_checked_with_the_missions_that_it_names(tmp_path: Path) -> None:
    for name, text in (("c", "missions: [{mission: one}, {mission: ../two.yaml}]"), ("d", "two")):
        (tmp_path / f"{name}.yaml").write_text(text, "utf-8")
    campaigns = [CheckTarget(FileKind.CAMPAIGN, tmp_path / f"{n}.yaml", False) for n in "cd"]
    missions = [
        CheckTarget(FileKind.MISSION, tmp_path / f"{name}.yaml", False)
        for name in ("one", "three", "two")
    ]

    groups = _groups([*missions, *campaigns])

    assert groups == [[missions[0], missions[2], *campaigns], [missions[1]]]


@needs_processors
def test_processes_end_with_a_command_that_is_killed(here: Path, tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    code = CODE.replace(
        "made.append(target.path.name)", f"open({str(begun)!r}, 'a').write(f'{{os.getpid()}} ')"
    ).replace("or part(self, target)", "and __import__('time').sleep(600)")
    command = subprocess.Popen(
        [sys.executable, "-c", code, "2", "sequences"],
        cwd=here,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PIRATE_SM_CACHE": ""},
    )
    while not begun.exists() or len(begun.read_text().split()) < 2:
        time.sleep(0.05)
    command.kill()
    command.wait()

    for each in map(int, begun.read_text().split()):
        while Path(f"/proc/{each}").exists():
            time.sleep(0.05)


def test_one_file_makes_no_process(
    checked: Callable[..., tuple[str, set[str]]], here: Path
) -> None:
    for n in range(1, FEWEST):
        (here / "sequences" / f"m{n}.yaml").unlink()

    _, made = checked(2, "")

    assert "m0.yaml" in made
