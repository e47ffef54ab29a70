"""Every way out of a run leads through the safe state, with its own exit code."""

from __future__ import annotations

import json
import signal
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from representative import thorough_but

from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.trace import TraceBackend
from pirate_sm.running.runtime.ending import BY_SIGNAL

from .conftest import NEWT

Start = Callable[..., subprocess.Popen[str]]

DRIVES = (NEWT / "patrol.yaml", "--backend", "trace", "--fire", "within", "--speed", "15")
"""A run that drives and then waits for 30 s, two seconds of the wall's time."""


def read_until_it_drives(process: subprocess.Popen[str]) -> list[dict[str, Any]]:
    lines = []
    assert process.stdout is not None
    for text in process.stdout:
        lines.append(json.loads(text))
        if lines[-1].get("status") == "waiting":
            return lines
    raise AssertionError("it never drove")


def wheels(line: dict[str, Any]) -> list[float]:
    return [line["values"][index] for index in (0, 3, 5, 6)]


def clamps(line: dict[str, Any]) -> list[float]:
    return [line["values"][index] for index in (2, 4)]


USUAL = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}


@pytest.mark.parametrize("number", thorough_but(USUAL, BY_SIGNAL))
def test_a_signal_stops_the_wheels_and_holds_the_clamps(start: Start, number: int) -> None:
    process = start(*DRIVES, "--json")
    before = read_until_it_drives(process)
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    after = [json.loads(text) for text in out.splitlines()]

    driving = [line for line in before if line["type"] == "setpoints"][-1]
    safe = [line for line in after if line["type"] == "setpoints"][-1]
    assert all(wheels(driving))
    assert wheels(safe) == [0, 0, 0, 0]
    assert clamps(safe) == clamps(driving)
    assert after[-1]["type"] == "end"
    assert after[-1]["outcome"] == "interrupted"
    assert process.returncode == 128 + number
    assert err == ""


@pytest.mark.parametrize("signals", thorough_but([1], [1, 2]))
def test_the_last_line_says_in_what_state_the_robot_is_left(start: Start, signals: int) -> None:
    process = start(*DRIVES, "--plain")
    assert process.stdout is not None
    for text in process.stdout:
        if "waits " in text:
            break
    for _ in range(signals):
        process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)

    end, left = out.splitlines()[-2:]
    assert "stopped after" in end
    assert end.count("interrupted") == 1
    # A second signal may come before the robot has confirmed that its wheels stand.
    confirmed = left.replace(", NOT confirmed by the robot", "") if signals == 2 else left
    assert "wheels set to zero; nose clamped (without sensors); tail clamped" in confirmed


def test_a_quiet_run_that_failed_says_how_it_ended_and_in_what_state_the_robot_is_left(
    pirate_run: Any,
) -> None:
    ways = ("--backend", "trace", "--quiet", "--no-record")
    failed = pirate_run(NEWT / "patrol.yaml", *ways, "--fire", "within")
    succeeded = pirate_run(NEWT / "patrol.yaml", *ways)

    ended, left = failed.stdout.splitlines()
    assert ended.startswith("patrol: failed after")
    assert left.startswith("patrol: wheels set to zero; nose clamped")
    assert succeeded.stdout.count("\n") == 1


def test_two_signals_end_it_as_well(start: Start) -> None:
    process = start(*DRIVES, "--json")
    read_until_it_drives(process)
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=60)
    after = [json.loads(text) for text in out.splitlines()]

    assert wheels([line for line in after if line["type"] == "setpoints"][-1]) == [0, 0, 0, 0]
    assert after[-1]["outcome"] == "interrupted"
    assert (process.returncode, err) == (130, "")


@pytest.mark.parametrize("form", [(), pytest.param(("--json",), marks=pytest.mark.thorough)])
def test_a_closed_pipe_behind_the_output_stops_the_mission(
    start: Start, form: tuple[str, ...]
) -> None:
    process = start(*DRIVES, *form)
    assert process.stdout is not None
    for text in process.stdout:
        if "waits " in text or '"waiting"' in text:
            break
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=60)

    assert process.returncode == 141
    assert "stopped safely" in err
    assert "Traceback" not in err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize(
    ("form", "said"),
    thorough_but(
        [((), "nothing has moved")],
        [((), "nothing has moved"), (("--quiet",), "the mission succeeded")],
    ),
)
def test_an_output_that_cannot_be_written_is_reported(
    start: Start, form: tuple[str, ...], said: str
) -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        process = start(*DRIVES[:3], *form, stdout=full)
        _, err = process.communicate(timeout=60)

    assert process.returncode == 141
    assert said in err
    assert "Traceback" not in err


