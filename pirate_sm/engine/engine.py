"""The engine: ``step(state, event, now) -> (state, effects)``; same inputs, same effects, always.

At every input and deadline, in this order (rule 6): abort, fault, completion of the command under
way, the wait's triggers as listed, then time.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan

from pirate_sm.engine import (
    environment,
    looking,
    machine,
    operating,
    pausing,
    robot_state,
    rules,
    scripted,
    seeing,
)
from pirate_sm.engine.diverting import divert, meet
from pirate_sm.engine.ending import end, finish
from pirate_sm.engine.faults import (
    ANEW,
    Found,
    begin_anew,
    listen,
    look,
    no_faults,
    unsettle,
)
from pirate_sm.engine.interpreter import advance, next_deadline, spoken
from pirate_sm.engine.moments import has_come
from pirate_sm.engine.program import Program
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.engine.robot_state import Finished, RobotState
from pirate_sm.engine.sensing import forget_stale, nothing_known, observe
from pirate_sm.engine.state import EngineState, MissionState, Setting, Words
from pirate_sm.engine.watching import watch
from pirate_sm.model import events
from pirate_sm.model.effects import (
    Detected,
    Effect,
    Log,
    WakeAt,
)
from pirate_sm.model.fault_codes import BuiltInFault

Effects = tuple[Effect, ...]


class Engine:
    """Runs one mission on one robot. Holds nothing that changes: all of that is in the state.

    Args:
        robot: What runs.
        program: What it shall do.
        nominal: Take commands as done after their nominal duration, for a backend in which
            nothing moves and no sensor speaks.
    """

    def __init__(self, robot: RobotSpec, program: Program, *, nominal: bool) -> None:
        self.robot = robot
        self.program = program
        self.nominal = nominal
        self.setting = Setting(robot, program)
        self._known_faults = robot.fault_codes()

    def start(
        self,
        now_s: float = 0.0,
        seen: Sequence[events.SensorFrame | events.SignalReport] = (),
        *,
        body: RobotState | None = None,
        paused: bool = False,
    ) -> tuple[EngineState, Effects]:
        """The mission has begun; its first effects are returned with the first state.

        Args:
            now_s: When.
            seen: What the boards have reported before, or a script has told; an angle that the
                first array keeps must be reported by then, or it is taken to be 0.
            body: What the robot has been commanded to by an earlier mission; None: it is said to
                be at rest in the configuration that the program begins in.
            paused: Whether the operator has the robot first.
        """
        robot = body or self._declared()
        sensing = nothing_known(self.robot, blind=self.nominal)
        sensing = sensing._replace(heard_s=(now_s,) * len(sensing.heard_s), checked_s=now_s)
        for frame in seen:
            if isinstance(frame, events.SensorFrame):
                sensing, _ = observe(
                    self.robot, sensing, frame, robot.values, robot.values, now_s, sent=robot.sent
                )
        words = (*robot_state.states_of(self.robot, robot), None, None)
        mission = MissionState(self.program.start, offset_s=now_s, pause_wanted=paused)
        following, _ = rules.follow(self.program, self.robot, rules.unseen(self.program), robot, 0)
        look = None if self.nominal else seeing.begin(self.robot, robot, now_s)
        state = EngineState(
            robot, sensing, mission, no_faults(self.robot), words, rules=following,
            surveyed=environment.nothing_surveyed(nominal=self.nominal), look=look,
        )  # fmt: skip
        effects: list[Effect] = [robot_state.state_change(self.robot, robot)]
        for report in seen:
            if isinstance(report, events.SignalReport):
                state = scripted.told(self, state, report, effects)
        return self._settle(state, state, now_s, effects)

    def _declared(self) -> RobotState:
        """The robot as the program says it is: on paper that is so, sensors must confirm it."""
        declared = robot_state.at_rest_in if self.nominal else seeing.declared_in
        return declared(self.robot, self.program.start_configuration)

    def step(
        self, state: EngineState, event: events.Event, now_s: float
    ) -> tuple[EngineState, Effects]:
        """The event has had all its consequences at this moment.

        Args:
            state: What was; unchanged.
            event: What has happened.
            now_s: When, in seconds since the run began; must not go back.

        Returns:
            The new state and the effects in order. After an ``Ended`` there are none any more.
        """
        if state.mission.ended:
            return state, ()
        before = state
        effects: list[Effect] = []
        if type(event) is events.SensorFrame:
            state = self._frame(state, event, now_s, effects)
        elif type(event) is events.SignalReport:  # counts from the next event on
            return scripted.told(self, state, event, effects), tuple(effects)
        else:
            state = self._meet(state, event, now_s, effects)
        return self._settle(before, state, now_s, effects)

    def signals(self, state: EngineState) -> dict[str, float]:
        """Every signal in SI by its name; NaN where it is unknown."""
        return dict(zip(self.robot.vocabulary.numbers, state.sensing.shown, strict=True))

    def safe_values(self, state: EngineState) -> tuple[float, ...]:
        """The safe array, for a last resort when no step can be made any more."""
        return robot_state.safe_values(self.robot, state.robot, state.sensing.numbers)

    def seeking(self, state: EngineState) -> frozenset[int]:
        """Return the slots that a position loop drives in the newest array."""
        flight = state.robot.flight
        return state.robot.seeking if flight is None else flight.seeking

    # --- events -----------------------------------------------------------------------------

    def _meet(
        self, state: EngineState, event: events.Event, now: float, effects: list[Effect]
    ) -> EngineState:
        match event:
            case events.SubmitResult():
                return self._submitted(state, event, now, effects)
            case events.Tick():
                return state
            case events.SensorFrame():
                return self._frame(state, event, now, effects)
            case events.SignalReport():
                return scripted.told(self, state, event, effects)
            case events.DetectorWord():
                return self._word(state, event, now, effects)
            case events.EnvironmentReport():
                return environment.hear(self, state, event, now, effects)
            case events.FaultReport():
                return self._fault_report(state, event, now, effects)
            case events.CommandFailed():
                return scripted.undone(self, state, event, now, effects)
            case _:
                return operating.obey(self.setting, state, event, now, effects)

    def _frame(
        self, state: EngineState, event: events.SensorFrame, now: float, effects: list[Effect]
    ) -> EngineState:
        board = self.robot.boards.get(event.board)
        if board is None:
            return state
        robot = state.robot
        sensing, reports = observe(
            self.robot, state.sensing, event, robot.values, robot.latest, now, sent=robot.sent
        )
        words = self._obeyed_words(state)
        faults, found = look(self.robot, state.faults, board, sensing, words, now)
        state = EngineState(
            state.robot, sensing, state.mission, faults, state.words,
            state.word_until_s, state.wake_at_s, state.rules, state.surveyed, state.look,
        )  # fmt: skip
        for report in reports:
            state = meet(self.setting, state, self._found(report), now, effects)
        for fault in found:
            state = meet(self.setting, state, fault, now, effects)
        return state

    def _found(self, report: events.FaultReport) -> Found:
        return Found(report.code, report.message, self._known_faults.get(report.code, True))

    def _word(
        self, state: EngineState, event: events.DetectorWord, now: float, effects: list[Effect]
    ) -> EngineState:
        if event.word not in self.robot.detector_words:
            effects.append(Log("warning", f"the detector said '{event.word}', an unknown word"))
            return state
        state = state._replace(word_until_s=now + event.valid_for_s)
        if state.words[-2] == event.word:
            return state
        effects.append(Detected(event.word))
        return state._replace(words=(*state.words[:-2], event.word, state.words[-1]))

    def _submitted(
        self, state: EngineState, event: events.SubmitResult, now: float, effects: list[Effect]
    ) -> EngineState:
        flight = state.robot.flight
        robot, finished = machine.resolve(self.robot, state.robot, event, now, effects)
        state = self._moved(state, robot)
        state = self._finished(state, finished)
        if flight is None or event.setpoint_id != flight.setpoint_id:
            return state
        limit = self.robot.link.resend_limit
        if event.status == "unknown" and flight.tries > limit:
            message = f"setpoints were not confirmed after {limit} repeats"
            found = Found.built_in(BuiltInFault.LINK_NO_ECHO, message)
            state = meet(self.setting, state, found, now, effects)
        elif event.status in {"rejected", "superseded"} and flight.purpose != "gate":
            # Only a command can be refused; without the array the robot is not what it seems.
            message = f"the backend has {event.status} setpoints: {event.reason or 'no reason'}"
            state = self._refused(state, message, now, effects)
        return state

    def _refused(
        self, state: EngineState, message: str, now: float, effects: list[Effect]
    ) -> EngineState:
        ending = state.mission.ending
        if ending is None:
            found = Found.built_in(BuiltInFault.BACKEND_FAILED, message)
            return meet(self.setting, state, found, now, effects)
        ending = ending._replace(message=f"{ending.message} ({message})")
        return state._replace(mission=state.mission._replace(ending=ending))

    def _fault_report(
        self, state: EngineState, event: events.FaultReport, now: float, effects: list[Effect]
    ) -> EngineState:
        if event.code in ANEW:
            state = state._replace(sensing=begin_anew(self.robot, state.sensing, now))
            words = self._obeyed_words(state)
            faults = unsettle(self.robot, state.faults, state.sensing, words)
            state = state._replace(faults=faults)
        return meet(self.setting, state, self._found(event), now, effects)

    # --- what follows -------------------------------------------------------------------------

    def _settle(
        self, before: EngineState, state: EngineState, now: float, effects: list[Effect]
    ) -> tuple[EngineState, Effects]:
        due = has_come(now, state.wake_at_s)
        if due:
            state = self._housekeep(state, now, effects)
        if now >= state.surveyed.due_s and not state.mission.ended:  # nothing follows the end
            state = environment.look_round(self, state, now, effects)
        judged = before
        if state.mission.ending is not None:
            state = finish(state, now, effects)
        elif not state.mission.ended:
            if state.look is not None:
                state = looking.go_on(self.setting, state, state.look, now, effects)
            state = self._see_done(state, now, effects)
            # Whether the next command would break a rule is asked of where the rules are now.
            state = judged = self._judge(before, state, now, effects)
            if not (state.mission.ending or state.mission.ended):
                state = self._go_on(state, now, effects)
        state = self._judge(judged, state, now, effects)
        mission = state.mission
        if mission.answer is not None or mission.skipped is not None:
            state = state._replace(mission=spoken(self.setting, state))
        changed = (
            state.robot is not before.robot
            or state.mission is not before.mission
            or state.word_until_s != before.word_until_s
            or state.look is not before.look
        )
        if changed or effects or due:
            state = self._set_wake(state, effects)
        return state, tuple(effects)

    def _judge(
        self, before: EngineState, state: EngineState, now: float, effects: list[Effect]
    ) -> EngineState:
        if state.robot is before.robot or not state.rules:
            return state
        return watch(self.setting, before, state, now, effects)

    def _see_done(self, state: EngineState, now: float, effects: list[Effect]) -> EngineState:
        if state.robot.motion is None or state.mission.suspended:
            return state
        return self._watch(state, now, effects)

    def _go_on(self, state: EngineState, now: float, effects: list[Effect]) -> EngineState:
        if state.look is None:  # nothing is commanded before it is over
            if state.mission.diverting is not None:
                state = divert(self.setting, state, now, effects)
            if state.mission.pause_wanted:
                state = pausing.begin_if_wanted(self.robot, state, now, effects)
            state = advance(self.setting, state, now, effects)
        limit_s = self.program.time_limit_s
        if limit_s < inf and has_come(state.mission.clock(now), limit_s):
            message = f"the mission's time limit of {limit_s:g} s has passed"
            state = end(self.setting, state, "failed", message, "", now, effects)
        if state.mission.pause_wanted:
            state = pausing.begin_if_wanted(self.robot, state, now, effects)
        return state

    def _watch(self, state: EngineState, now: float, effects: list[Effect]) -> EngineState:
        robot, finished = machine.watch(
            self.robot, state.robot, state.sensing, now, self.nominal, effects,
            denied=self.robot.denied_by(state.faults.raised),
        )  # fmt: skip
        if robot is not state.robot:
            state = self._moved(state, robot)
        return self._finished(state, finished)

    def _finished(self, state: EngineState, finished: Finished | None) -> EngineState:
        """The mission knows how its command ended; during a pause commands are the operator's."""
        if finished is None or state.mission.paused:
            return state
        return state._replace(mission=state.mission._replace(result=finished))

    def _moved(self, state: EngineState, robot: RobotState) -> EngineState:
        """The words say the configuration that the robot has now."""
        if robot.configuration == state.robot.configuration:
            return state._replace(robot=robot)
        words = (*robot_state.states_of(self.robot, robot), *state.words[-2:])
        return state._replace(robot=robot, words=words)

    def _obeyed_words(self, state: EngineState) -> Words:
        """What rules for faults see: wheels that a pause or a fault has stopped are not stuck."""
        robot = state.robot
        if state.mission.before_pause is None:
            marks = robot.marks  # mostly none: do not begin to look
            if not marks or all(mark.command != robot_state.STOPPED for mark in marks):
                return state.words
        return (*robot_state.obeyed(self.robot, robot), *state.words[-2:])

    def _housekeep(self, state: EngineState, now: float, effects: list[Effect]) -> EngineState:
        """What grows old has been looked at: signals, boards, the detector's word, the flight."""
        if has_come(now, state.word_until_s):
            words = (*state.words[:-2], None, state.words[-1])
            state = state._replace(words=words, word_until_s=inf)
        robot = machine.resend(state.robot, now, effects)
        if robot is not state.robot:
            state = state._replace(robot=robot)
        if self.nominal or not has_come(now, state.sensing.checked_s + self._listen_every_s):
            return state
        sensing = forget_stale(self.robot, state.sensing, now)
        faults = state.faults
        if sensing.stale != state.sensing.stale:
            faults = unsettle(self.robot, faults, sensing, self._obeyed_words(state))
        faults, found = listen(self.robot, faults, sensing, now)
        state = state._replace(sensing=sensing, faults=faults)
        for fault in found:
            state = meet(self.setting, state, fault, now, effects)
        return state

    def _set_wake(self, state: EngineState, effects: list[Effect]) -> EngineState:
        """Who drives the engine knows when time alone will change something."""
        if state.mission.ended:
            return state
        body = state.robot
        if state.mission.suspended:
            body = body._replace(motion=None)  # its deadline is frozen
        wake = min(
            robot_state.next_deadline(self.robot, body, self.nominal),
            next_deadline(self.setting, state),
            state.word_until_s,
        )
        if state.look is not None and not state.mission.ending:
            wake = min(wake, state.look.due_s)
        if self.nominal:
            wake = min(wake, state.surveyed.due_s)
        else:
            wake = min(wake, state.sensing.checked_s + self._listen_every_s)
        if wake == state.wake_at_s or isnan(wake):
            return state
        effects.append(WakeAt(wake))
        return state._replace(wake_at_s=wake)

    @property
    def _listen_every_s(self) -> float:
        link = self.robot.link
        return min(link.stale_after_s, link.silent_after_s) / 2
