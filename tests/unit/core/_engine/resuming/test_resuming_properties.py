"""Whatever happened before a crash and whatever happens after it, the safety rules hold.

The numbers are those of the rules in docs/resume.md.
"""

from __future__ import annotations

from functools import cache
from math import isnan, nan
from pathlib import Path
from tempfile import TemporaryDirectory

from cut_off import GRIPPING
from driving import BOTH_CLAMPED, IDLE, NEWT, REAR_CLAMPED, ROOT, write_mission
from hypothesis import given, settings
from hypothesis import strategies as st
from world import COURSES, Action, Course

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.resuming.hypotheses import hypotheses
from pirate_sm.core._engine.resuming.reconciling import reconcile
from pirate_sm.core._engine.resuming.resumption import FAILURE, Resumption, resumption
from pirate_sm.core._engine.robot.robot_state import confirmed_parts
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._engine.unwatched import DarkWay
from pirate_sm.core._loading.mission.loader import LoadedMission, load_mission
from pirate_sm.core._model import events as ev

MISSIONS = [
    *(ROOT / "sequences" / f"{name}.yaml" for name in ("mitre_bend", "house_connection", "climb")),
    *(ROOT / "docs" / "examples" / f"{name}.yaml" for name in ("ask", "control", "repeat")),
    NEWT / "patrol.yaml",
]


@cache
def loaded(name: str) -> LoadedMission:
    return load_mission(next(path for path in MISSIONS if path.stem == name))


class Resumed(Course):
    """An event sequence after a crash; what must hold is checked after every event."""

    def __init__(self, before: Course, found: Resumption, *, recorded: bool) -> None:
        self.found = found
        self.before = before
        self.recorded = recorded
        super().__init__(before.robot, found.program(before.program), nominal=False)

    def __post_init__(self) -> None:
        self.engine = Engine(self.robot, self.program, nominal=False)
        values = self.found.body.values
        self.sent = fx.Setpoints(self.found.body.next_id - 1, values)
        self.accepted = self.sent
        self.signals = dict(self.before.signals)
        self.held = False
        self.state, effects = self.engine.start(0.0, resumed=self.found)
        self.first = self.state.robot.flight
        self._check_first(effects)
        self._check(None, self.state, effects)

    def _check_first(self, effects: tuple[fx.Effect, ...]) -> None:
        """Rules 2 and 3: the first array holds, and nothing is confirmed."""
        body = self.state.robot
        arrays = [each for each in effects if isinstance(each, fx.Setpoints)]
        assert len(arrays) == 1
        assert not any(isinstance(each, fx.CommandStatus) for each in effects)
        assert body.loops == ()
        last = self.before.state
        turning = last.robot.seeking if self.recorded else set[int]()
        assert all(arrays[0].values[slot] == 0.0 for slot in {*self.robot.safe_zero, *turning})
        pausing = (last.mission.paused, last.mission.pause_wanted)
        assert any(pausing) == (self.state.mission.paused or self.state.mission.pause_wanted)
        assert not confirmed_parts(self.robot, body)
        assert {mark.which for mark in body.marks if mark.kind == "region"} == set(
            range(len(self.robot.regions))
        )

    def give(self, event: ev.Event, at: float | None = None) -> None:
        before = self.state
        super().give(event, at)
        self._check_safety(event, before)

    def _check_safety(self, event: ev.Event, before: EngineState) -> None:
        body = self.state.robot
        if not self.held:  # rule 3
            assert self.first is not None
            ours = isinstance(event, ev.SubmitResult) and (
                event.setpoint_id == self.first.setpoint_id and event.status == "accepted"
            )
            self.held = ours
            if not ours:
                assert not confirmed_parts(self.robot, body), "confirmed before the hold"
                assert body.motion is None, "commanded before the hold"
        old, new = before.robot.configuration, body.configuration
        if new != old:  # rule 4
            released = self.robot.held[old] - self.robot.held[new]
            remaining = confirmed_parts(self.robot, before.robot) & self.robot.held[new]
            motion = before.robot.motion
            assert motion is not None
            lets_go = self.robot.commands[motion.command].lets_go
            assert not released or remaining or lets_go, "let go of an unconfirmed clamp"

    def _check_setpoints(self, new: fx.Setpoints) -> None:
        super()._check_setpoints(new)
        if any(new.values[slot] for slot in self.robot.safe_zero):  # rules 4 and 5
            assert self.held
            if any(self.robot.held):
                assert confirmed_parts(self.robot, self.state.robot), "driven without a clamp"


def crash(name: str, course: list[Action]) -> Course:
    mission = loaded(name)
    run = Course(mission.robot, mission.program, nominal=False)
    for action, wait, choice in course:
        if run.ended:
            break
        run.act(action, wait, choice)
    return run


WAYS = st.sampled_from(
    [
        DarkWay(0.0, 0.0, True, "known"),
        DarkWay(-0.04, 0.04, False, "unknown"),
        DarkWay(-float("inf"), float("inf"), False, "unknown"),
    ]
)
AT = st.sampled_from(["here", "here", FAILURE, "nowhere"])


def go_on(run: Course, which: int, way: DarkWay, at: str) -> Resumed | None:
    """The mission continues with one of the hypotheses; None if it refuses, with a reason."""
    found = hypotheses(run.robot, run.program, run.state)
    chosen = found[which % len(found)]
    it = resumption(run.robot, run.program, run.state, run.now, chosen, way, at)
    if not isinstance(it, Resumption):
        assert it.reason
        return None
    return Resumed(run, it, recorded=chosen.name == "recorded")


