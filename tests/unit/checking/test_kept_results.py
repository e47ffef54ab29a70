"""Results of checks are used again as long as nothing has changed on which they depend."""

from __future__ import annotations

import ast
import os
import random
import shutil
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any

import pytest

import pirate_sm
from pirate_sm.checking import kept_results as kept
from pirate_sm.checking.check_file import FileCheck
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.gate import CheckError, pass_or_raise
from pirate_sm.cli.commands import fresh_check
from pirate_sm.cli.commands.cache import show_cache
from pirate_sm.cli.commands.check import run_check
from pirate_sm.cli.options.checks import CheckOptions
from pirate_sm.cli.options.files import CacheOptions
from pirate_sm.core import kept_entries as store
from pirate_sm.core.documents import FileKind
from pirate_sm.core.errors import UsageError
from pirate_sm.core.kept_entries import Entries
from pirate_sm.core.loading import load_mission, load_robot
from pirate_sm.core.on_disk import (
    DiskAnswers,
    asks_elsewhere,
    is_file,
    listed,
    noting,
    opened,
    unsaved,
)

from .robots import NEWT, ROOT, swap

SHORT = """\
format: 1
mission: {name}
robot: {robot}
pipe: {pipe}
start: hold
phases:
  hold: {{do: [{{command: HoldNose, retry: 1}}, HoldTail], go: held}}
ends:
  held: {{succeed: Both parts hold}}
"""


SOUND = "pirate_sm.core._loading.robot.loader._SOUND"
"""The robots that this process has loaded, whose charts are not looked for again."""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A project of a small robot, which is the working folder."""
    folder = tmp_path / "project"
    shutil.copytree(NEWT, folder / "hardware_profiles" / "newt")
    (folder / "sequences" / "pipes").mkdir(parents=True)
    shutil.copy(NEWT / "elbow.yaml", folder / "sequences" / "pipes")
    for name in ("one", "two"):
        text = SHORT.format(name=name, robot="../hardware_profiles/newt", pipe="elbow")
        (folder / "sequences" / f"{name}.yaml").write_text(text, "utf-8")
    monkeypatch.chdir(folder)
    monkeypatch.setenv(store.FOLDER_VARIABLE, str(tmp_path / "kept"))
    monkeypatch.setattr(kept, "_BEGAN_S", inf)  # the package does not change while it is tested
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "kept" / "checks"


@pytest.fixture
def report(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str]]:
    """Checks as `pirate check` does, with kept results or without."""

    def said(*, keep: bool = True, **options: Any) -> tuple[int, str]:
        asked = CheckOptions(**({"format": "json"} | options))
        try:
            if keep:
                with kept.kept_results():
                    code = run_check(asked)
            else:
                code = run_check(asked)
        except Exception as error:
            capsys.readouterr()
            return -1, repr(error)
        return code, capsys.readouterr().out

    return said


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The files that are checked, unchanged."""
    names: list[str] = []
    part = FileCheck.part
    monkeypatch.setattr(
        FileCheck, "part", lambda self, target: names.append(target.path.name) or part(self, target)
    )
    return names


@pytest.fixture
def made_afresh(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[[], Any]], Any]:
    """Makes a result while no memory of this process is believed either."""

    def afresh(make: Callable[[], Any]) -> Any:
        with monkeypatch.context() as patch:
            patch.setattr(DiskAnswers, "holds", lambda self: False)
            return make()

    return afresh


# --- what is used again ---------------------------------------------------------------------------


def test_nothing_is_checked_again_while_nothing_has_changed(here, report, made):
    first = report()
    assert len(made) > 2
    made.clear()

    assert report() == first
    assert made == []


def test_only_what_depends_on_a_change_is_checked_again(here, report, made):
    report()
    made.clear()
    swap(here / "sequences" / "one.yaml", ("HoldTail", "HoldNose"))
    report()

    assert made == ["one.yaml"]


def test_a_process_keeps_results_for_itself_also_of_files_that_are_not_saved(here, folder, made):
    memory, one = kept.KeptInMemory(), here / "sequences" / "one.yaml"

    def checked(text: str) -> tuple[list[str], int]:
        made.clear()
        with unsaved({str(one): text.encode()}), memory.used():
            report = check_paths()
        return [*made], len(report.open)

    good = one.read_text("utf-8")
    first, twice = checked(good), checked(good)
    changed = checked(good.replace("HoldTail", "HoldTale"))

    assert len(first[0]) > 2
    assert twice == ([], first[1])
    assert changed == (["one.yaml"], first[1] + 1)
    assert checked(good) == (["one.yaml"], first[1])
    assert not folder.exists()
    assert one.read_text("utf-8") == good


