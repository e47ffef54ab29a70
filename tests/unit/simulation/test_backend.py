from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core._model.pipe import Blockage, Start
from pirate_sm.core._model.pipe_runs import Mitre
from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.core.events import Event, FaultReport, SensorFrame, SubmitResult
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Defect, Pipe, Profile, Straight
from pirate_sm.simulation.backend import SimulatorBackend
from pirate_sm.simulation.surroundings import Jitter

ROOT = Path(__file__).resolve().parents[3]
CYCLE_S = 0.016


@pytest.fixture(scope="session")
def profile() -> Profile:
    return load_robot(ROOT / "hardware_profiles" / "pirate_ii").profile


@pytest.fixture(scope="session")
def small_profile() -> Profile:
    return load_robot(ROOT / "tests" / "robots" / "newt").profile


def pipe(**more: Any) -> Pipe:
    segments = (Straight(straight=1.0), Mitre(mitre=math.pi / 2), Straight(straight=1.0))
    return Pipe(**({"diameter": 0.12, "segments": segments, "start": Start(at=0.7)} | more))


def values(profile: Profile, *, clamp: float = 0.0, drive: float = 0.0) -> tuple[float, ...]:
    """Duties that clamp with all joints and drive with all wheels."""
    found = []
    for slot in profile.slots:
        duty = 0.0
        if slot.joint:
            joints = [joint.name for joint in profile.body.joints]
            duty = clamp if joints.index(slot.joint) % 2 else -clamp
        elif slot.wheel:
            wheel = next(w for w in profile.body.wheels if w.name == slot.wheel)
            duty = drive * wheel.direction
        found.append(duty)
    return tuple(found)


def pass_time(backend: SimulatorBackend, until_s: float) -> list[tuple[float, Event]]:
    found: list[tuple[float, Event]] = []
    now = 0.0
    while now < until_s:
        now, events = backend.advance(until_s)
        found += [(now, event) for event in events]
    return found


def of(kind: type, found: list[tuple[float, Event]]) -> list[Any]:
    return [event for _, event in found if isinstance(event, kind)]


def test_boards_report_in_turn_one_in_a_cycle(profile: Profile) -> None:
    backend = SimulatorBackend(profile, pipe())
    opened = backend.open()
    boards = [event.board for event in opened if isinstance(event, SensorFrame)]
    channels = {board.id: len(board.channels) for board in profile.boards}
    frames = of(SensorFrame, pass_time(backend, 2 * len(boards) * CYCLE_S + 1e-9))
    order = [frame.board for frame in frames]
    assert sorted(order[: len(boards)]) == sorted(boards)
    assert order[: len(boards)] == order[len(boards) :]
    assert all(len(frame.values) == channels[frame.board] for frame in frames)


def test_values_that_come_one_a_cycle_are_told_when_a_board_is_complete(profile: Profile) -> None:
    link = profile.link.model_copy(update={"state_message": "value"})
    backend = SimulatorBackend(profile.model_copy(update={"link": link}), pipe())
    count = sum(len(e.values) for e in backend.open() if isinstance(e, SensorFrame))
    frames = of(SensorFrame, pass_time(backend, count * CYCLE_S + 1e-9))
    assert len(frames) == len({frame.board for frame in frames})
    assert {frame.board for frame in frames} == {
        board.id for board in profile.boards if board.fitted and board.channels_fitted
    }


def test_an_array_is_accepted_after_the_echo_delay(profile: Profile) -> None:
    backend = SimulatorBackend(profile, pipe())
    backend.open()
    backend.advance(0.1)
    pass_time(backend, 0.1)
    backend.submit(7, values(profile))
    found = pass_time(backend, 0.3)
    results = [(at, event) for at, event in found if isinstance(event, SubmitResult)]
    assert results == [(pytest.approx(0.1 + profile.link.echo_delay), SubmitResult(7, "accepted"))]


