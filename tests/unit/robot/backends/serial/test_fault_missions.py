"""Every fault of the link and of sensors, in missions against the emulated bay in virtual time.

Each is switched on in the bay; what is looked at is the end that a person reads, and where the
bay's motors are then.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import pytest
from representative import thorough_but

from pirate_sm.core.effects import Effect, Fault, Log
from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import BackendError
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.models import Defect
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.frames import SerialFrame
from pirate_sm.robot.rosserial.messages import Array
from pirate_sm.running.runtime.backend_links import Messenger
from pirate_sm.running.runtime.ending import Result
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

from .conftest import without_refresh

SAFE = "it has confirmed that the safe setpoints have arrived"

LOSSY = {"loss_in": 0.2, "loss_out": 0.2, "corruption": 0.01}

DRIVING = """
format: 1
mission: driving
robot: pirate_ii
pipe: {diameter: 120 mm, segments: [{straight: 3 m}], start: {at: 500 mm}}
on_fault: [{fault: [HANDLED], then: continue}]
start: drive
phases:
  drive:
    do: [ClampFront, COMMANDS]
    wait: [{when: odometry >= FAR, go: there}]
    within: {time: LONGEST, go: late}
ends:
  there: {succeed: There}
  late: {fail: Too late}
"""


@dataclass
class Course:
    """One mission and what came of it."""

    result: Result
    faults: list[Fault]
    logs: list[str]
    bay: VirtualBay
    loaded: LoadedMission
    port: VirtualPort

    @property
    def message(self) -> str:
        return self.result.ended.message

    @property
    def codes(self) -> list[str]:
        return [fault.code for fault in self.faults]

    @property
    def is_safe(self) -> bool:
        """Wheels stand still and both parts hold on, by the bay's own motors."""
        slots = self.loaded.loaded_robot.profile.slots
        joints = {slot.name for slot in slots if slot.joint is not None}
        return joints <= self.driven() and not self.wheels_driven()

    def driven(self, before_s: float = inf) -> set[str]:
        """Slots that are not zero by the bay's own motors, at the end or just before a moment."""
        slots = self.loaded.loaded_robot.profile.slots
        counts = [
            record.counts
            for record in self.bay.records
            if record.event in {"applied", "tripped"} and record.at_s < before_s
        ][-1]
        return {slot.name for slot, count in zip(slots, counts, strict=True) if count}

    def wheels_driven(self, before_s: float = inf) -> set[str]:
        """Wheels among them."""
        slots = self.loaded.loaded_robot.profile.slots
        return self.driven(before_s) & {slot.name for slot in slots if slot.wheel is not None}


class Watching:
    """Keeps the faults, or breaks as soon as anything is said."""

    def __init__(self, breaks: bool) -> None:
        self.breaks = breaks
        self.faults: list[Fault] = []
        self.logs: list[str] = []

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        self.faults += [effect for effect in effects if isinstance(effect, Fault)]
        self.logs += [effect.message for effect in effects if isinstance(effect, Log)]
        if self.breaks and self.logs:
            raise RuntimeError("broken")


class ActingPort(VirtualPort):
    """A port whose cable is pulled and put in again at given times, perhaps into another robot."""

    def __init__(
        self,
        bay: VirtualBay,
        plan: LinkPlan,
        pulled: tuple[float, float],
        other: VirtualBay | None,
    ) -> None:
        super().__init__(bay, plan.serial.heartbeat_within, plan.wanted)
        self._pulled = pulled
        self._other = other

    def now(self) -> float:
        now = super().now()
        out, back = self._pulled
        self.plugged = not out <= now < back
        if now >= back and self._other is not None:
            self.device = self._other
        return now


Go = Callable[..., Course]


