"""The guardian as a process, with a pseudo-terminal for its port."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.serial.guardian import guarded_port
from pirate_sm.robot.backends.serial.guardian.guard import Instructions
from pirate_sm.robot.backends.serial.guardian.guarded_port import GuardedPort
from pirate_sm.robot.backends.serial.port import PortLostError
from pirate_sm.robot.rosserial.frames import encode

from ..bench import FIRST_SUBSCRIBER, PATIENCE_S, WANTED, Bench

SAFE = encode(FIRST_SUBSCRIBER, b"safe")
DRIVE = encode(FIRST_SUBSCRIBER, b"drive")
INSTRUCTIONS = Instructions(0.3, WANTED, boot_s=0.2, stay_s=60.0)
PATIENT = INSTRUCTIONS._replace(silence_s=5.0)

RUNNER = """
import sys, time
from pirate_sm.robot.backends.serial.guardian.guard import Instructions
from pirate_sm.robot.backends.serial.guardian.guarded_port import GuardedPort
port = GuardedPort(sys.argv[1], 57600, Instructions.from_json(sys.argv[4]))
port.open()
port.beat(bytes.fromhex(sys.argv[2]))
port.write(bytes.fromhex(sys.argv[3]))
print(port.guardian_pid, flush=True)
while True:
    port.beat(bytes.fromhex(sys.argv[2]))
    port.read(port.now() + 0.05)
    if port.overruled():
        print("overruled", flush=True)
"""

ENDS_GUARDIANS = """
import os, pathlib, signal, sys
sys.stdin.read()
for process in pathlib.Path("/proc").glob("[0-9]*"):
    try:
        ours = sys.argv[1].encode() in (process / "environ").read_bytes().split(b"\\0")
        if ours and b"guardian.process" in (process / "cmdline").read_bytes():
            os.kill(int(process.name), signal.SIGKILL)
    except OSError:
        pass
"""
"""Kills the guardians of a test when its standard input ends."""


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with Bench(tmp_path / "tty") as bench:
        yield bench


@pytest.fixture(autouse=True)
def _ends_its_guardians(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """No guardian outlives a test that fails or a pytest that is killed: they hang in some tests.

    Guardians are found by the runtime folder, which also those of a runner have in common.
    """
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with _guardian_killer(tmp_path):
        yield


@pytest.fixture
def runner(bench: Bench) -> Iterator[subprocess.Popen[str]]:
    arguments = [sys.executable, "-c", RUNNER, bench.name, SAFE.hex(), DRIVE.hex()]
    arguments += [INSTRUCTIONS.to_json()]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


def _guardian_killer(folder: Path) -> subprocess.Popen[bytes]:
    """A process that kills the guardians of a test when this one closes its input, or ends."""
    arguments = [sys.executable, "-IS", "-c", ENDS_GUARDIANS, f"XDG_RUNTIME_DIR={folder}"]
    # Without our environment, by which it finds them, it does not kill itself.
    return subprocess.Popen(arguments, stdin=subprocess.PIPE, env={}, start_new_session=True)


def _driven(bench: Bench, runner: subprocess.Popen[str]) -> int:
    """The guardian's process, once the runner has driven the robot."""
    assert runner.stdout is not None
    guardian = int(runner.stdout.readline())
    bench.hear(b"drive")
    return guardian


def _opened(bench: Bench, instructions: Instructions) -> GuardedPort:
    port = GuardedPort(bench.name, 57600, instructions)
    port.open()
    return port


def _driving(bench: Bench, instructions: Instructions) -> GuardedPort:
    """An open port, with which the robot has been driven and can be stopped."""
    port = _opened(bench, instructions)
    port.beat(SAFE)
    port.write(DRIVE)
    bench.hear(b"drive")
    return port


def _guardian_of(port: GuardedPort) -> int:
    assert port.guardian_pid is not None
    return port.guardian_pid


def _end(runner: subprocess.Popen[str]) -> None:
    runner.kill()
    runner.wait()


def _leave_alone(runner: subprocess.Popen[str]) -> None:
    """Kill the runner, and wait until its guardian has noted that it is alone."""
    _end(runner)
    _await_file()


