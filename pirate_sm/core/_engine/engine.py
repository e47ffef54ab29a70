"""The engine: ``step(state, event, now_s) -> (state, effects)``; same inputs, same effects.

At every input and deadline, in this order (rule 6): abort, fault, completion of the command under
way, the wait's triggers as listed, then time.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan, nan
from typing import TYPE_CHECKING

from pirate_sm.core._engine import inputs, safety
from pirate_sm.core._engine.consequences import settle
from pirate_sm.core._engine.mission.program import (
    BranchKey,
    Program,
    signals_read,
    slip_watched,
)
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot import commands, declared_states, robot_state
from pirate_sm.core._engine.robot.evidence import Evidence, proofs_at_start
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._engine.safety import no_faults
from pirate_sm.core._engine.sensing import environment
from pirate_sm.core._engine.sensing.known_signals import nothing_known, with_odometry
from pirate_sm.core._engine.sensing.odometry import counting
from pirate_sm.core._engine.sensing.signal_table import observe
from pirate_sm.core._engine.sensing.traction import with_traction
from pirate_sm.core._engine.state import OUTSIDE, EngineState, MissionState
from pirate_sm.core._model import events
from pirate_sm.core.effects import Effect, PhaseChange, Setpoints, StateChange

if TYPE_CHECKING:
    from pirate_sm.core._engine.resuming.resumption import Resumption
    from pirate_sm.core._geometry.force_intervals import ForceInterval

Effects = tuple[Effect, ...]


class Engine:
    """Runs one mission on one robot. The engine is immutable: everything that changes is state.

    Args:
        robot: The robot.
        program: The mission to run.
        nominal: Whether commands count as done after their nominal duration, for a backend
            without motion and sensors.
        every_signal: Whether the state has every signal in every round of the boards, also those
            of slip and friction that nothing reads; they take some time.
        alphabet: The version of the alphabet by whose rules it decides: that of a recording in its
            replay.
        taken: Receives each branch of the mission that is taken, see
            :mod:`pirate_sm.core.branches`; None: nothing counts them.
    """

    def __init__(
        self,
        robot: RobotSpec,
        program: Program,
        *,
        nominal: bool,
        every_signal: bool = False,
        alphabet: int = events.ALPHABET_VERSION,
        taken: list[BranchKey] | None = None,
    ) -> None:
        self.robot = robot
        self.program = program
        self.nominal = nominal
        self.alphabet = alphabet
        self._taken = taken
        spec = robot.traction
        read = signals_read(robot, program)
        self._follows_traction = (not nominal and spec is not None) and (
            every_signal or not read.isdisjoint(spec.targets)
        )
        self._judges_distance = (
            not nominal and robot.odometry >= 0 and alphabet >= events.EVIDENCE_ENDS
        )
        self._reads_distance = not read.isdisjoint({robot.odometry, robot.bound} - {-1})
        # Under these controls slip is followed while they are in force.
        self._slip_watched = frozenset(
            control
            for control, signals in slip_watched(robot)
            if not nominal and spec is not None and not signals.isdisjoint(spec.targets)
        )

    def start(  # noqa: C901 - each thing with which a run may begin
        self,
        now_s: float = 0.0,
        seen: Sequence[events.SensorFrame | events.SignalReport | events.Breakpoints] = (),
        *,
        body: RobotState | None = None,
        paused: bool = False,
        resumed: Resumption | None = None,
    ) -> tuple[EngineState, Effects]:
        """Start the mission and return its first state and effects.

        Args:
            now_s: Start time, in seconds.
            seen: Reports of the boards, or of a script, from before the start, and the breakpoints
                of the operator. An angle that the first array keeps must be among them, otherwise 0
                is assumed.
            body: The robot's state after an earlier mission. None declares it at rest in the
                configuration in which the program begins.
            paused: Whether the mission starts paused, with the operator in control.
            resumed: With what a mission goes on whose run was cut off; instead of ``body``. The
                program of the engine is then that of the resumption. The first array holds the
                robot, and nothing is confirmed or commanded before it is accepted.
        """
        robot = resumed.body if resumed else body or self._declared()
        sensing = nothing_known(self.robot, blind=self.nominal)
        if resumed is not None and not isnan(resumed.odometry_m) and not self.nominal:
            sensing = with_odometry(self.robot, sensing, resumed.odometry_m, adrift=resumed.adrift)
        if self._judges_distance:
            memory = resumed.distance if resumed else sensing.distance
            sensing = counting(self.robot, sensing, memory, read=self._reads_distance)
        sensing = sensing._replace(heard_s=(now_s,) * len(sensing.heard_s), checked_s=now_s)
        for frame in seen:
            if isinstance(frame, events.SensorFrame):
                sensing, _ = observe(
                    self.robot, sensing, frame, robot.values, robot.values, now_s, sent=robot.sent
                )
        words = (*robot_state.states_of(self.robot, robot), *(None for _ in OUTSIDE))
        mission = MissionState(self.program.start, offset_s=now_s, pause_wanted=paused)
        progress = safety.unseen(self.program)
        if resumed is not None:
            mission = mission._replace(
                offset_s=now_s - resumed.clock_s,
                origin=resumed.entry.origin,
                counts_from=resumed.counts_from,
                claim=resumed.claim,
                cause=resumed.cause,
                handling=resumed.handling,
                pause_wanted=paused or resumed.paused,
            )
            progress = resumed.rules or progress
        following, _ = safety.follow(self.program, self.robot, progress, robot, 0)
        look = None if self.nominal else declared_states.begin(self.robot, robot, now_s)
        surveyed = environment.nothing_surveyed(nominal=self.nominal)
        faults = no_faults(self.robot, now_s)
        state = EngineState(robot, sensing, mission, faults, words)
        state = state._replace(rules=following, surveyed=surveyed, look=look)
        if not self.nominal:
            now = Evidence("sensor", now_s, state.sensing.connection)
            state = state._replace(proofs=proofs_at_start(self.robot, robot, now))
        moment = Moment(
            self.robot, self.program, self.nominal, now_s, False, self.alphabet, self._taken
        )
        moment.emit(robot_state.state_change(self.robot, robot))
        for report in seen:
            if isinstance(report, events.SignalReport):
                state = inputs.signal_report(moment, state, report)
            elif isinstance(report, events.Breakpoints):
                state = inputs.obey(moment, state, report)
        if resumed is not None:
            state = _take_up(moment, state, resumed)
        return settle(moment, state, state), tuple(moment.effects)

    def _declared(self) -> RobotState:
        """Return the robot as declared; with sensors it is unconfirmed until they agree."""
        declared = robot_state.at_rest_in if self.nominal else declared_states.declared_in
        return declared(self.robot, self.program.start_configuration)

    def step(
        self, state: EngineState, event: events.Event, now_s: float
    ) -> tuple[EngineState, Effects]:
        """Return the state and the effects after the event and everything that follows from it.

        Args:
            state: The state before the event; it is not modified.
            event: The event.
            now_s: Time of the event in seconds since the run began; must not decrease.

        Returns:
            The new state and the effects in order. Nothing follows an ``Ended``.
        """
        if state.mission.ended:
            return state, ()
        follows, alphabet = self.follows_slip(state), self.alphabet
        of = self.robot, self.program, self.nominal
        moment = Moment(*of, now_s, follows, alphabet, self._taken)
        if type(event) is events.SensorFrame:  # the most frequent event
            after = inputs.frame(moment, state, event)
        else:
            after = _take(moment, state, event)
        if type(event) is not events.SignalReport:  # a script counts from the next event
            after = settle(moment, state, after)
        return after, tuple(moment.effects)

    def follows_slip(self, state: EngineState) -> bool:
        """Return whether slip and friction are estimated in every round."""
        return self._follows_traction or state.robot.control in self._slip_watched

    def signals(self, state: EngineState) -> dict[str, float]:
        """Return all signals by name, in SI units; NaN is unknown."""
        return dict(zip(self.robot.vocabulary.numbers, self.numbers(state), strict=True))

    def numbers(self, state: EngineState) -> Numbers:
        """Return all signals as conditions see them, with those that the state has not estimated.

        Returns:
            Signals in the order of the vocabulary, SI; NaN is unknown.
        """
        spec, sensing, body = self.robot.traction, state.sensing, state.robot
        if spec is None or self.nominal or self.follows_slip(state) or sensing.sees_slip:
            return sensing.shown
        at, around, at_s = body.configuration, state.surveyed.reported, max(sensing.heard_s)
        return with_traction(self.robot, spec, sensing, body.values, at, around, at_s).shown

    def normal_forces(
        self,
        state: EngineState,
        friction: float,
        brakes_nm: Sequence[float],
        *,
        resists: float,
        is_round: bool,
    ) -> tuple[tuple[int, ...], tuple[ForceInterval, ...]]:
        """Return the wheels that hold and the intervals of their normal forces.

        See :func:`~pirate_sm.core._engine.held_forces.held_force_intervals`.
        """
        # Few runs ask for them; a check never does.
        from pirate_sm.core._engine.held_forces import held_force_intervals  # noqa: PLC0415

        return held_force_intervals(
            self.robot, state, friction, brakes_nm, resists=resists, is_round=is_round
        )

    def evidence(self, state: EngineState) -> dict[str, Evidence]:
        """Return what has shown each region's state, each part's clamp and each signal, by name.

        A signal of a board has the evidence of that board's last report, the distance that of the
        oldest report of a wheel. Signals of which nothing is known, or which no board measures, are
        left out. Empty without sensors.
        """
        robot, sensing, names = self.robot, state.sensing, self.robot.vocabulary.numbers
        found = dict(zip((*robot.regions, *robot.parts), state.proofs, strict=False))
        boards = () if self.nominal else [*robot.boards.values()]
        measured = [(sensing.heard_s[each.position], each.numbers) for each in boards]
        if measured and robot.odometry >= 0 and robot.odometry not in sensing.adrift:
            measured += [(min(sensing.heard_s[at] for at in robot.wheel_boards), (robot.odometry,))]
        for heard_s, numbers in measured:
            report = Evidence("sensor", heard_s, sensing.connection)
            known = [names[at] for at in numbers if not isnan(sensing.numbers[at])]
            found |= dict.fromkeys(known, report)
        return found

    def unproven(self, before: EngineState | None) -> EngineState:
        """Return a state without a signal, in the states of before a gap of a recording.

        Args:
            before: The state before the gap; None if nothing was known then. None of its states is
                confirmed.
        """
        robot, unknown = self.robot, (nan,) * len(self.robot.slots)
        body = RobotState(self.program.start_configuration, unknown)
        if before is not None:
            was = before.robot
            body = body._replace(configuration=was.configuration, control=was.control)
        states = robot_state.states_of(robot, body)
        body = _in_states(robot, body, StateChange(states, robot.regions))
        sensing, mission = nothing_known(robot, blind=True), MissionState(self.program.start)
        words = (*states, *(None for _ in OUTSIDE))
        return EngineState(body, sensing, mission, no_faults(robot), words)

    def listening_only(
        self, state: EngineState, event: events.Event | None, effects: Sequence[Effect], at_s: float
    ) -> EngineState:
        """Return the state after a step before which steps are lost: what is recorded, signals.

        The mission is not executed, as it may be elsewhere. NaN are signals that need what was
        before, such as odometry.

        Args:
            state: The state before the step.
            event: The event of the step; None if it had none.
            effects: The recorded effects.
            at_s: When it was.
        """
        robot = self.robot
        for effect in effects:
            if isinstance(effect, StateChange):
                state = state.moved(robot, _in_states(robot, state.robot, effect))
            elif isinstance(effect, Setpoints):
                state = state._replace(robot=state.robot._replace(values=effect.values))
            elif isinstance(effect, PhaseChange):
                pc = self.program.enter(effect.phase)
                pc = self.program.start if pc is None else pc
                state = state._replace(mission=MissionState(pc))
        if not isinstance(event, events.SensorFrame):
            return state
        values = state.robot.values
        sensing, _ = observe(robot, state.sensing, event, values, values, at_s)
        known = {number for board in robot.boards.values() for number in board.numbers}
        numbers = (now if at in known else nan for at, now in enumerate(sensing.numbers))
        return state._replace(sensing=sensing._replace(numbers=tuple(numbers)))

    def safe_values(self, state: EngineState) -> tuple[float, ...]:
        """Return the safe array, for use when the engine can make no further step."""
        return robot_state.safe_values(self.robot, state.robot, state.sensing.numbers)

    def seeking(self, state: EngineState) -> frozenset[int]:
        """Return the slots of the newest array whose loop leaves zero behind when it stops."""
        flight = state.robot.flight
        return state.robot.seeking if flight is None else flight.seeking


def _take_up(moment: Moment, state: EngineState, resumed: Resumption) -> EngineState:
    """Return the state with which a resumed run begins: its first array holds the robot."""
    if resumed.entry.by_resume:
        moment.take("resume", moment.program.taken_up)
    return state._replace(robot=commands.stop(moment, state.robot, state.sensing))


def _in_states(robot: RobotSpec, body: RobotState, change: StateChange) -> RobotState:
    """Return the robot in recorded states; a part may hold if a region of it is confirmed."""
    here = robot.table.index_of(change.states)
    if here is None:
        return body
    regions = {robot.regions.index(name) for name in change.unconfirmed}
    parts = {part for part in robot.held[here] if robot.part_regions[part] <= regions}
    marks = {robot_state.Mark("region", each, robot_state.DENIED) for each in regions}
    marks |= {robot_state.Mark("part", each, robot_state.DENIED) for each in parts}
    return body._replace(configuration=here, marks=frozenset(marks))


def _take(moment: Moment, state: EngineState, event: events.Event) -> EngineState:
    match event:
        case events.SensorFrame():
            return inputs.frame(moment, state, event)
        case events.SubmitResult():
            return inputs.submitted(moment, state, event)
        case events.Tick():
            return state
        case events.SignalReport():
            return inputs.signal_report(moment, state, event)
        case events.DetectorWord():
            return inputs.word(moment, state, event)
        case events.EnvironmentReport():
            return inputs.environment_report(moment, state, event)
        case events.OutsideNumber():
            return inputs.outside_number(moment, state, event)
        case events.FaultReport():
            return inputs.fault_report(moment, state, event)
        case events.CommandFailed():
            return inputs.command_failed(moment, state, event)
        case _:
            return inputs.obey(moment, state, event)
