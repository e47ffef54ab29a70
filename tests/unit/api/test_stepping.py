from __future__ import annotations

from collections.abc import Sequence
from math import inf
from pathlib import Path

import pytest

import pirate_sm
from pirate_sm.core.events import Event
from pirate_sm.robot.backends.trace import TraceBackend

from .conftest import PATROL


@pytest.fixture
def sent(monkeypatch: pytest.MonkeyPatch) -> list[tuple[float, ...]]:
    """The arrays that a trace is sent."""
    arrays: list[tuple[float, ...]] = []
    submit = TraceBackend.submit

    def noted(backend: TraceBackend, setpoint_id: int, values: tuple[float, ...]) -> None:
        arrays.append(values)
        submit(backend, setpoint_id, values)

    monkeypatch.setattr(TraceBackend, "submit", noted)
    return arrays


def drive(session: pirate_sm.Session) -> None:
    for command in ("HoldNose", "HoldTail", "GoAhead"):
        session.submit(command)
        assert session.advance()


def test_commands_are_given_one_by_one_and_awaited(patrol: pirate_sm.LoadedMission) -> None:
    with pirate_sm.session(patrol, seed=1) as session:
        drive(session)
        assert session.status is not None
        assert (session.status.name, session.status.status) == ("GoAhead", "done")
        assert session.state["Grip"] == "BothHeld"
        assert session.advance("way >= 50 mm")
        assert session.signals["way"] >= 0.05
        assert session.advance("way >= 3 m", within_s=0.5) is False

    assert session.ended is not None
    assert (session.ended.outcome, session.ended.message) == (
        "interrupted",
        "the session was closed",
    )


def test_time_passes_to_the_moment_asked_for() -> None:
    with pirate_sm.session(PATROL, "trace") as session:
        assert session.advance(3.5)
        assert session.now_s == 3.5
        assert session.advance(3.0), "it has passed already"
        assert session.now_s == 3.5


def test_why_not_says_what_the_engine_would_and_submit_refuses_with_it() -> None:
    with pirate_sm.session(PATROL, "trace") as session:
        why = session.why_not("GoAhead")
        assert why
        assert session.why_not("HoldNose") == ""
        with pytest.raises(pirate_sm.UsageError, match="GoAhead is refused") as caught:
            session.submit("GoAhead")
        assert why in str(caught.value)
        with pytest.raises(pirate_sm.UsageError, match="did you mean 'HoldNose'"):
            session.why_not("HoldNoes")


def test_a_condition_with_a_fault_is_refused_before_time_passes() -> None:
    with pirate_sm.session(PATROL, "trace") as session:
        with pytest.raises(pirate_sm.UsageError, match="wey"):
            session.advance("wey >= 50 mm")
        assert session.now_s == 0.0


def test_the_mission_can_take_over_and_be_paused(patrol: pirate_sm.LoadedMission) -> None:
    with pirate_sm.session(patrol, seed=1) as session:
        session.resume()
        assert session.advance("way >= 20 mm")
        session.pause()
        session.advance(session.now_s + 0.5)
        way_m = session.signals["way"]
        session.advance(session.now_s + 1.0)
        assert session.signals["way"] == pytest.approx(way_m, abs=0.005)
        session.resume()
        session.advance(session.now_s + 120.0, within_s=120.0)
        assert session.ended is not None
        assert session.ended.outcome == "succeeded"

    assert session.run.outcome == "succeeded"


@pytest.mark.parametrize("error", [None, ValueError("a bug of the caller"), KeyboardInterrupt()])
def test_however_the_block_is_left_the_wheels_stop(
    sent: list[tuple[float, ...]], error: BaseException | None
) -> None:
    def drive_and_leave() -> None:
        with pirate_sm.session(PATROL, "trace") as session:
            drive(session)
            wheels.extend(session._ready.engine.robot.safe_zero)
            assert any(sent[-1][slot] for slot in wheels)
            if error is not None:
                raise error

    wheels: list[int] = []
    if error is None:
        drive_and_leave()
    else:
        with pytest.raises(type(error)):
            drive_and_leave()

    assert not any(sent[-1][slot] for slot in wheels)


@pytest.mark.parametrize(
    ("error", "raised", "why"),
    [
        (
            pirate_sm.BackendError("the line is cut"),
            pirate_sm.BackendError,
            "the trace backend failed: the line is cut",
        ),
        (
            OSError("gone"),
            pirate_sm.BackendError,
            "the trace backend failed: OSError: gone",
        ),
        (KeyboardInterrupt(), KeyboardInterrupt, "interrupted by Ctrl-C"),
    ],
)
def test_a_step_that_breaks_sends_the_safe_array_and_closes(
    sent: list[tuple[float, ...]],
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    raised: type[BaseException],
    why: str,
) -> None:
    opened: list[pirate_sm.Session] = []
    closed: list[bool] = []

    def broken(backend: TraceBackend, until_s: float) -> tuple[float, Sequence[Event]]:
        raise error

    def drive_until_it_breaks() -> None:
        with pirate_sm.session(PATROL, "trace") as session:
            opened.append(session)
            drive(session)
            monkeypatch.setattr(TraceBackend, "close", lambda backend: closed.append(True))
            monkeypatch.setattr(TraceBackend, "advance", broken)
            wheels.extend(session._ready.engine.robot.safe_zero)
            session.advance(60.0)

    wheels: list[int] = []
    with pytest.raises(raised):
        drive_until_it_breaks()

    assert not any(sent[-1][slot] for slot in wheels)
    assert closed == [True]
    assert opened[0].ended is not None
    assert opened[0].ended.message == why


def test_a_session_is_recorded_and_has_tables(tmp_path: Path) -> None:
    with pirate_sm.session(PATROL, "trace", record=tmp_path / "s.mcap") as session:
        drive(session)
        assert "HoldTail" in session.run.commands["name"]

    read = pirate_sm.read(tmp_path / "s.mcap")
    assert read.commands == session.run.commands
    assert read.message == "the session was closed"


def test_a_session_that_has_not_been_entered_says_so() -> None:
    session = pirate_sm.session(PATROL, "trace")

    with pytest.raises(pirate_sm.UsageError, match="has not been entered"):
        session.submit("HoldNose")
    with session, pytest.raises(pirate_sm.UsageError, match="once"), session:
        pass


@pytest.mark.parametrize("until", [float("nan"), True, []])
def test_what_is_neither_a_time_nor_a_condition_is_refused(until: object) -> None:
    with pirate_sm.session(PATROL, "trace") as session:
        with pytest.raises(pirate_sm.UsageError, match="expected a time in s or a condition"):
            session.advance(until)  # type: ignore[arg-type]
        with pytest.raises(pirate_sm.UsageError, match="expected a time in s that comes"):
            session.advance(inf)
        with pytest.raises(pirate_sm.UsageError, match="within_s: expected a time"):
            session.advance(within_s=float("nan"))
        with pytest.raises(pirate_sm.UsageError, match="expected the name of a command"):
            session.why_not(3)  # type: ignore[arg-type]