@settings(max_examples=settings.default.max_examples * 2)
@given(
    name=st.sampled_from([path.stem for path in MISSIONS]),
    before=COURSES,
    between=COURSES,
    after=COURSES,
    which=st.integers(0, 1),
    way=WAYS,
    at=AT,
)
def test_the_rules_hold_after_any_crash_and_after_a_crash_while_resuming(
    name: str,
    before: list[Action],
    between: list[Action],
    after: list[Action],
    which: int,
    way: DarkWay,
    at: str,
) -> None:
    once = go_on(crash(name, before), which, way, at)
    if once is None:
        return
    for action, wait, choice in between:
        if once.ended:
            return
        once.act(action, wait, choice)
    twice = go_on(once, which, way, "here")
    if twice is not None:
        twice.run(after)


BENDING = """\
start: bend
phases: {bend: {do: [BendInto], go: done}}
ends: {done: {succeed: Bent}}
"""
"""A mission that turns the joints of the front part by position loops."""


@cache
def written(body: str, held: str) -> LoadedMission:
    """A mission in which these parts are declared to hold: `rear` or `both`."""
    states = {"rear": REAR_CLAMPED, "both": BOTH_CLAMPED}[held]
    with TemporaryDirectory() as folder:
        return load_mission(write_mission(Path(folder), body), states=states)


def started(body: str, held: str) -> Course:
    mission = written(body, held)
    run = Course(mission.robot, mission.program, nominal=False)
    run.signals |= GRIPPING
    return run


def hear(run: Course, elapsed_s: float) -> None:
    """All boards report, one after the other."""
    for board in run.robot.boards:
        run.give(run._frame(board), run.now + elapsed_s / len(run.robot.boards))


@given(
    wait=st.sampled_from(["result", "motion", "duty"]),
    elapsed_s=st.sampled_from([0.05, 0.3, 1.0]),
    pause=st.booleans(),
    way=WAYS,
    after=COURSES,
)
def test_a_crash_while_joints_turn_and_a_pause_is_pending_stops_them_and_stays_paused(
    wait: str, elapsed_s: float, pause: bool, way: DarkWay, after: list[Action]
) -> None:
    run = started(BENDING, "rear")
    while run.state.robot.flight is None:
        hear(run, 0.1)
    if wait != "result":
        run.act("accepted", 0.0, 0)
        hear(run, elapsed_s)
        assert run.state.robot.seekers
    if wait == "duty":
        run.act("accepted", 0.0, 0)
        assert run.state.robot.seeking
    if pause:
        run.give(ev.Pause())
        assert run.state.mission.pause_wanted or run.state.mission.paused

    again = go_on(run, 0, way, "here")

    assert again is not None
    again.run(after)


SEEN = st.lists(st.sampled_from(["holds", "slack", "nothing"]), min_size=1, max_size=4)
TORQUES_NM = {"holds": 0.7, "slack": 0.0, "nothing": nan}
EVERY_S = 0.1


def looks(seen: list[str], turns: list[int]) -> list[str]:
    """What a part shows at each frame: each of what is seen, for so many frames."""
    return [each for each, count in zip(seen, turns, strict=False) for _ in range(count)]


@given(front=SEEN, rear=SEEN, turns=st.lists(st.integers(1, 9), min_size=4, max_size=4))
def test_belief_in_a_part_takes_what_was_seen_long_enough_and_to_the_end_of_the_look(
    front: list[str], rear: list[str], turns: list[int]
) -> None:
    run = started(IDLE, "both")
    shown = {"front": looks(front, turns), "rear": looks(rear, turns[::-1])}
    count = min(map(len, shown.values()))
    frames = []
    for turn in range(count):
        for part, first in (("front", 1), ("rear", 3)):
            torque = TORQUES_NM[shown[part][turn]]
            run.signals |= {f"bend_torque_{first}": -torque, f"bend_torque_{first + 1}": torque}
        frames += [(turn * EVERY_S, run._frame(board)) for board in run.robot.boards]

    found = reconcile(run.robot, run.program, run.state, frames, (count - 1) * EVERY_S, 0.0)

    for number, part in enumerate(run.robot.parts):
        spec = run.robot.sight.parts[number]
        assert spec is not None
        seen = shown[part][:count]
        lasting = next((n for n, each in enumerate(seen[::-1]) if each != seen[-1]), count)
        if seen[-1] == "holds":  # before the second frame no joint is known to stand still
            lasting = min(lasting, count - 1)
        words = {"holds": "confirmed", "slack": "contradicted"}
        long_enough = (lasting - 1) * EVERY_S >= spec.for_s - 1e-9
        expected = words.get(seen[-1], "unknown") if long_enough else "unknown"
        word = next(each.word for each in found.tables[0].verdicts if each.about == part)
        assert word == expected, (part, seen)


NUMBERS = st.one_of(st.floats(-4096, 4096), st.just(nan), st.just(0.0))


@given(
    name=st.sampled_from(["mitre_bend", "patrol"]),
    before=COURSES,
    values=st.lists(NUMBERS, min_size=8, max_size=40),
)
def test_what_is_unknown_never_confirms(
    name: str, before: list[Action], values: list[float]
) -> None:
    run = crash(name, before)
    frames = [
        (10.0 + turn / 10, ev.SensorFrame(board, tuple(values[number % 8 :][:9]) + (nan,) * 9))
        for turn in range(11)
        for number, board in enumerate(run.robot.boards)
    ]

    found = reconcile(run.robot, run.program, run.state, frames, 11.0, 0.3)

    for table in found.tables:
        for each in table.verdicts:
            unknown = [shown.seen == "unknown" for shown in each.shown]
            if each.word == "confirmed" and unknown:  # of wheels some may be unknown
                assert not (any(unknown) if each.mark.kind == "part" else all(unknown))
            assert each.why or each.word == "confirmed"
    assert found.chosen is not None or found.choices or found.refusals
    assert isnan(found.way.low_m) is False