def test_a_robot_that_was_changed_is_loaded_again(here):
    robot = here / "hardware_profiles" / "newt"
    before = load_robot(robot)
    assert load_robot(robot) is before
    swap(robot / "profile.yaml", ("robot: newt", "robot: eft"))

    assert load_robot(robot).profile.robot == "eft"


def test_a_robot_has_the_file_names_of_the_working_folder(here, monkeypatch):
    robot = here / "hardware_profiles" / "newt"
    assert load_robot(robot).documents[0].name == "hardware_profiles/newt/profile.yaml"
    monkeypatch.chdir(robot)
    assert load_robot(robot).documents[0].name == "profile.yaml"


# --- the check before a run -----------------------------------------------------------------------


def test_the_check_before_a_simulated_run_is_kept(here, folder):
    loaded = load_mission(Path("sequences/one.yaml"))
    with kept.kept_results():
        found = pass_or_raise(loaded, backend="sim")
        entries = Entries(folder).all()
        assert pass_or_raise(load_mission(Path("sequences/one.yaml")), backend="sim") == found

    assert len(entries) == 1
    assert Entries(folder).all()[0].path == entries[0].path


def test_what_may_reach_a_robot_is_always_checked_afresh(here, folder):
    with kept.kept_results():
        for backend in ("serial", "somebodys", ""):
            pass_or_raise(load_mission(Path("sequences/one.yaml")), backend=backend)

    assert Entries(folder).all() == []


def test_a_mission_that_was_changed_after_it_was_loaded_is_not_what_was_kept(here, folder):
    loaded = load_mission(Path("sequences/one.yaml"))
    assert loaded.origin
    changed = replace(loaded, program=replace(loaded.program, start=1))
    assert not changed.origin
    with kept.kept_results():
        pass_or_raise(changed, backend="sim")
    assert Entries(folder).all() == []


def test_errors_refuse_a_run_also_from_a_file(here):
    swap(here / "sequences" / "one.yaml", ("{succeed: Both parts hold}", "{fail: Nothing holds}"))
    for _ in range(2):
        with kept.kept_results(), pytest.raises(CheckError) as refused:
            pass_or_raise(load_mission(Path("sequences/one.yaml")), backend="sim")
        assert refused.value.findings


# --- the folder -----------------------------------------------------------------------------------


def test_the_folder_is_only_for_its_owner(here, folder, report):
    report()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700

    shutil.rmtree(folder)
    folder.mkdir(mode=0o755)
    folder.chmod(0o755)
    report()
    assert list(folder.iterdir()) == []


def test_a_folder_of_somebody_else_is_not_used(here, folder, report, monkeypatch):
    report()
    before = {each.name: each.stat().st_mtime_ns for each in folder.iterdir()}
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    swap(here / "sequences" / "one.yaml", ("HoldTail", "HoldNose"))
    report()
    assert {each.name: each.stat().st_mtime_ns for each in folder.iterdir()} == before


@pytest.mark.parametrize(
    "harm",
    [
        lambda content: b"",
        lambda content: content[:-1],
        lambda content: content.replace(b"newt", b"eft."),
        lambda content: b"\x80\x04}." + content,
        lambda content: content.partition(b"\n")[2],
    ],
    ids=["empty", "cut", "changed", "foreign", "unsigned"],
)
def test_an_entry_that_is_damaged_is_made_again(here, folder, report, made, harm):
    first = report()
    for each in folder.iterdir():
        each.write_bytes(harm(each.read_bytes()))
    made.clear()

    assert report() == first
    assert made
    made.clear()
    assert report() == first
    assert made == []


def test_the_first_result_is_used_again_though_no_chart_was_explored_before(
    here, report, made, monkeypatch
):
    monkeypatch.setattr(SOUND, {})
    report()
    made.clear()
    report()
    assert made == []