@pytest.fixture
def go(tmp_path: Path) -> Go:
    def run(
        *,
        commands: str = "ClampRear, DriveForward",
        handled: str = "robot.stuck, clamp.lost",
        far: str = "0.6 m",
        longest: str = "60 s",
        extra: Defect | None = None,
        pulled: tuple[float, float] = (1e9, 1e9),
        other: bool = False,
        wrong_echo_s: float = inf,
        text: str = DRIVING,
        breaks: bool = False,
        seed: int = 3,
        refreshed: bool = True,
        **switches: Any,
    ) -> Course:
        file = tmp_path / "driving.yaml"
        text = text.replace("HANDLED", handled).replace("FAR", far).replace("LONGEST", longest)
        file.write_text(text.replace("COMMANDS", commands))
        loaded = load_mission(file)
        robot = loaded.loaded_robot
        profile = robot.profile
        if extra is not None:
            defects = {**profile.simulation.defects, "extra": extra}
            simulation = profile.simulation.model_copy(update={"defects": defects})
            profile = profile.model_copy(update={"simulation": simulation})
            switches["defects"] = (*switches.get("defects", ()), "extra")
        texts = message_texts(robot.folder, profile)
        assert loaded.pipe is not None
        switches.setdefault("dead_man", refreshed)
        bay, another = (
            VirtualBay(profile, loaded.pipe, texts, Switches(**switches), seed) for _ in range(2)
        )
        plan = read_plan(robot.folder, robot.profile, loaded.robot)
        if not refreshed:  # a refresh ends what moves by itself before it is a fault
            plan = without_refresh(plan)
        port = ActingPort(bay, plan, pulled, another if other else None)
        off_by_one(bay, port, wrong_echo_s)
        watching = Watching(breaks)
        engine = Engine(loaded.robot, loaded.program, nominal=False)
        backend = SerialBackend(plan, port)
        companions = [Messenger(backend.remark)]
        run = MissionRun(engine, backend, observers=[watching], companions=companions)
        return Course(run.execute(), watching.faults, watching.logs, bay, loaded, port)

    return run


def test_nothing_wrong_is_no_fault(go: Go) -> None:
    course = go()

    assert (course.message, course.codes) == ("There", [])
    assert course.is_safe


def test_a_reset_ends_a_mission_that_does_not_handle_it_in_the_safe_state(go: Go) -> None:
    course = go(reset_at_s=(21.0,))

    assert course.result.ended.outcome == "fault"
    assert course.message.startswith("firmware.reset: the robot's controller said nothing for 1.")
    assert course.message.endswith(f" s, it was reset or hung: {SAFE}")
    assert course.is_safe


def test_a_mission_that_handles_a_reset_goes_on_where_it_was(go: Go) -> None:
    course = go(reset_at_s=(21.0,), handled="firmware.reset")

    assert (course.message, course.codes) == ("There", ["firmware.reset"])
    assert course.logs == [
        "no data comes from the robot, which may continue its motion; without any, the link is "
        "given up after 8 s",
        "paused: wheels stopped, deadlines frozen",
        "resumed",
    ]
    assert course.is_safe


@pytest.mark.parametrize("seed", thorough_but([1], [1, 2, 3]))
def test_a_reset_on_a_lossy_line_while_wheels_are_driven_ends_with_stopped_wheels(
    go: Go, seed: int
) -> None:
    course = go(reset_at_s=(26.0,), seed=seed, **LOSSY)

    assert course.wheels_driven(before_s=26.0)
    assert course.message.startswith("firmware.reset: ")
    assert course.is_safe


def test_a_reset_on_a_lossy_line_before_the_rear_is_clamped_ends_with_the_front_clamped(
    go: Go,
) -> None:
    course = go(reset_at_s=(9.0,), **LOSSY)

    assert course.message.startswith("firmware.reset: ")
    assert course.driven() == course.driven(before_s=9.0) == {"bend_1", "bend_2"}


@pytest.mark.thorough
def test_a_reset_while_the_mission_ends_is_waited_for(go: Go) -> None:
    whole = go()
    stopped_s = max(r.at_s for r in whole.bay.records if r.event == "received")
    course = go(reset_at_s=(stopped_s - 0.001,))

    assert course.message == "There"
    assert course.is_safe