def _reopen(port: GuardedPort) -> None:
    give_up_s = port.now() + PATIENCE_S
    while not port.reopen():
        assert port.now() < give_up_s
        port.wait(port.now() + 0.05)


def _beat_on(port: GuardedPort, seconds: float) -> None:
    end_s = port.now() + seconds
    while port.now() < end_s:
        port.beat(SAFE)
        port.read(port.now() + 0.02)


def _await_file() -> Path:
    """The file of a guardian that is alone, once there is one."""
    give_up_s = time.monotonic() + PATIENCE_S
    while True:
        for path in Path(os.environ["XDG_RUNTIME_DIR"]).glob("*/guardian-*.json"):
            return path
        assert time.monotonic() < give_up_s
        select.select([], [], [], 0.02)


def _read_on(port: GuardedPort) -> None:
    """Something has been read for as long as a device may talk."""
    give_up_s = port.now() + PATIENCE_S
    while port.now() < give_up_s:
        port.read(give_up_s)


def _gone(pid: int, patience_s: float = PATIENCE_S) -> bool:
    give_up_s = time.monotonic() + patience_s
    while True:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except (FileNotFoundError, ProcessLookupError):
            return True
        if state == "Z":
            return True
        if time.monotonic() > give_up_s:
            return False
        select.select([], [], [], 0.02)


def test_the_guardian_outlives_its_runner_while_a_device_that_talks_confirms_nothing(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    """A silent device hid that a byte after the runner's death could end the guardian."""
    guardian = _driven(bench, runner)
    bench.echoes = False
    _end(runner)
    bench.wait(lambda: sum(each == b"safe" for _, each in bench.applied) > 5, "repeats")
    assert not _gone(guardian, 0.0)

    bench.echoes = True
    assert _gone(guardian)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM])
def test_however_the_runner_ends_the_safe_frame_follows_within_half_a_second(
    bench: Bench, runner: subprocess.Popen[str], how: signal.Signals
) -> None:
    guardian = _driven(bench, runner)
    ended_s = time.monotonic()
    runner.send_signal(how)

    assert bench.hear(b"safe") - ended_s < 0.5
    _end(runner)
    assert _gone(guardian)


def test_a_runner_that_stood_still_is_told_however_much_the_device_has_said_meanwhile(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    assert runner.stdout is not None
    runner.stdout.readline()
    bench.hear(b"drive")
    runner.send_signal(signal.SIGSTOP)
    for _ in range(200):
        bench.say(bytes(2000))  # more than the pipe between the two holds
    bench.hear(b"safe")
    runner.send_signal(signal.SIGCONT)

    assert runner.stdout.readline() == "overruled\n"
    assert runner.poll() is None


def test_the_terminals_interrupt_does_not_reach_the_guardian_and_a_termination_ends_safely(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    guardian = _driven(bench, runner)
    os.kill(guardian, signal.SIGINT)
    os.kill(guardian, signal.SIGHUP)
    os.kill(guardian, signal.SIGTERM)

    bench.hear(b"safe")
    assert _gone(guardian)


def test_it_relays_and_leaves_quietly(bench: Bench) -> None:
    port = _driving(bench, PATIENT)
    bench.say(b"hello")
    heard = b""
    give_up_s = port.now() + PATIENCE_S
    while b"hello" not in heard and port.now() < give_up_s:
        heard += port.read(give_up_s)
    assert b"hello" in heard
    guardian = _guardian_of(port)
    port.close(stopped=True)

    assert _gone(guardian)
    assert [payload for _, payload in bench.applied] == [b"drive"]


def test_a_port_is_for_one_program_only(bench: Bench) -> None:
    first = _opened(bench, PATIENT)

    with pytest.raises(BackendError, match="in use by another program"):
        GuardedPort(bench.name, 57600, PATIENT).open()
    first.close()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("/dev/ttyNotThere", "there is no port /dev/ttyNotThere; there "),
        ("/dev/null", "/dev/null is not a serial port"),
        ("nonsense://x", "nonsense://x cannot be a serial port"),
    ],
)
def test_a_wrong_port_is_told_as_what_it_is(name: str, message: str) -> None:
    with pytest.raises(BackendError, match=message):
        GuardedPort(name, 57600, PATIENT).open()


