"""A robot that is clamped already is adopted as its sensors show it, on the emulated bay."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.resume_rides import World, _Grip, prepared_on, ride_on, world
from pirate_sm.api.stepping import Session
from pirate_sm.checking.gate import CheckError
from pirate_sm.cli.commands.resume import take_over
from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import OperatorCommand
from pirate_sm.core.robot import states_of
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.detectors.registry import Detecting
from pirate_sm.running.runtime.ending import BY_SIGNAL, StopRequests
from pirate_sm.running.runtime.pump import Pump
from pirate_sm.running.wiring import Prepared
from pirate_sm.running.wiring.resume_offer import end_of_run

ADOPT = RunOptions(adopt=True)
Says = Callable[..., None]


@pytest.fixture
def clamped() -> World:
    """A bay with a robot that is clamped, and a mission that declares it straight."""
    return declaring(world("drive_on", 0))


def declaring(it: World, **states: str) -> World:
    """The mission declares these states, and otherwise the initial ones."""
    table = it.loaded.robot.table
    wanted = dict(zip(table.regions, table.configurations[table.initial], strict=True)) | states
    start = table.configurations.index(tuple(wanted.values()))
    program = replace(it.loaded.program, start_configuration=start)
    return it._replace(loaded=replace(it.loaded, program=program))


@pytest.fixture
def says(monkeypatch: pytest.MonkeyPatch) -> Says:
    """Somebody at the terminal gives these answers, and thinks before each."""

    def answering(
        prepared: Prepared, *answers: str | Callable[[], str], thinks_s: float = 1.0
    ) -> None:
        left = list(answers)

        def answered(check: Callable[[], None]) -> str:
            backend = prepared.backend
            assert isinstance(backend, SerialBackend)
            until_s = backend.port.now() + thinks_s
            while backend.port.now() < until_s:
                backend.tend()
            check()
            answer = left.pop(0)
            return answer if isinstance(answer, str) else answer()

        monkeypatch.setattr("pirate_sm.cli.commands.resume.answered_line", answered)
        for stream in (sys.stdin, sys.stderr):
            monkeypatch.setattr(stream, "isatty", lambda: True)

    return answering


def states(prepared: Prepared) -> tuple[str, ...]:
    program = prepared.loaded.program
    return prepared.loaded.robot.table.configurations[program.start_configuration]


def sent(it: World) -> bool:
    return it.bay.last_array is not None


def test_belief_a_robot_that_is_clamped_already_is_adopted_and_obeys(clamped: World) -> None:
    """It was `start.contradicted`, three times in the console, and every command was refused."""
    prepared, begun = take_over(prepared_on(clamped, clamped.port), ADOPT, StopRequests())
    assert begun is not None
    assert begun.body is not None
    assert states(prepared)[:3] == ("Fixed", "Fixed", "DoubleClamped")
    held = clamped.bay.last_applied
    assert held is not None
    wheels = clamped.loaded.robot.safe_zero
    assert not any(held.counts[slot] for slot in wheels), "wheels stand"
    assert sum(count != 0 for count in held.counts) >= 4, "held parts keep their duties"

    pump = Pump(prepared.engine, prepared.backend, companions=prepared.companions, resuming=begun)
    pump.start(paused=True)
    assert pump.state is not None
    parts = {mark.which for mark in pump.state.robot.marks if mark.kind == "part"}
    assert parts == {0, 1}, "nothing is confirmed before the sensors show it"
    while pump.now_s < 4.0:
        pump.take(*pump.wait(4.0))
    assert not [mark for mark in pump.state.robot.marks if mark.kind == "part"]
    pump.give(OperatorCommand("RelaxRear"))
    while pump.now_s < 6.0:
        pump.take(*pump.wait(6.0))

    assert pump.ended is None
    assert "FrontClampedRearRelaxed" in states_of(prepared.loaded.robot, pump.state.robot)


def test_a_session_adopts_a_robot_that_is_clamped_already(clamped: World) -> None:
    with Session(prepared_on(clamped, clamped.port), adopt=True) as session:
        assert session.state["BendingState"] == "DoubleClamped"
        session.submit("RelaxRear")
        assert session.advance()
        assert session.state["BendingState"] == "FrontClampedRearRelaxed"
        assert session.ended is None


def test_an_adopted_robot_runs_its_mission_without_a_let_go_and_its_recording_replays(
    clamped: World, tmp_path: Path
) -> None:
    prepared, begun = take_over(prepared_on(clamped, clamped.port), ADOPT, StopRequests())
    grip = _Grip(clamped.loaded, clamped.bay)
    path = tmp_path / "adopted.mcap"
    trace, _ = ride_on(prepared, grip, 5.0, path, begun)

    assert grip.loose == frozenset()
    assert end_of_run(path).last.robot.configuration >= 0  # its replay is compared
    assert trace.configurations


def test_a_robot_that_is_as_declared_is_not_asked_about_and_nothing_is_sent() -> None:
    it = world("prepare_bend", 0)
    prepared, begun = take_over(prepared_on(it, it.port), ADOPT, StopRequests())
    assert begun is not None
    assert begun.body is None
    assert not sent(it)

    trace, _ = ride_on(prepared, _Grip(it.loaded, it.bay), resuming=begun)

    assert trace.outcome == "succeeded"


def test_nobody_is_asked_where_nobody_can_be(clamped: World) -> None:
    prepared = prepared_on(clamped, clamped.port)

    assert take_over(prepared, RunOptions(), StopRequests()) == (prepared, None)


def test_a_person_adopts_after_having_looked_again(
    clamped: World, says: Says, capsys: pytest.CaptureFixture[str]
) -> None:
    prepared = prepared_on(clamped, clamped.port)
    says(prepared, "l", "1", thinks_s=20.0)
    found, begun = take_over(prepared, ConsoleOptions(), StopRequests())
    shown = capsys.readouterr().out

    assert begun is not None
    assert begun.body is not None
    assert states(found)[2] == "DoubleClamped"
    assert shown.count("the robot does not stand as declared: the front part bears") == 2
    assert "confirmed    rear holds" in shown
    assert "recorded" not in shown


def test_a_person_leaves_the_robot_as_it_is(clamped: World, says: Says) -> None:
    prepared = prepared_on(clamped, clamped.port)
    says(prepared, "")

    with pytest.raises(UsageError, match="left as it is: nothing has moved"):
        take_over(prepared, ConsoleOptions(), StopRequests())
    assert not sent(clamped)
    with pytest.raises(Exception, match="closed"):
        prepared.backend.advance(9.0)


def test_a_request_to_stop_ends_the_question(clamped: World, says: Says) -> None:
    prepared, requests = prepared_on(clamped, clamped.port), StopRequests()
    says(prepared, "1")
    requests.ask(BY_SIGNAL[2])

    with pytest.raises(Exception, match="Ctrl-C") as stopped:
        take_over(prepared, ConsoleOptions(), requests)
    assert getattr(stopped.value, "exit_code", None) == 130
    assert not sent(clamped)


def test_what_no_sensor_can_tell_apart_is_left_to_a_person(
    says: Says, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = declaring(
        world("drive_on", 0), BendingState="FrontClampedRearRelaxed", FrontWheelsState="Fixed"
    )
    monkeypatch.setattr("benchmarks.resume_rides.loaded_mission", lambda name: shown.loaded)
    it = declaring(world("drive_on", 0))

    with pytest.raises(UsageError, match="--adopt is not enough: the sensors cannot tell apart"):
        take_over(prepared_on(it, it.port), ADOPT, StopRequests())
    session = Session(prepared_on(it, it.port.next_port()), adopt=True)
    with pytest.raises(UsageError, match="cannot be adopted: the sensors cannot tell"), session:
        pass
    assert not sent(it)
    prepared = prepared_on(it, it.port.next_port())
    says(prepared, "1")
    found, begun = take_over(prepared, ConsoleOptions(), StopRequests())

    assert begun is not None
    assert begun.body is not None
    held = {it.loaded.robot.parts[part] for part in it.loaded.robot.held[begun.body.configuration]}
    assert held == {"front"}, "its rear part is slack"
    assert "DoubleClamped" not in states(found)


def test_a_robot_that_has_let_go_while_somebody_thought_is_not_adopted_as_clamped(
    clamped: World, says: Says, capsys: pytest.CaptureFixture[str]
) -> None:
    prepared = prepared_on(clamped, clamped.port)

    def taken_out() -> str:
        for joint in clamped.loaded.loaded_robot.profile.body.joints:
            clamped.bay.robot.electronics.shift(joint.torque or "", 1e6)
        return "1"

    says(prepared, taken_out)
    found, begun = take_over(prepared, ConsoleOptions(), StopRequests())

    assert found is prepared
    assert begun is not None
    assert begun.body is None
    assert not sent(clamped)


def test_a_robot_whose_wheels_turn_is_not_adopted(
    clamped: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The engine stops them, and refuses the start."""
    monkeypatch.setattr("pirate_sm.core._engine.resuming.reconciling.turning", lambda *_: True)
    _, begun = take_over(prepared_on(clamped, clamped.port), ADOPT, StopRequests())

    assert begun is not None
    assert begun.body is None


