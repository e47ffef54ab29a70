"""The port that a guardian owns, with what the guardian says written down beforehand."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from threading import Thread, get_native_id

import pytest

from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.serial.guardian import guarded_port
from pirate_sm.robot.backends.serial.guardian.guard import Instructions, Note, NoteKind
from pirate_sm.robot.backends.serial.guardian.guarded_port import GuardedPort
from pirate_sm.robot.backends.serial.guardian.takeover import LeftBehind
from pirate_sm.robot.backends.serial.port import PortLostError

from ..bench import WANTED


class ScriptedGuardian:
    """A guardian without a process.

    Attributes:
        says: Its next notes.
        heard: What has been sent to it.
    """

    pid = None

    def __init__(self, patience_s: float) -> None:
        self.says = [Note(NoteKind.OPENED)]
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

    guardian.says = [Note(NoteKind.OVERRULED)]
    port.read(port.now())

    assert port.overruled()
    assert guardian.heard == [Note(NoteKind.HEED)]
    assert not port.overruled(), "it is told once"
    assert guardian.heard == [Note(NoteKind.HEED)]


@pytest.mark.parametrize("allowed", [True, False])
def test_belief_a_run_goes_before_other_programs_while_it_has_a_port_if_it_may(
    guardian: ScriptedGuardian, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, allowed: bool
) -> None:
    this = get_native_id() if sys.platform == "linux" else 0
    nice = {this: 3}

    def set_priority(which: int, who: int, value: int) -> None:
        if not allowed and value < nice[who]:
            raise PermissionError
        nice[who] = value

    monkeypatch.setattr(os, "getpriority", lambda which, who: nice[who])
    monkeypatch.setattr(os, "setpriority", set_priority)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    port = GuardedPort(str(tmp_path / "tty"), 57600, Instructions(0.3, WANTED))
    port.open()
    opened = nice[this]
    closing = Thread(target=port.close, args=(True,))  # as where a notebook is left
    closing.start()
    closing.join()

    assert opened == (-10 if allowed else 3)
    assert nice == {this: 3}


class ObedientGuardian:
    """A guardian without a process, in virtual time; it does what its attributes say.

    Attributes:
        says: Its notes, one batch for each time somebody listens; None: its pipe is closed.
        answers: Whether it acknowledges beats.
        fails: What sending to it raises.
        goes: Whether it ends once nobody talks to it.
        heard, done: What it was sent, and what was done to it.
    """

    pid = 17

    def __init__(self) -> None:
        self.now = 100.0
        self.says: list[list[Note] | None] = [[Note(NoteKind.OPENED)]]
        self.answers, self.goes = True, True
        self.fails: OSError | None = None
        self.heard: list[Note] = []
        self.done: list[str | tuple[str, ...]] = []

    def start(self, *arguments: str) -> None:
        self.done.append(arguments)

    def hang_up(self) -> bool:
        self.done.append("hang up")
        return self.goes

    def kill(self) -> None:
        self.done.append("kill")

    def leave(self) -> None:
        self.done.append("leave")

    def send(self, note: Note) -> None:
        if self.fails is not None:
            raise self.fails
        self.heard.append(note)
        if note.kind == NoteKind.BEAT and self.answers:
            self.says.append([Note(NoteKind.HEARD)])

    def receive(self, within_s: float) -> list[Note] | None:
        if self.says:
            self.now += 0.01
            return self.says.pop(0)
        self.now += max(within_s, 0.0)
        return []


LEFT = LeftBehind(7, "port", "/dev/port", "md5", b"stop it")
GUIDE = Instructions(0.3, WANTED)


class TestInVirtualTime:
    @pytest.fixture
    def guardian(self, monkeypatch: pytest.MonkeyPatch) -> ObedientGuardian:
        guardian = ObedientGuardian()
        monkeypatch.setattr(guarded_port, "GuardianProcess", lambda patience_s: guardian)
        monkeypatch.setattr(guarded_port, "_hurry", lambda nice, thread: None)
        return guardian

    @staticmethod
    def port_of(
        guardian: ObedientGuardian,
        monkeypatch: pytest.MonkeyPatch,
        left: LeftBehind | None = None,
    ) -> GuardedPort:
        def take_over(url: str, md5: str) -> LeftBehind | None:
            assert (url, md5) == ("tty", GUIDE.array_md5)
            return left

        monkeypatch.setattr(guarded_port, "take_over", take_over)
        port = GuardedPort("tty", 57600, GUIDE)
        monkeypatch.setattr(port, "now", lambda: guardian.now)
        return port

    @pytest.fixture
    def port(self, guardian: ObedientGuardian, monkeypatch: pytest.MonkeyPatch) -> GuardedPort:
        port = self.port_of(guardian, monkeypatch)
        port.open()
        assert guardian.done == [("tty", "57600", GUIDE.to_json())]
        guardian.done.clear()
        return port

    def test_a_robot_that_was_left_behind_is_stopped_before_the_port_counts_as_open(
        self, guardian: ObedientGuardian, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        guardian.says.append([Note(NoteKind.STOPPED)])
        port = self.port_of(guardian, monkeypatch, LEFT)

        port.open()

        assert guardian.heard == [Note(NoteKind.STOP, b"stop it"), Note(NoteKind.HEED)]
        assert "it is stopped now, as it has confirmed" in port.remark()
        assert port.remark() == ""

    def test_a_robot_that_does_not_confirm_its_stop_is_left_to_its_guardian(
        self, guardian: ObedientGuardian, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        guardian.goes = False
        port = self.port_of(guardian, monkeypatch, LEFT)

        with pytest.raises(BackendError, match="confirms none now; cut the robot's power"):
            port.open()

        assert guardian.now == pytest.approx(100.01 + GUIDE.boot_s + 6.0)
        assert guardian.heard == [Note(NoteKind.STOP, b"stop it")]
        assert guardian.done[1:] == ["hang up", "leave"]

    @pytest.mark.parametrize(
        ("says", "why", "elapsed_s"),
        [
            ([[Note(NoteKind.REFUSED, b"busy")]], "^busy$", 0.01),
            ([], "does not answer", 15.0),
        ],
    )
    def test_a_port_that_cannot_be_opened_needs_no_guardian(
        self,
        guardian: ObedientGuardian,
        monkeypatch: pytest.MonkeyPatch,
        says: list[list[Note] | None],
        why: str,
        elapsed_s: float,
    ) -> None:
        guardian.says = says
        port = self.port_of(guardian, monkeypatch)
        priorities: list[int | None] = []
        monkeypatch.setattr(
            guarded_port, "_hurry", lambda nice, thread: priorities.append(nice) or 5
        )

        with pytest.raises(BackendError, match=why):
            port.open()

        assert priorities == [-10, 5], "it goes before other programs only while it has a port"
        assert guardian.now == pytest.approx(100.0 + elapsed_s)
        assert guardian.heard == [Note(NoteKind.LEAVE)]
        assert port.guardian_pid is None

    def test_a_guardian_that_ends_at_once_is_said_not_to_have_started(
        self, guardian: ObedientGuardian, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        guardian.says = [None]

        with pytest.raises(BackendError, match="could not be started"):
            self.port_of(guardian, monkeypatch).open()

    def test_what_was_received_before_the_port_went_is_read_first_and_never_after_it_is_back(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        guardian.says = [[Note(NoteKind.DATA, b"last"), Note(NoteKind.LOST, b"unplugged")]]
        assert port.read(guardian.now + 1.0) == b"last"
        with pytest.raises(PortLostError, match="unplugged"):
            port.read(guardian.now + 1.0)
        with pytest.raises(PortLostError, match="unplugged"):
            port.write(b"out")
        assert not port.reopen()

        guardian.says = [[Note(NoteKind.DATA, b"of before"), Note(NoteKind.OPENED)]]
        assert port.reopen()
        assert port.read(guardian.now) == b""
        guardian.heard.clear()
        port.write(b"out")
        assert guardian.heard == [Note(NoteKind.WRITE, b"out")]

    def test_a_guardian_that_has_died_is_replaced_and_told_at_once_how_to_stop_the_robot(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        port.beat(b"safe")
        guardian.says = [[Note(NoteKind.DATA, b"old")], None]
        port.read(guardian.now)
        with pytest.raises(PortLostError, match="has died"):
            port.read(guardian.now)
        assert guardian.done == ["hang up"]
        with pytest.raises(PortLostError, match="has died"):
            port.read(guardian.now)
        with pytest.raises(PortLostError, match="has died"):
            port.write(b"out")
        guardian.heard.clear()
        guardian.says = [[Note(NoteKind.OPENED)]]

        assert port.reopen()

        assert guardian.heard == [Note(NoteKind.BEAT, b"safe")]
        assert guardian.done[1] == ("tty", "57600", GUIDE.to_json())
        port.beat(b"safe")
        assert len(guardian.heard) == 2, "it beats at once"

    def test_it_beats_six_times_in_the_time_of_silence_and_at_once_for_another_array(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        for elapsed_s, frame in (
            (0.0, b"a"),
            (0.04, b"a"),
            (0.02, b"a"),
            (0.01, b"b"),
            (0.01, b"b"),
        ):
            guardian.now += elapsed_s
            port.beat(frame)

        assert guardian.heard == [Note(NoteKind.BEAT, each) for each in (b"a", b"a", b"b")]

    def test_a_guardian_that_was_overruled_is_sent_a_beat_at_once(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        port.beat(b"a")
        guardian.says = [[Note(NoteKind.OVERRULED)]]
        port.read(guardian.now)
        assert port.overruled()

        port.beat(b"a")

        assert [each.kind for each in guardian.heard] == [
            NoteKind.BEAT,
            NoteKind.HEED,
            NoteKind.BEAT,
        ]

    def test_a_guardian_that_acknowledges_nothing_for_a_second_is_killed(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        guardian.answers = False
        begun_s = guardian.now

        def beats() -> None:
            for _ in range(99):
                port.beat(b"safe")
                guardian.now += 0.05

        with pytest.raises(PortLostError, match="did not answer and was replaced"):
            beats()
        assert guardian.done == ["kill"]
        assert guardian.now - begun_s == pytest.approx(1.0, abs=0.06)
        assert port.guardian_pid is None

    def test_a_guardian_that_acknowledges_lives(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        for _ in range(60):
            port.beat(b"safe")
            guardian.now += 0.04
            port.read(guardian.now)

        assert guardian.done == []

    @pytest.mark.parametrize(
        ("error", "why", "done"),
        [
            (TimeoutError(), "did not answer and was replaced", ["kill"]),
            (BrokenPipeError(), "has died", ["hang up", "leave"]),
        ],
    )
    def test_a_guardian_to_which_nothing_can_be_sent_is_lost(
        self,
        port: GuardedPort,
        guardian: ObedientGuardian,
        error: OSError,
        why: str,
        done: list[str],
    ) -> None:
        guardian.fails, guardian.goes = error, False

        with pytest.raises(PortLostError, match=why):
            port.write(b"out")

        assert guardian.done == done

    @pytest.mark.parametrize("safe", [b"safe", b""])
    def test_a_robot_that_is_stopped_needs_no_guardian(
        self, port: GuardedPort, guardian: ObedientGuardian, safe: bytes
    ) -> None:
        if safe:
            port.beat(safe)
        guardian.heard.clear()
        guardian.goes = False

        port.close(stopped=bool(safe))

        assert guardian.heard == [Note(NoteKind.LEAVE)]
        assert guardian.done == ["hang up", "kill"]
        assert port.remark() == ""

    def test_a_robot_that_has_not_confirmed_its_stop_keeps_its_guardian(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        port.beat(b"safe")
        guardian.heard.clear()
        guardian.goes = False
        begun_s = guardian.now

        port.close()

        assert guardian.now < begun_s + 0.1
        assert guardian.heard == [Note(NoteKind.BEAT, b"safe")]
        assert guardian.done == ["hang up", "leave"]
        assert "`kill 17` ends it" in port.remark()

    def test_a_guardian_that_does_not_answer_at_the_end_is_replaced(
        self, port: GuardedPort, guardian: ObedientGuardian
    ) -> None:
        port.beat(b"safe")  # that it was heard waits to be read, and says nothing now
        guardian.heard.clear()
        guardian.answers = False
        begun_s = guardian.now

        port.close()

        assert guardian.now == pytest.approx(begun_s + 1.01)
        assert guardian.heard == [Note(NoteKind.BEAT, b"safe")] * 2
        assert guardian.done == ["kill", ("tty", "57600", GUIDE.to_json()), "hang up"]
        assert port.remark() == "", "it has confirmed the stop to its successor"

    @pytest.mark.parametrize("goes", [True, False])
    @pytest.mark.parametrize("stopped", [True, False])
    def test_a_port_that_is_closed_twice_is_closed_once(
        self, port: GuardedPort, guardian: ObedientGuardian, stopped: bool, goes: bool
    ) -> None:
        """The second time started another guardian, although the robot had confirmed its stop."""
        port.beat(b"safe")
        guardian.goes = goes
        port.close(stopped=stopped)
        heard, done = list(guardian.heard), list(guardian.done)

        port.close()

        assert (guardian.heard, guardian.done) == (heard, done)
        assert ("`kill 17` ends it" in port.remark()) == (not stopped and not goes)