@pytest.mark.parametrize(
    "content",
    [
        *(b"5", b"[]", b"{}", b'{"asked": []}', b'{"asked": [], "result": 5}', b"[" * 100_000),
        *(b'{"asked": [], "result": [0]}', b'{"asked": [], "result": ["a", 5]}'),
        *(b'{"asked": [[]], "result": [0, "a"]}', b'{"asked": [["is_art", "", ""]], "result": 0}'),
        b'{"asked": [["is_file", 5, ""]], "result": [0, "a"]}',
        b'{"asked": [["is_file", "a\\u0000\\ud800", ""]], "result": [0, "a"]}',
    ],
)
def test_an_entry_of_another_form_is_made_again(here, folder, report, made, content):
    first = report()
    for each in folder.iterdir():
        each.write_bytes(store._signature(each.name, content) + b"\n" + content)
    made.clear()

    assert report() == first
    assert made


def test_an_entry_under_another_key_is_made_again(here, folder, report):
    first = report(paths=["sequences/one.yaml"])
    content = {each.name: each.read_bytes() for each in folder.iterdir()}
    for name in content:
        (folder / name).write_bytes(next(it for key, it in content.items() if key != name))

    assert report(paths=["sequences/one.yaml"]) == first


@pytest.mark.timeout(30)
def test_an_entry_that_became_a_named_pipe_is_made_again(here, folder, report, made):
    first = report()
    for each in [*folder.iterdir()]:
        each.unlink()
        os.mkfifo(each)
    made.clear()

    assert report() == first
    assert made
    assert all(each.is_file() for each in folder.iterdir())


def test_an_entry_that_cannot_be_written_keeps_no_other_from_being_written(here, folder, report):
    report()
    found = [Path(each.path) for each in Entries(folder).all()]
    for each in found:
        each.unlink()
    found[0].mkdir()
    report()
    assert {Path(each.path) for each in Entries(folder).all()} == {*found[1:]}


def test_an_entry_that_vanishes_leaves_the_others(here, folder, report, monkeypatch):
    report()
    found = Entries(folder).all()
    gone, scan = found[0].path, os.scandir

    class Scanned(list[Any]):
        def __enter__(self) -> Scanned:
            return self

        def __exit__(self, *_: object) -> None:
            pass

    def scanned(path: Any) -> Scanned:
        inside = Scanned(scan(path))
        Path(gone).unlink(missing_ok=True)
        return inside

    monkeypatch.setattr(os, "scandir", scanned)
    assert Entries(folder).all() == found[1:]


def test_without_a_working_folder_nothing_is_kept(here, tmp_path, monkeypatch):
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    monkeypatch.setenv(store.FOLDER_VARIABLE, "rel")
    (tmp_path / "gone").rmdir()
    with kept.kept_results():
        assert kept.kept("it", (), lambda: 1, int) == 1
    assert show_cache(CacheOptions()) == 0


def test_a_folder_that_comes_into_being_is_not_used_if_it_is_open(here, folder, report, made):
    report()
    kept_there = folder.rename(folder.with_name("away"))
    made.clear()
    with kept.kept_results():
        kept_there.rename(folder)
        folder.chmod(0o755)
        run_check(CheckOptions(format="json"))
    assert made


def test_where_nothing_can_be_written_nothing_is_kept(here, folder, report, monkeypatch):
    expected = report(keep=False)
    folder.parent.write_text("in the way", "utf-8")
    assert report() == expected

    folder.parent.unlink()
    full = OSError(28, "No space left on device")
    monkeypatch.setattr(Path, "write_bytes", lambda self, data: (_ for _ in ()).throw(full))
    assert report() == expected
    assert [*folder.iterdir()] == []


def test_nothing_is_kept_if_the_variable_is_empty(here, folder, report, made, monkeypatch):
    monkeypatch.setenv(store.FOLDER_VARIABLE, "")
    report()
    made.clear()
    report()
    assert made
    assert not folder.exists()


def test_the_oldest_are_removed_and_files_of_others_stay(here, folder, report, monkeypatch):
    report()
    (folder / "notes.txt").write_text("x" * 10_000, "utf-8")
    old = folder / ("0" * 32)
    old.write_text("x" * 10_000, "utf-8")
    os.utime(old, (1, 1))
    total = sum(each.size for each in Entries(folder).all())
    monkeypatch.setattr(store, "LARGEST", total)
    monkeypatch.setattr(store, "_AFTER_CLEARING", total - 10_000)
    swap(here / "sequences" / "one.yaml", ("HoldTail", "HoldNose"))
    report()

    left = Entries(folder).all()
    assert 0 < sum(each.size for each in left) <= total - 10_000
    assert not old.exists()
    assert (folder / "notes.txt").exists()