def test_belief_an_adopted_robot_is_where_somebody_says(clamped: World, says: Says) -> None:
    """Its detector would have counted from the beginning of the pipe."""
    prepared = prepared_on(clamped, clamped.port)
    counting = replace(
        prepared,
        usual_detector="odometry",
        detecting=Detecting("odometry", prepared.companions[1:2]),
    )
    with pytest.raises(UsageError, match="where the detector odometry counts from"):
        take_over(counting, ADOPT, StopRequests())

    counting = replace(counting, backend=prepared_on(clamped, clamped.port.next_port()).backend)
    says(counting, "1", "", "1", "99 m", "1", "0.60 m")
    found, begun = take_over(counting, ConsoleOptions(), StopRequests())

    assert begun is not None
    assert begun.body is not None
    assert found.order.start_at_m == 0.6
    assert "600 mm" in found.notices[-1]


def test_a_mission_that_cannot_run_from_there_is_refused_before_anything_is_asked_or_sent(
    says: Says, capsys: pytest.CaptureFixture[str]
) -> None:
    it, clamped = world("mitre_bend", 0), world("drive_on", 0)
    it = it._replace(bay=clamped.bay, port=clamped.port)  # its first step clamps

    prepared = prepared_on(it, it.port)
    prepared = replace(prepared, order=replace(prepared.order, check=True))
    says(prepared)  # whatever was asked would have no answer
    with pytest.raises(CheckError, match="ClampFront is refused as unneeded"):
        take_over(prepared, RunOptions(), StopRequests())
    assert not sent(it)
    shown = capsys.readouterr().err
    advice = "`pirate console` with the same options shows at which phases it can (h)"
    assert f"it cannot begin there; {advice}" in shown
    assert "adopt it so" not in shown