@pytest.mark.parametrize(
    ("fates", "accepted_after"),
    [
        ([(False, False), (True, True)], 3),  # lost; the copy's echo comes
        ([(True, False), (True, True)], 3),  # its echo is lost
        ([(False, False), (True, False)], None),
        ([(False, False), (False, False)], None),
    ],
)
def test_an_array_whose_echo_is_overdue_is_written_again(
    profile: Profile,
    fates: list[tuple[bool, bool]],
    accepted_after: int | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As the driver of a real robot does; the copy is written after two delays of the echo."""
    link = profile.link
    backend = SimulatorBackend(profile, pipe(), start_values=values(profile, clamp=0.6))
    left = iter(fates)
    monkeypatch.setattr(backend.robot, "delivery", lambda now_s: next(left))
    backend.open()

    backend.submit(7, values(profile, clamp=0.6, drive=1.0))
    found = pass_time(backend, 2.0)

    results = [(at, event) for at, event in found if isinstance(event, SubmitResult)]
    if accepted_after is not None:
        expected = accepted_after * link.echo_delay, SubmitResult(7, "accepted")
    else:
        expected = link.resend_after, SubmitResult(7, "unknown", "no echo came")
    assert results == [(pytest.approx(expected[0]), expected[1])]
    assert next(left, None) is None
    assert (backend.truth.distance_m > 0.01) == any(arrives for arrives, _ in fates)


def test_an_array_that_is_overdue_is_not_written_after_a_newer_one(
    profile: Profile, monkeypatch: pytest.MonkeyPatch
) -> None:
    fates = iter([(False, False), (True, True)])
    backend = SimulatorBackend(profile, pipe(), start_values=values(profile, clamp=0.6))
    monkeypatch.setattr(backend.robot, "delivery", lambda now_s: next(fates))
    backend.open()

    backend.submit(1, values(profile, clamp=0.6, drive=1.0))
    pass_time(backend, profile.link.echo_delay)
    backend.submit(2, values(profile, clamp=0.6))
    results = of(SubmitResult, pass_time(backend, 2.0))

    assert [(r.setpoint_id, r.status) for r in results] == [(2, "accepted"), (1, "unknown")]
    assert backend.truth.distance_m == pytest.approx(0.0, abs=1e-3)


def test_a_newer_array_supersedes_one_that_has_not_been_sent(profile: Profile) -> None:
    backend = SimulatorBackend(profile, pipe())
    backend.open()
    backend.submit(1, values(profile, drive=1.0))
    backend.submit(2, values(profile))
    backend.submit(2, values(profile))
    results = of(SubmitResult, pass_time(backend, 0.3))
    assert sorted((r.setpoint_id, r.status) for r in results) == [
        (1, "superseded"),
        (2, "accepted"),
        (2, "superseded"),
    ]
    assert backend.truth.distance_m == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("wrong", [2.0, math.nan, -1.2])
def test_an_array_out_of_range_is_rejected_and_changes_nothing(
    profile: Profile, wrong: float
) -> None:
    backend = SimulatorBackend(profile, pipe())
    backend.open()
    slot = next(i for i, slot in enumerate(profile.slots) if slot.wheel)
    bad = list(values(profile))
    bad[slot] = wrong
    backend.submit(1, tuple(bad))
    backend.submit(2, (0.0,))
    results = of(SubmitResult, pass_time(backend, 0.1))
    assert [result.status for result in results] == ["rejected", "rejected"]
    assert f"slot {slot}" in results[0].reason


def test_it_drives_to_the_bend(profile: Profile) -> None:
    backend = SimulatorBackend(profile, pipe(), start_values=values(profile, clamp=0.6))
    backend.open()
    backend.submit(1, values(profile, clamp=0.6, drive=1.0))
    pass_time(backend, 4.0)
    assert backend.truth.distance_m > 0.2
    assert backend.robot.arcs_m == list(backend.truth.arcs_m)
    assert backend.robot.arcs_m[0] > backend.robot.bends[0].crossing_m
    assert len(backend.truth.wheels) == len(profile.body.wheels)
    assert any(backend.truth.touching)


def test_a_blocked_pipe_stops_it(profile: Profile) -> None:
    blocked = pipe(blockages=(Blockage.model_validate({"at": 0.8, "lasting": 60.0}),))
    backend = SimulatorBackend(profile, blocked, start_values=values(profile, clamp=0.6))
    backend.open()
    backend.submit(1, values(profile, clamp=0.6, drive=1.0))
    pass_time(backend, 4.0)
    assert max(backend.truth.arcs_m) < 0.8


def test_a_pipe_rolled_against_the_robot_has_impassable_bends(profile: Profile) -> None:
    backend = SimulatorBackend(
        profile, pipe(roll=math.pi / 2), start_values=values(profile, clamp=0.6)
    )
    backend.open()
    backend.submit(1, values(profile, clamp=0.6, drive=1.0))
    faults = of(FaultReport, pass_time(backend, 5.0))
    assert [fault.code for fault in faults] == ["pipe.impassable"]


def test_equal_seeds_give_equal_runs(profile: Profile) -> None:
    def run(seed: int) -> list[tuple[float, str]]:
        jitter = Jitter(0.02, 0.2, 0.002)
        backend = SimulatorBackend(profile, pipe(), seed=seed, jitter=jitter)
        events = [(0.0, repr(event)) for event in backend.open()]
        backend.submit(1, values(profile, clamp=0.6, drive=1.0))
        return events + [(at, repr(event)) for at, event in pass_time(backend, 3.0)]

    assert run(3) == run(3)
    assert run(3) != run(4)


def with_defect(profile: Profile, **numbers: Any) -> Profile:
    defects = {"it": Defect(description="", **numbers)}
    simulation = profile.simulation.model_copy(update={"defects": defects})
    return profile.model_copy(update={"simulation": simulation})


def test_a_lost_array_is_unknown_in_the_end(profile: Profile) -> None:
    broken = with_defect(profile, kind="lost_messages", share=0.5)
    backend = SimulatorBackend(broken, pipe(), defects=["it"])
    backend.open()
    now = 0.0
    for number in range(20):
        backend.submit(number, values(profile))
        while now < 0.5 * (number + 1):
            now, events = backend.advance(0.5 * (number + 1))
            for event in events:
                if isinstance(event, SubmitResult):
                    assert event.setpoint_id == number
                    if event.status == "unknown":
                        return
    pytest.fail("nothing was lost")


def test_while_a_controller_starts_again_motors_go_on_and_then_stop(profile: Profile) -> None:
    def driven_m(**defect: Any) -> tuple[float, list[FaultReport]]:
        broken = with_defect(profile, kind="controller_reset", **defect)
        clamped = values(profile, clamp=0.6)
        straight = pipe(segments=(Straight(straight=3.0),))
        backend = SimulatorBackend(broken, straight, defects=["it"], start_values=clamped)
        backend.open()
        backend.submit(1, values(profile, clamp=0.6, drive=0.5))
        faults = of(FaultReport, pass_time(backend, 4.0))
        return backend.truth.distance_m, faults

    at_once, faults = driven_m(after=2.0)
    assert [fault.code for fault in faults] == ["firmware.reset"]
    whole, _ = driven_m(after=60.0)
    assert at_once == pytest.approx(whole / 2, rel=0.05)
    # Mission time stands still while it is set up, but the robot does not.
    late, _ = driven_m(after=2.0, lasting=1.0)
    assert late == pytest.approx(whole * 0.75, rel=0.05)


def test_a_silent_robot_does_not_hang_an_endless_wait(profile: Profile) -> None:
    backend = SimulatorBackend(with_defect(profile, kind="silent_bay"), pipe(), defects=["it"])
    backend.open()
    times = [backend.advance(math.inf)[0] for _ in range(3)]
    assert times == sorted(times)
    assert times[-1] < 10.0


def test_it_takes_nothing_once_closed_but_what_was_sent_last(profile: Profile) -> None:
    backend = SimulatorBackend(profile, pipe())
    backend.open()
    backend.submit(1, values(profile))
    backend.close()
    backend.close()
    with pytest.raises(BackendError):
        backend.submit(2, values(profile))


def test_a_start_in_a_bend_is_refused(profile: Profile) -> None:
    with pytest.raises(UsageError, match="does not fit"):
        SimulatorBackend(profile, pipe(start=Start(at=1.1)))


def test_another_robot_runs_from_its_profile_alone(small_profile: Profile) -> None:
    straight = Pipe(diameter=0.09, segments=(Straight(straight=2.0),))
    backend = SimulatorBackend(small_profile, straight)
    frames = [event for event in backend.open() if isinstance(event, SensorFrame)]
    assert [frame.board for frame in frames] == [board.id for board in small_profile.boards]
    backend.submit(1, values(small_profile, clamp=0.6))
    pass_time(backend, 5.0)
    assert all(backend.truth.touching)
