"""Who takes a port over from a guardian that has outlived its runner, and whose word counts."""

from __future__ import annotations

import fcntl
import os
import signal
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.robot.backends.serial.guardian import takeover
from pirate_sm.robot.backends.serial.guardian.takeover import LeftBehind, Registration, take_over

MD5, PAYLOAD = "2f1d", b"\x00\x01stop"


@pytest.fixture(autouse=True)
def runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A runtime folder of its own."""
    folder = tmp_path / "runtime"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(folder))
    return folder


@pytest.fixture
def port(tmp_path: Path) -> str:
    (tmp_path / "port").touch()
    return str(tmp_path / "port")


@pytest.fixture
def guardian(port: str, runtime: Path) -> Iterator[LeftBehind]:
    """A guardian in this very process, which gives up its port when it is asked."""
    left = LeftBehind.of(port, MD5, PAYLOAD)
    registration = Registration(left)
    asked = [False]

    def give_up(*_: object) -> None:
        asked[0] = True
        registration.remove()

    before = signal.signal(signal.SIGUSR1, give_up)
    yield left
    signal.signal(signal.SIGUSR1, before)
    if not asked[0]:
        registration.remove()
    assert not [path for path in files(runtime) if str(left.pid) in path.name]


def files(runtime: Path) -> list[Path]:
    return list(runtime.rglob("guardian-*.json"))


def test_a_guardian_on_the_port_gives_it_up_with_the_array_that_stops_the_robot(
    guardian: LeftBehind, port: str, runtime: Path
) -> None:
    assert take_over(port, MD5) == guardian
    assert guardian.payload == PAYLOAD
    assert files(runtime) == []


def test_another_name_of_the_port_finds_it_too(
    guardian: LeftBehind, port: str, tmp_path: Path
) -> None:
    (tmp_path / "alias").symlink_to(port)

    assert take_over(str(tmp_path / "alias"), MD5) == guardian


def test_a_guardian_knows_its_port_by_the_name_it_was_given_and_by_the_device(
    port: str, tmp_path: Path
) -> None:
    alias = tmp_path / "alias"
    alias.symlink_to(port)

    left = LeftBehind.of(str(alias), MD5, PAYLOAD)

    assert left == (os.getpid(), str(alias), os.path.realpath(port), MD5, PAYLOAD)
    alias.unlink()  # such as a name by-id of a device that was unplugged
    assert left.holds(port)
    assert not left.holds("/dev/another")


def test_guardians_of_several_ports_register_side_by_side(
    guardian: LeftBehind, port: str, tmp_path: Path, runtime: Path
) -> None:
    (tmp_path / "other").touch()
    other = LeftBehind.of(str(tmp_path / "other"), MD5, PAYLOAD)._replace(pid=0)

    registration = Registration(other)

    assert len(files(runtime)) == 2
    registration.remove()
    assert take_over(port, MD5) == guardian


def test_folders_that_lack_are_made(
    port: str, runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(runtime / "of" / "later"))
    monkeypatch.setattr(takeover, "user_runtime_path", lambda name: runtime / "of/later" / name)

    registration = Registration(LeftBehind.of(port, MD5, PAYLOAD))

    assert len(files(runtime)) == 1
    registration.remove()


def test_a_machine_with_a_substitute_for_its_runtime_folder_is_no_reason_to_warn(
    port: str, runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def substitute(name: str) -> Path:
        warnings.warn("there is no such folder", UserWarning, stacklevel=2)
        return runtime / name

    monkeypatch.setattr(takeover, "user_runtime_path", substitute)

    assert take_over(port, MD5) is None  # every warning is an error here


def test_a_guardian_whose_file_has_gone_meanwhile_holds_nothing(tmp_path: Path) -> None:
    assert not takeover._ask(tmp_path / "gone", os.getpid())


def test_a_file_of_another_user_is_neither_believed_nor_deleted(
    guardian: LeftBehind, port: str, runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mine = os.getuid()
    with monkeypatch.context() as patch:
        patch.setattr(os, "getuid", lambda: mine + 1)
        assert take_over(port, MD5) is None

    assert len(files(runtime)) == 1
    assert take_over(port, MD5) == guardian


@pytest.mark.parametrize(("url", "md5"), [("/dev/another", MD5), ("", "another")])
def test_a_guardian_of_another_port_or_of_other_arrays_keeps_it(
    guardian: LeftBehind, port: str, runtime: Path, url: str, md5: str
) -> None:
    assert take_over(url or port, md5) is None
    assert len(files(runtime)) == 1


def test_what_a_dead_guardian_left_is_deleted_and_not_used(port: str, runtime: Path) -> None:
    registration = Registration(LeftBehind.of(port, MD5, PAYLOAD))
    (path,) = files(runtime)
    text = path.read_bytes()
    registration.remove()
    path.write_bytes(text)  # nobody holds its lock

    assert take_over(port, MD5) is None
    assert files(runtime) == []


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"payload": "no hex"}'])
def test_a_file_that_says_nothing_is_passed_over(
    guardian: LeftBehind, port: str, runtime: Path, text: str
) -> None:
    (files(runtime)[0].parent / "guardian-0.json").write_text(text)

    assert take_over(port, MD5) == guardian


def test_what_a_guardian_leaves_is_for_its_user_alone(guardian: LeftBehind, runtime: Path) -> None:
    (path,) = files(runtime)

    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("dies", [True, False])
def test_a_guardian_that_does_not_answer_is_killed(
    guardian: LeftBehind, port: str, monkeypatch: pytest.MonkeyPatch, dies: bool
) -> None:
    given: list[tuple[int, int]] = []
    waited_s: list[float] = []
    unlocked = iter([False, False, dies])  # before it is asked, after it is asked, and killed

    def locked(descriptor: int, within_s: float) -> bool:
        waited_s.append(within_s)
        return next(unlocked)

    monkeypatch.setattr(os, "kill", lambda pid, number: given.append((pid, number)))
    monkeypatch.setattr(takeover, "_locked", locked)

    assert take_over(port, MD5) == guardian
    assert waited_s == [0.0, 2.0, 2.0]
    assert given == [(os.getpid(), signal.SIGUSR1), (os.getpid(), signal.SIGKILL)]


def test_a_guardian_that_gives_up_the_port_is_not_killed(
    guardian: LeftBehind, port: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    kill, given = os.kill, list[int]()

    def noted(pid: int, number: int) -> None:
        given.append(number)
        kill(pid, number)

    monkeypatch.setattr(os, "kill", noted)

    assert take_over(port, MD5) == guardian
    assert given == [signal.SIGUSR1]


def test_a_lock_is_waited_for_no_longer_than_wanted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s, slept = [100.0], list[float]()

    def sleep(elapsed_s: float) -> None:
        slept.append(elapsed_s)
        now_s[0] += elapsed_s

    monkeypatch.setattr(takeover.time, "monotonic", lambda: now_s[0])
    monkeypatch.setattr(takeover.time, "sleep", sleep)
    path = tmp_path / "lock"
    with path.open("w") as held, path.open() as wanted:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert not takeover._locked(wanted.fileno(), 1.0)
        assert sum(slept) == pytest.approx(1.0, abs=0.03)
        slept.clear()
        assert not takeover._locked(wanted.fileno(), 0.0)
        assert slept == []
        fcntl.flock(held, fcntl.LOCK_UN)
        assert takeover._locked(wanted.fileno(), 0.0)


def test_where_no_file_can_be_written_nothing_is_registered(
    port: str, runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (runtime / "pirate_sm").write_text("in the way")

    Registration(LeftBehind.of(port, MD5, PAYLOAD)).remove()

    assert take_over(port, MD5) is None