def test_a_port_that_goes_away_is_lost(bench: Bench) -> None:
    port = _opened(bench, PATIENT)
    bench.unplug()

    with pytest.raises(PortLostError, match="has gone"):
        _read_on(port)
    port.close()


def test_a_guardian_that_dies_is_a_lost_port_and_the_next_one_takes_over(bench: Bench) -> None:
    port = _opened(bench, PATIENT)
    os.kill(_guardian_of(port), signal.SIGKILL)
    with pytest.raises(PortLostError, match="guardian of the port has died"):
        _read_on(port)

    _reopen(port)
    port.write(DRIVE)
    bench.hear(b"drive")
    port.close()


def test_a_guardian_that_hangs_is_noticed_killed_and_replaced(bench: Bench) -> None:
    port = _opened(bench, INSTRUCTIONS)
    hung = _guardian_of(port)
    _beat_on(port, 0.3)
    os.kill(hung, signal.SIGSTOP)

    with pytest.raises(PortLostError, match="did not answer and was replaced"):
        _beat_on(port, PATIENCE_S)
    assert _gone(hung, 0.0)
    _reopen(port)
    _beat_on(port, 0.3)
    assert port.guardian_pid not in (hung, None)
    port.close(stopped=True)


def test_a_cable_that_is_back_only_when_nobody_but_the_guardian_is_there(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    guardian = _driven(bench, runner)
    bench.hears = False
    _leave_alone(runner)
    bench.hears = True

    bench.hear(b"safe")
    assert _gone(guardian)


def test_a_port_that_returns_after_the_runner_has_died_is_opened_by_the_guardian(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    guardian = _driven(bench, runner)
    bench.unplug()
    _end(runner)
    bench.plug(shift=3)  # its topics have other numbers now

    bench.hear(b"safe")
    assert _gone(guardian)
    assert bench.asked


def test_a_runner_that_gives_up_leaves_the_guardian_and_says_so(bench: Bench) -> None:
    port = _driving(bench, INSTRUCTIONS)
    bench.unplug()
    guardian = _guardian_of(port)
    port.close(stopped=False)

    assert port.remark() == (
        "cut the robot's power: it has not confirmed that it stopped. A guardian of the port "
        f"(process {guardian}) keeps trying for 1 min, and gives the port to a new run; "
        f"`kill {guardian}` ends it"
    )
    assert port.remark() == ""
    bench.plug()
    bench.hear(b"safe")
    assert _gone(guardian)


def test_a_guardian_that_hangs_when_the_runner_leaves_is_replaced_by_one_that_stops_the_robot(
    bench: Bench,
) -> None:
    port = _driving(bench, INSTRUCTIONS)
    os.kill(_guardian_of(port), signal.SIGSTOP)
    port.close(stopped=False)

    bench.hear(b"safe")
    assert port.remark() == ""


def test_a_new_run_gets_the_port_from_the_guardian_and_the_stop_comes_first(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    guardian = _driven(bench, runner)
    bench.hears = False
    _leave_alone(runner)
    bench.plug()
    bench.hears = True
    bench.applied.clear()
    port = _opened(bench, INSTRUCTIONS)

    assert _gone(guardian, 0.0)
    assert [payload for _, payload in bench.applied[:1]] == [b"safe"]
    assert "without a confirmed stop: it is stopped now" in port.remark()
    port.write(DRIVE)
    bench.hear(b"drive")
    port.close(stopped=True)


def test_a_new_run_does_not_begin_while_the_robot_of_the_old_one_confirms_nothing(
    bench: Bench, runner: subprocess.Popen[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "pirate_sm.robot.backends.serial.guardian.guarded_port._STOPS_WITHIN_S", 0.5
    )
    _driven(bench, runner)
    bench.echoes = False
    _leave_alone(runner)
    with pytest.raises(BackendError, match=r"confirms none now; cut the robot's power.*`kill"):
        GuardedPort(bench.name, 57600, INSTRUCTIONS).open()

    bench.echoes = True
    assert _gone(int(_await_file().stem.partition("-")[2]))


def test_a_new_run_that_finds_no_port_leaves_a_guardian_as_the_old_one_did(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    """A second attempt while the cable is out must not take the last one away who can stop it."""
    guardian = _driven(bench, runner)
    bench.unplug()
    _leave_alone(runner)
    with pytest.raises(BackendError, match=r"there is no port .*; cut the robot's power"):
        GuardedPort(bench.name, 57600, INSTRUCTIONS).open()

    assert _gone(guardian)
    successor = int(_await_file().stem.partition("-")[2])
    bench.plug()
    bench.hear(b"safe")
    assert _gone(successor)


def test_a_run_for_another_robot_does_not_get_the_port(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    guardian = _driven(bench, runner)
    bench.echoes = False
    _leave_alone(runner)
    others = INSTRUCTIONS._replace(wanted=tuple(each._replace(md5="other") for each in WANTED))
    with pytest.raises(BackendError, match="in use by another program"):
        GuardedPort(bench.name, 57600, others).open()

    assert not _gone(guardian, 0.0)
    bench.echoes = True
    assert _gone(guardian)


def test_a_guardian_that_is_alone_ends_when_an_operator_wants_it_to(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    guardian = _driven(bench, runner)
    bench.echoes = False
    _leave_alone(runner)
    os.kill(guardian, signal.SIGTERM)

    assert _gone(guardian)


def test_whoever_reads_the_output_of_a_run_does_not_wait_for_its_guardian(
    bench: Bench, runner: subprocess.Popen[str]
) -> None:
    """The guardian had kept standard error open: `pirate-run … 2>&1 | head` hung with it."""
    guardian = _driven(bench, runner)
    streams = [str(Path(f"/proc/{guardian}/fd/{number}").readlink()) for number in (0, 1, 2)]

    assert streams == ["/dev/null"] * 3
    ours = {str(each.readlink()) for each in Path(f"/proc/{runner.pid}/fd").iterdir()}
    theirs = {str(each.readlink()) for each in Path(f"/proc/{guardian}/fd").iterdir()}
    assert not {each for each in ours & theirs if each.startswith("pipe:")}
    _end(runner)
    assert _gone(guardian)


def test_a_guardian_that_hangs_until_the_pipe_to_it_is_full_is_not_left_behind(
    bench: Bench,
) -> None:
    """It was taken for one that had gone; it would have had the port as soon as it woke."""
    port = _opened(bench, INSTRUCTIONS)
    hung = _guardian_of(port)
    os.kill(hung, signal.SIGSTOP)
    with pytest.raises(PortLostError, match="did not answer"):
        _write_on(port)

    assert _gone(hung)
    port.close(stopped=True)


def _write_on(port: GuardedPort) -> None:
    """More has been written than the pipe to the guardian takes."""
    for _ in range(1000):
        port.write(bytes(4096))


def test_a_guardian_that_does_not_answer_has_not_opened_the_port(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(guarded_port, "_STARTS_WITHIN_S", 0.0)  # no process starts so quickly

    with pytest.raises(BackendError, match="the guardian of the serial port does not answer"):
        GuardedPort(bench.name, 57600, PATIENT).open()


def test_whoever_writes_to_a_guardian_that_has_died_is_told_so(bench: Bench) -> None:
    port = _opened(bench, PATIENT)
    os.kill(_guardian_of(port), signal.SIGKILL)
    assert _gone(port.guardian_pid)

    with pytest.raises(PortLostError, match="guardian of the port has died"):
        port.write(DRIVE)


def test_a_test_that_fails_leaves_no_guardian_that_hangs(bench: Bench, tmp_path: Path) -> None:
    """They stayed forever; the input of the process that kills them also ends with pytest."""
    with _guardian_killer(tmp_path):
        port = _opened(bench, PATIENT)
        hung = _guardian_of(port)
        os.kill(hung, signal.SIGSTOP)
        assert not _gone(hung, 0.0)

    assert _gone(hung)
    port.close(stopped=True)