# Nothing is heard in the last 0.1 s, while the port is closed, and what was sent before the reset
# may still arrive: later resets than these cannot be noticed.
@pytest.mark.thorough
@pytest.mark.parametrize(
    "line", [{}, pytest.param(LOSSY, marks=pytest.mark.thorough)], ids=["clean", "lossy"]
)
def test_a_reset_just_before_the_port_is_closed_is_noticed(go: Go, line: dict[str, Any]) -> None:
    closed_s = max(r.at_s for r in go(far="0.1 m", **line).bay.records if r.event == "closed")

    for before_s in (0.12, 0.15, 0.2, 0.3, 0.4, 0.5):
        course = go(far="0.1 m", reset_at_s=(closed_s - before_s,), **line)
        happened = [r.event for r in course.bay.records if r.event in {"reset", "applied"}]
        assert happened[-1] == "applied", f"nothing is in force after a reset {before_s} s before"
        assert course.is_safe, before_s


def test_firmware_that_hangs_and_goes_on_is_told_as_a_reset(go: Go) -> None:
    course = go(hang_at_s=21.0, hang_for_s=3.0)

    assert course.message.startswith("firmware.reset: the robot's controller said nothing for 3.")
    assert course.is_safe


def test_firmware_that_obeys_and_says_nothing_is_asked_anew(go: Go) -> None:
    course = go(unconfigured_at_s=(21.0,))

    assert course.message.startswith("firmware.reset: the robot's controller said nothing for 0.")
    assert course.is_safe


def test_firmware_that_hangs_for_ever_is_a_silent_link_and_the_stop_unconfirmed(go: Go) -> None:
    course = go(hang_at_s=21.0, handled="firmware.reset")

    assert course.message == (
        "link.silent: the robot's controller has been silent for 8.0 s, however often it was "
        "asked (the safe setpoints were not confirmed)"
    )
    assert course.result.exit_code == 3


@pytest.mark.parametrize(
    ("lasting_s", "ending"),
    [(3.0, "broken"), (1e9, "broken (the safe setpoints were not confirmed)")],
)
def test_even_a_broken_program_has_the_safe_state_confirmed_or_says_that_it_could_not(
    go: Go, lasting_s: float, ending: str
) -> None:
    course = go(hang_at_s=23.0, hang_for_s=lasting_s, breaks=True)

    assert course.message == f"an internal error: RuntimeError: {ending}"
    assert course.is_safe == (lasting_s == 3.0)


def test_a_robot_unplugged_and_back_is_told_with_how_long_it_was_away(go: Go) -> None:
    course = go(pulled=(21.0, 24.0))

    assert course.message.startswith("link.interrupted: the link was away for ")
    assert course.message.endswith(f"(the cable is out) and is back: {SAFE}")
    assert course.is_safe


def test_a_mission_that_handles_the_cable_goes_on(go: Go) -> None:
    course = go(pulled=(21.0, 24.0), handled="link.interrupted")

    assert (course.message, course.codes) == ("There", ["link.interrupted"])
    assert course.is_safe


SHIFT = """
format: 1
mission: shift
robot: pirate_ii
pipe: {diameter: 120 mm, segments: [{straight: 3 m}], start: {at: 500 mm}}
on_fault: [{fault: [link.interrupted, firmware.reset], HANDLED}]
start: clamp
phases:
  clamp: {do: [ClampFront, ClampRear], wait: [{after: 10 s, go: shift}]}
  shift: {do: [RelaxRear], go: done}
ends: {done: {succeed: The rear is free}}
"""


