"""Who takes a port over from a guardian that has outlived its runner, and whose word counts."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.backends.serial.guardian.takeover import LeftBehind, Registration, take_over

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
def guardian(port: str) -> Iterator[LeftBehind]:
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