def test_what_another_package_looks_at_is_not_kept(here, folder):
    with kept.kept_results():
        for _ in range(2):
            assert kept.kept("it", (), lambda: [asks_elsewhere()], list) == [None]
    assert Entries(folder).all() == []


def test_a_file_that_had_two_contents_while_it_was_read_is_not_kept(here, folder):
    def changing() -> int:
        for text in ("a", "b"):
            Path("it").write_text(text, "utf-8")
            with opened("it") as file:
                file.read()
        return 1

    with kept.kept_results():
        kept.kept("it", (), changing, int)
    assert Entries(folder).all() == []


def test_a_package_that_changes_keeps_nothing(here, folder, report, monkeypatch):
    monkeypatch.setattr(kept, "_BEGAN_S", 0.0)
    report()
    assert not folder.exists()


@pytest.mark.parametrize("what", ["version", "path", "entry points", "environment", "folder"])
def test_a_result_is_of_one_environment(here, folder, made, report, monkeypatch, tmp_path, what):
    installed = tmp_path / "first" / "detector-1.0.dist-info"
    installed.mkdir(parents=True)
    (installed / "entry_points.txt").write_text("[pirate_sm.detectors]", "utf-8")
    (installed.with_name("a.pth")).symlink_to("nowhere")  # must not hide what else is installed
    monkeypatch.setattr(sys, "path", [*sys.path, str(installed.parent)])
    report()
    made.clear()
    report()
    assert made == []
    match what:
        case "entry points":
            (installed / "entry_points.txt").write_text("[pirate_sm.detectors]\na = b:c", "utf-8")
        case "version":
            monkeypatch.setattr(sys, "version", "4.0")
        case "path":
            (tmp_path / "site" / "detector-1.0.dist-info").mkdir(parents=True)
            monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "site")])
        case "environment":
            monkeypatch.setenv("HOME", str(tmp_path))
        case "folder":
            shutil.copytree(here, tmp_path / "copy")
            monkeypatch.chdir(tmp_path / "copy")
    report()
    assert made