@pytest.mark.parametrize("handled", thorough_but(["go: shift"], ["go: shift", "then: continue"]))
def test_belief_in_clamps_ends_where_another_robot_answers_on_the_same_link(
    go: Go, handled: str
) -> None:
    """A straight robot succeeded with "its clamps hold as before" and a diameter of 49 mm."""
    course = go(text=SHIFT, handled=handled, pulled=(26.0, 28.0), other=True)

    assert course.codes == ["link.interrupted", "state.contradicted"]
    assert "gamma_1 of the front part shows" in course.message
    assert course.result.ended.outcome == "fault"
    assert not any("hold" in fault.message for fault in course.faults)


@pytest.mark.parametrize(
    ("handled", "out_s"),
    thorough_but(
        [("go: shift", 26.0), ("then: continue", 4.0)],
        [
            ("go: shift", 26.0),
            ("then: continue", 26.0),
            ("then: continue", 4.0),
            ("then: continue", 21.0),
        ],
    ),
)
def test_belief_returns_where_the_robot_has_held_meanwhile(
    go: Go, handled: str, out_s: float
) -> None:
    course = go(text=SHIFT, handled=handled, pulled=(out_s, out_s + 2.0))

    assert course.message == "The rear is free"
    assert course.codes == ["link.interrupted"]
    assert course.driven() == {"bend_1", "bend_2"}


@pytest.mark.parametrize("dead_man", thorough_but([False], [True, False]))
def test_belief_in_a_distance_ends_with_what_was_driven_in_a_silence(
    go: Go, dead_man: bool
) -> None:
    """Mission time stands still meanwhile: "1 m" was claimed at a true 1.5 m."""
    course = go(
        commands="ClampRear, DriveForward",
        handled="link.interrupted, robot.stuck",
        far="1 m",
        longest="60 s",
        pulled=(23.5, 26.5),
        dead_man=dead_man,
    )

    assert course.wheels_driven(before_s=23.5)
    assert course.codes == ["link.interrupted", "distance.unknown"]
    assert course.is_safe


def test_a_robot_that_stays_unplugged_is_a_lost_link(go: Go) -> None:
    course = go(pulled=(21.0, 1e9), handled="link.interrupted")

    assert course.message == (
        "link.lost: the link to the robot is lost: the cable is out, and was not back 8.0 s later "
        "(the safe setpoints were not confirmed)"
    )


@pytest.mark.parametrize("dead_man", [True, False])
def test_a_cable_out_for_longer_than_the_runner_waits_leaves_no_wheel_driven_once_it_is_back(
    go: Go, dead_man: bool
) -> None:
    """Wheels stop while the cable is out if the firmware has a dead man's switch; else after."""
    course = go(pulled=(23.5, 72.0), handled="link.interrupted", far="2 m", dead_man=dead_man)
    assert course.wheels_driven(before_s=23.5)
    assert course.message.startswith("link.lost: ")
    assert course.is_safe == dead_man
    course.port.wait(76.0)

    assert course.is_safe


def test_no_echo_within_its_budget(go: Go) -> None:
    course = go(no_echo_at_s=4.0)

    assert course.message.startswith("link.no_echo: setpoints were not confirmed after 5 repeats")
    assert course.message.endswith("(the safe setpoints were not confirmed)")


LONG_SHIFT = SHIFT.replace("10 s", "60 s")


def off_by_one(bay: VirtualBay, port: ActingPort, from_s: float) -> None:
    """From then on each echo of the bay has one value that is wrong by one count."""
    right = bay._wire.echo

    def echo(array: Array) -> SerialFrame:
        first, *others = array.counts
        wrong = array._replace(counts=(first + (port._now_s >= from_s), *others))
        return right(wrong)

    bay._wire.echo = echo  # type: ignore[method-assign]


@pytest.mark.parametrize(
    "from_s", [1.0, pytest.param(24.0, marks=pytest.mark.thorough)], ids=["clamping", "waiting"]
)
def test_belief_in_setpoints_ends_as_soon_with_a_wrong_echo_as_with_none(
    go: Go, from_s: float
) -> None:
    """An echo that was wrong by one count each time was found after 50 s, or never."""
    none = go(text=LONG_SHIFT, handled="then: continue", no_echo_at_s=from_s)
    wrong = go(text=LONG_SHIFT, handled="then: continue", wrong_echo_s=from_s)

    assert none.codes == wrong.codes == ["link.no_echo"]
    assert wrong.port.now() <= none.port.now() + 0.5
    assert none.port.now() < from_s + 15.0


