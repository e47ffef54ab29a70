"""The port that a guardian owns, with what the guardian says written down beforehand."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pirate_sm.backends.serial.guardian import guarded_port
from pirate_sm.backends.serial.guardian.guarded_port import GuardedPort
from pirate_sm.backends.serial.guardian.notes import Instructions, Kind, Note

from ..bench import WANTED


class ScriptedGuardian:
    """A guardian without a process.

    Attributes:
        says: Its next notes.
        heard: What has been sent to it.
    """

    pid = None

    def __init__(self, patience_s: float) -> None:
        self.says = [Note(Kind.OPENED)]
        self.heard: list[Note] = []

    def start(self, *arguments: str) -> None: ...

    def hang_up(self) -> bool:
        return True

    def send(self, note: Note) -> None:
        self.heard.append(note)

    def receive(self, within_s: float) -> list[Note]:
        says, self.says = self.says, []
        return says


@pytest.fixture
def guardian(monkeypatch: pytest.MonkeyPatch) -> ScriptedGuardian:
    guardian = ScriptedGuardian(0.0)
    monkeypatch.setattr(guarded_port, "GuardianProcess", lambda patience_s: guardian)
    return guardian


@pytest.fixture
def port(
    guardian: ScriptedGuardian, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> GuardedPort:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    port = GuardedPort(str(tmp_path / "tty"), 57600, Instructions(0.3, WANTED))
    port.open()
    return port


def test_a_guardian_that_has_acted_is_let_relay_again_once_that_is_known(
    port: GuardedPort, guardian: ScriptedGuardian
) -> None:
    assert not port.overruled()
    assert guardian.heard == []

    guardian.says = [Note(Kind.OVERRULED)]
    port.read(port.now())

    assert port.overruled()
    assert guardian.heard == [Note(Kind.HEED)]
    assert not port.overruled(), "it is told once"
    assert guardian.heard == [Note(Kind.HEED)]


@pytest.mark.parametrize("allowed", [True, False])
def test_belief_a_run_goes_before_other_programs_while_it_has_a_port_if_it_may(
    guardian: ScriptedGuardian, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, allowed: bool
) -> None:
    nice = [3]

    def set_priority(which: int, who: int, value: int) -> None:
        if not allowed and value < nice[-1]:
            raise PermissionError
        nice.append(value)

    monkeypatch.setattr(os, "getpriority", lambda which, who: nice[-1])
    monkeypatch.setattr(os, "setpriority", set_priority)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    port = GuardedPort(str(tmp_path / "tty"), 57600, Instructions(0.3, WANTED))
    port.open()
    opened = nice[-1]
    port.close(stopped=True)

    assert opened == (-10 if allowed else 3)
    assert nice[-1] == 3