@pytest.mark.thorough
def test_two_processes_at_once_are_safe(here, folder):
    command = [sys.executable, "-c", "from pirate_sm.cli.start import main; main()", "check"]
    command += ["--format", "json"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    run = [
        subprocess.Popen(command, stdout=subprocess.PIPE, env=environment, text=True)
        for _ in range(4)
    ]
    said = {process.communicate()[0] for process in run}
    assert len(said) == 1
    assert {each.name[32:] for each in folder.iterdir()} == {""}


# --- nothing is asked beside `on_disk` ------------------------------------------------------------


@pytest.fixture
def beside(monkeypatch: pytest.MonkeyPatch) -> Iterator[set[tuple[str, str]]]:
    """The paths at which something is asked, though not by `on_disk` nor by an import."""
    package, found = str(Path(pirate_sm.__file__).parent), set[tuple[str, str]]()
    watching = [True]

    def note(what: str, path: Any) -> None:
        if not watching[0] or isinstance(path, int):
            return
        frame, files = sys._getframe(2), list[str]()
        while frame is not None:
            files.append(frame.f_code.co_filename)
            frame = frame.f_back
        own = [each for each in files if each.startswith(package)]
        by = any(each.endswith("on_disk.py") or "importlib" in each for each in files)
        if own and not by and not os.fsdecode(path).startswith(package):
            found.add((what, os.fsdecode(path)))

    def heard(event: str, arguments: tuple[Any, ...]) -> None:
        if event in ("open", "os.listdir", "os.scandir", "glob.glob"):
            note(event, arguments[0])

    for name in ("stat", "lstat", "readlink", "access"):
        real = getattr(os, name)

        def asking(path: Any, *rest: Any, _real: Any = real, _name: str = name, **more: Any) -> Any:
            note(_name, path)
            return _real(path, *rest, **more)

        monkeypatch.setattr(os, name, asking)
    sys.addaudithook(heard)
    yield found
    watching[0] = False  # a hook cannot be removed


def _watched(beside: set[tuple[str, str]], *paths: str) -> None:
    """Check twice: a memory of this process must repeat the questions of what it remembers."""
    wishes = _wishes()
    with noting() as first:
        check_paths(paths, wishes)
    with noting() as second:
        check_paths(paths, wishes)

    cache = str(store.charts().folder.parent)
    assert {each for each in beside if not each[1].startswith(cache)} == set()
    package = str(Path(pirate_sm.__file__).parent)
    of_project = [key for key in first.answers if not key[1].startswith(package)]
    assert [key for key in of_project if key not in second.answers] == []
    assert first.whole
    assert len(of_project) > 10


def _wishes() -> Any:
    return Wishes(
        others={
            FileKind.EXPERIMENT: fresh_check._check_experiment,
            FileKind.CAMPAIGN: fresh_check._check_campaign,
            FileKind.SCENE: fresh_check._check_scene,
        }
    )


CAMPAIGN = """\
format: 1
campaign: c
missions: [{mission: ../sequences/one.yaml}]
seeds: 0..3
"""


def test_nothing_is_asked_beside_the_module_of_the_disk(here, beside):
    Path("campaigns").mkdir()
    Path("campaigns/c.yaml").write_text(CAMPAIGN, "utf-8")
    _watched(beside)


@pytest.mark.thorough
def test_nothing_is_asked_beside_it_for_shipped_files(beside, monkeypatch):
    monkeypatch.chdir(ROOT)
    folders = ("hardware_profiles", "sequences/pipes", "cameras", "panels")
    _watched(beside, *folders, "sequences/mitre_bend.yaml", "campaigns/late_values.yaml")


def test_a_scene_is_not_kept_for_the_parser_of_its_command_lines_looks_itself(here):
    Path("s.yaml").write_text(SCENE, "utf-8")
    with noting() as asked:
        assert check_paths(["s.yaml"], _wishes()).findings == ()
    assert not asked.whole


SCENE = """\
format: 1
scene: s
title: A report
look_at: Whatever
steps: [{command: "graph sequences/one.yaml -o {out}/one.svg"}]
"""

BESIDE = {
    "core/library.py": "where this package is",
    "core/_loading/chart_exploration.py": "itself, for the key of a table",
    "core/kept_entries.py": "what is kept, which is the same with and without",
    "checking/kept_results.py": "the package and what is installed",
    "checking/shared_out.py": "how many threads this process has",
    "checking/reports/check_report.py": "writes files",
    "checking/reports/counterexamples.py": "writes files",
    "lab/campaign/campaign_file.py": "a mission instead of a campaign, which is not checked",
    "lab/campaign/plan.py": "the package",
    "lab/experiments/experiment_files.py": "the experiments that are run",
    "cli/settings.py": "the user's home, which is in each key",
}
"""Files that loading and checking are made of, and ask the disk themselves, with the reason."""

CHECKED_WITH = [
    *("robot/camera_file.py", "robot/calibration_files.py", "robot/control_panel/panel_file.py"),
    *("robot/backends/trace_script.py", "lab/campaign/named_parts.py", "lab/gallery/scene_file.py"),
    *("cli/scene_steps.py", "cli/settings_file.py", "cli/commands/fresh_check.py"),
]
"""Files of other rooms that have a part in checking; the runtime tests say which these are."""

ASKING = {
    *("open", "read_text", "read_bytes", "exists", "lexists", "is_file", "is_dir", "isfile"),
    *("isdir", "iterdir", "glob", "rglob", "stat", "lstat", "resolve", "realpath", "samefile"),
    *("readlink", "is_symlink", "islink", "listdir", "scandir", "expanduser", "access"),
}
"""What asks the disk, as methods and functions of the standard library."""


def _asks(file: Path) -> bool:
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Call):
            named, called = node.func, ast.unparse(node.func)
            method = isinstance(named, ast.Attribute) and named.attr in ASKING
            if called == "open" or (method and not called.startswith("commands.")):
                return True
    return False


def test_loading_and_checking_ask_by_one_module_alone():
    package = Path(pirate_sm.__file__).parent
    files = [*package.glob("core/**/*.py"), *package.glob("checking/**/*.py")]
    files += [package / name for name in (*CHECKED_WITH, *BESIDE)]
    asking = {file.relative_to(package).as_posix() for file in files if _asks(file)}
    assert asking == {"core/on_disk.py", *BESIDE}


# --- edits ----------------------------------------------------------------------------------------