def test_one_silent_board(go: Go) -> None:
    course = go(defects=("board_25_silent:after=21s",))

    assert course.message == ("sensor.silent: board 25 (rotation) has not reported for 1 s")
    assert course.is_safe


def test_wheels_that_are_dead_and_show_zero(go: Go) -> None:
    course = go(defects=("wheels_3_4_dead",))

    assert course.message == "wheel.dead: wheel 3 is driven and does not turn"
    assert course.is_safe


def test_boards_that_all_fall_silent_while_the_controller_answers(go: Go) -> None:
    course = go(defects=("bay_silent",), far="2 m")

    assert course.message.startswith(
        "link.silent: the robot's controller answers but none of its boards reports any more, "
        "and it does not confirm the safe setpoints: push [Set] on the MIDI panel"
    )


def test_another_definition_of_a_message(go: Go) -> None:
    course = go(wrong_md5=("state",))

    assert isinstance(course.result.error, BackendError)
    assert "the firmware's pirate_msgs/State is another one than ours: its md5 is" in course.message
    assert course.bay.last_array is None


def test_a_sensor_that_is_stuck(go: Go) -> None:
    extra = Defect(kind="sensor_stuck", description="", raw={"gamma_1": 0})
    course = go(extra=extra)

    assert course.message == (
        "sensor.stuck: gamma_1 has shown the same for 1.5 s while its motor is driven and bears "
        "no load: the sensor is stuck, or the motor gets no current"
    )


def test_a_sensor_that_spikes_is_hidden_and_told_when_it_does_so_all_the_time(go: Go) -> None:
    extra = Defect(
        kind="sensor_spike",
        description="",
        raw={"gamma_3": 1365},
        after=17.0,
        every=0.8,
        lasting=0.1,
    )
    course = go(extra=extra)

    assert course.message.startswith("sensor.spiking: gamma_3 has spiked 5 times in ")
    assert course.is_safe


def test_a_sensor_out_of_its_range(go: Go) -> None:
    extra = Defect(kind="sensor_stuck", description="", raw={"gamma_3": 3000}, after=21.0)
    course = go(extra=extra)

    assert course.message.startswith("sensor.range: gamma_3 reports 264 deg, outside -1")
    assert course.is_safe


@pytest.mark.parametrize("seed", thorough_but([0], range(3)))
def test_boards_of_which_one_report_in_four_comes_are_not_silent(go: Go, seed: int) -> None:
    course = go(loss_out=0.75, seed=seed)

    assert "sensor.silent" not in course.codes
    assert "link.silent" not in course.codes


def test_motion_that_nobody_asked_for(go: Go) -> None:
    course = go(spontaneous_at_s=(16.0,), seed=7, commands="ToggleLighting", refreshed=False)

    assert course.message.endswith(" moves though nothing was asked of its motor")
    assert course.message.startswith("motion.unasked: ")


def test_a_motor_held_too_long_too_hot(go: Go) -> None:
    extra = Defect(kind="sensor_stuck", description="", raw={"bend_current_1": 300}, after=4.0)
    course = go(commands="ClampRear, ToggleLighting", extra=extra)

    assert course.message == (
        "motor.hot: the motor of bend joint 1 has been near its stall current for too long"
    )
    assert course.is_safe


def test_boards_that_all_fall_silent_while_arrays_are_confirmed(go: Go) -> None:
    course = go(defects=[f"board_{number}_silent:after=21s" for number in range(22, 28)])

    assert course.message.startswith(
        "link.silent: the robot's controller answers but none of its boards reports any more: "
        "push [Set] on the MIDI panel"
    )
    assert course.is_safe