class Sabotage:
    """Lets the trace backend, or the engine, break when the robot drives."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self._patch = monkeypatch
        self.arrays: list[tuple[float, ...]] = []
        self.closed = False
        submit = TraceBackend.submit
        close = TraceBackend.close

        def noted_submit(backend: TraceBackend, number: int, values: tuple[float, ...]) -> None:
            self.arrays.append(values)
            submit(backend, number, values)

        def noted_close(backend: TraceBackend) -> None:
            self.closed = True
            close(backend)

        monkeypatch.setattr(TraceBackend, "submit", noted_submit)
        monkeypatch.setattr(TraceBackend, "close", noted_close)

    def breaks(self, where: type, method: str, error: BaseException) -> None:
        kept = getattr(where, method)

        def broken(*arguments: Any) -> Any:
            if self.arrays and all(self.arrays[-1][index] for index in (0, 3, 5, 6)):
                raise error
            return kept(*arguments)

        self._patch.setattr(where, method, broken)

    def ended_safely(self) -> bool:
        last: Sequence[float] = self.arrays[-1]
        return self.closed and not any(last[i] for i in (0, 3, 5, 6)) and last[2] != 0


@pytest.fixture
def sabotage(monkeypatch: pytest.MonkeyPatch) -> Sabotage:
    return Sabotage(monkeypatch)


@pytest.mark.parametrize("error", [BackendError("the cable is out"), OSError(5, "I/O error")])
def test_a_backend_that_breaks_is_code_3(pirate_run: Any, sabotage: Any, error: Exception) -> None:
    sabotage.breaks(TraceBackend, "advance", error)

    result = pirate_run(*DRIVES[:3], "--quiet")

    assert result.exit_code == 3
    assert "fault after" in result.stdout
    assert "the trace backend failed" in result.stdout
    assert result.stderr == ""
    assert sabotage.ended_safely()


def test_a_fault_of_ours_is_code_4_with_one_line(pirate_run: Any, sabotage: Any) -> None:
    sabotage.breaks(Engine, "step", ZeroDivisionError("oops"))

    result = pirate_run(*DRIVES[:3], "--quiet")

    assert result.exit_code == 4
    assert result.stderr.count("\n") == 1
    assert "ZeroDivisionError: oops" in result.stderr
    assert "--debug" in result.stderr
    assert sabotage.ended_safely()


@pytest.mark.parametrize(
    ("where", "method", "code"), [(TraceBackend, "advance", 3), (Engine, "step", 4)]
)
def test_debug_shows_the_traceback(
    pirate_run: Any, sabotage: Any, where: type, method: str, code: int
) -> None:
    sabotage.breaks(where, method, ZeroDivisionError("oops"))

    result = pirate_run(*DRIVES[:3], "--quiet", "--debug")

    assert result.exit_code == code
    assert "Traceback" in result.stderr
    assert sabotage.ended_safely()


def test_an_exit_out_of_nowhere_leaves_the_robot_safe(pirate_run: Any, sabotage: Any) -> None:
    sabotage.breaks(TraceBackend, "advance", SystemExit(9))

    pirate_run(*DRIVES[:3], "--quiet")

    assert sabotage.ended_safely()


def test_a_mission_that_fails_is_code_1_and_one_that_succeeds_0(pirate_run: Any) -> None:
    fails = pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--fire", "within", "--quiet")
    succeeds = pirate_run(NEWT / "patrol.yaml", "--backend", "trace", "--quiet")

    assert fails.exit_code == 1
    assert fails.stdout.startswith("patrol: failed after")
    assert (succeeds.exit_code, succeeds.stderr) == (0, "")
    assert succeeds.stdout.startswith("patrol: succeeded after")