class Editor:
    """Edits a project at random, and sometimes brings back what was there before."""

    def __init__(self, folder: Path, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder, self.random, self._patch = folder, random.Random(seed), monkeypatch
        self._before: list[tuple[Path, str]] = []
        self.options: dict[str, Any] = {}

    def edit(self) -> None:
        kinds = (
            *(self.change, self.change, self.change, self.restore, self.restore, self.restore),
            *(self.add, self.delete, self.rename, self.link, self.shadow, self.setting),
            *(self.environment, self.option, self.option),
        )
        self.random.choice(kinds)()

    def files(self) -> list[Path]:
        return sorted(each for each in self.folder.rglob("*.yaml") if each.is_file())

    def any_file(self) -> Path:
        file = self.random.choice(self.files())
        self._before.append((file, file.read_text("utf-8")))
        return file

    def change(self) -> None:
        file = self.any_file()
        lines = file.read_text("utf-8").splitlines(keepends=True)
        at = self.random.randrange(len(lines))
        swaps = [("1", "2"), ("Hold", "Holt"), ("elbow", "round"), ("one", "two"), ("", "")]
        old, new = self.random.choice(swaps)
        lines[at] = lines[at].replace(old, new) if old else ""
        file.write_text("".join(lines), "utf-8")

    def restore(self) -> None:
        if self._before:
            file, text = self.random.choice(self._before)
            if file.parent.is_dir():
                if file.is_symlink():
                    file.unlink()
                file.write_text(text, "utf-8")

    def add(self) -> None:
        name = self.random.choice(["three", "four", "round"])
        robot = self.random.choice(["newt", "../hardware_profiles/newt", "pirate_ii"])
        text = SHORT.format(name=name, robot=robot, pipe=self.random.choice(["elbow", "round"]))
        text = text.replace("HoldTail", "{call: one}") if name == "four" else text
        (self.folder / "sequences" / f"{name}.yaml").write_text(text, "utf-8")

    def delete(self) -> None:
        if len(self.files()) > 4:
            self.any_file().unlink()

    def rename(self) -> None:
        file = self.any_file()
        file.rename(file.with_name(self.random.choice(["round.yaml", "elbow.yaml", file.name])))

    def link(self) -> None:
        file = self.folder / "sequences" / self.random.choice(["one.yaml", "linked.yaml"])
        target = self.random.choice([*map(str, self.files()), "nowhere", "linked.yaml"])
        file.unlink(missing_ok=True)
        file.symlink_to(target)

    def shadow(self) -> None:
        folder = self.folder / "sequences" / self.random.choice(["newt", "pirate_ii"])
        if folder.is_symlink():
            folder.unlink()
        elif not folder.exists():
            folder.symlink_to(self.folder / "hardware_profiles" / "newt")

    def setting(self) -> None:
        file = self.folder / "pirate.toml"
        text = self.random.choice(["", 'robot = "pirate_ii"', 'robot = "newt"', "robot = 1"])
        file.write_text(text, "utf-8")

    def environment(self) -> None:
        home = self.folder.parent / self.random.choice(["home", "other"])
        (home / "pirate_sm").mkdir(parents=True, exist_ok=True)
        robot = self.random.choice(["pirate_ii", str(self.folder / "hardware_profiles/newt")])
        (home / "pirate_sm" / "config.toml").write_text(f'robot = "{robot}"', "utf-8")
        self._patch.setenv("XDG_CONFIG_HOME", str(home))

    def option(self) -> None:
        self.options = self.random.choice(
            [
                *({}, {}, {"outside": True}, {"paths": ["sequences"]}),
                *({"paths": ["sequences/one.yaml"]}, {"paths": ["hardware_profiles"]}),
                *({"robot": "hardware_profiles/newt"}, {"pipe": "elbow"}, {"robot": "newt"}),
                *({"settings": ["speed=1 m/s"]}, {"format": "text"}, {"fail_on": "warning"}),
            ]
        )


def _edited(
    here: Path, number: int, report: Any, made: list[str], afresh: Any, patch: pytest.MonkeyPatch
) -> None:
    editor = Editor(here, number, patch)
    checked, counted = 0, 0
    for step in range(number):
        editor.edit()
        made.clear()
        again = report(**editor.options)
        counted += len(made)
        made.clear()
        expected = afresh(lambda: report(keep=False, **editor.options))
        checked += len(made)
        assert again == expected, f"after {step + 1} edits"
    assert counted < checked * 0.8


def test_after_edits_a_check_says_the_same_with_kept_results(
    here, report, made, made_afresh, monkeypatch
):
    _edited(here, 12, report, made, made_afresh, monkeypatch)


@pytest.mark.thorough
@pytest.mark.timeout(1800)
def test_after_many_edits_a_check_says_the_same_with_kept_results(
    here, report, made, made_afresh, monkeypatch
):
    _edited(here, 500, report, made, made_afresh, monkeypatch)


# --- the command line -----------------------------------------------------------------------------


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "COLUMNS": "70"}
    begin = "from pirate_sm.cli.start import main; main()"
    command = [sys.executable, "-X", "importtime", "-c", begin, *words]
    return subprocess.run(command, capture_output=True, env=environment, text=True, check=False)


def test_a_kept_report_is_printed_without_reading_options(here):
    swap(here / "sequences" / "one.yaml", ("HoldTail", "HoldTale"))
    once, twice = _run("check", "sequences/one.yaml"), _run("check", "sequences/one.yaml")

    assert (once.returncode, twice.returncode) == (1, 1)
    assert "HoldTale" in once.stdout
    assert once.stdout == twice.stdout
    assert "typer" in once.stderr
    for package in ("typer", "pydantic", "yaml", "numpy", "mcap"):
        assert f" {package}\n" not in twice.stderr


@pytest.mark.thorough
def test_an_option_keeps_nothing(here, folder):
    _run("check", "--no-cache")
    _run("check", "--nonsense")
    assert not folder.exists()


def test_kept_results_are_shown_and_cleared(here, folder, report, capsys, monkeypatch):
    monkeypatch.setattr(SOUND, {})
    report()
    (folder / "notes.txt").touch()
    many = len(Entries(folder).all())
    assert show_cache(CacheOptions()) == 0
    shown, charts = capsys.readouterr().out, folder.with_name("charts")
    assert f"{folder}: {many} results, 0." in shown
    assert f"{charts}: 1 table, 0." in shown
    assert show_cache(CacheOptions(what="clear")) == 0
    removed = f"{many} results removed from {folder}\n1 table removed from {charts}\n"
    assert capsys.readouterr().out == removed
    assert [each.name for each in folder.iterdir()] == ["notes.txt"]
    assert [*charts.iterdir()] == []


def test_without_a_folder_there_is_nothing_to_show(here, monkeypatch, capsys):
    monkeypatch.setenv(store.FOLDER_VARIABLE, "")
    assert show_cache(CacheOptions()) == 0
    assert "PIRATE_SM_CACHE is empty: no results are kept\n" in capsys.readouterr().out


def test_what_a_link_leads_to_is_not_cleared(here, folder, report, tmp_path):
    report()
    folder.rename(tmp_path / "foreign")
    folder.symlink_to(tmp_path / "foreign")
    many = len([*(tmp_path / "foreign").iterdir()])
    with pytest.raises(UsageError, match="is not used: it must be your own folder"):
        show_cache(CacheOptions(what="clear"))
    assert len([*(tmp_path / "foreign").iterdir()]) == many


def test_a_folder_with_the_name_of_an_entry_stays(here, folder, report):
    report()
    (folder / ("0" * 32)).mkdir()
    assert show_cache(CacheOptions(what="clear")) == 0
    assert [each.name for each in folder.iterdir()] == ["0" * 32]


def test_results_that_cannot_be_removed_are_an_error(here, report, monkeypatch):
    report()
    denied = PermissionError(13, "Permission denied")
    monkeypatch.setattr(Path, "unlink", lambda self, **_: (_ for _ in ()).throw(denied))
    with pytest.raises(UsageError, match="cannot be removed: Permission denied"):
        show_cache(CacheOptions(what="clear"))


# --- questions ------------------------------------------------------------------------------------


def test_a_listing_has_folders_and_our_files_only(tmp_path):
    (tmp_path / "b.yaml").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "a").mkdir()
    (tmp_path / "c").symlink_to("a")
    assert [tuple(each) for each in listed(tmp_path)] == [
        ("a", True, False),
        ("b.yaml", False, False),
        ("c", True, True),
    ]


def test_an_absence_is_an_answer(tmp_path):
    with noting() as asked:
        assert not is_file(tmp_path / "it")
        with pytest.raises(FileNotFoundError):
            opened(tmp_path / "it")
    assert asked.holds()
    (tmp_path / "it").touch()
    assert not asked.holds()
