"""What the operator asks for, and what must be settled before the session is told."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from signal import SIGHUP
from typing import TYPE_CHECKING, Any

from textual.app import SystemCommand
from textual.worker import Worker, WorkerState

from pirate_sm.console import availability, hand_back_plan
from pirate_sm.console.dialogs import Choice, Confirm, Pick
from pirate_sm.console.mission_list import ListedMission, listed_missions, load_listed
from pirate_sm.console.terminal_driver import STOP_KEY
from pirate_sm.console.waits_before import not_passed
from pirate_sm.engine.robot.planning import Plan
from pirate_sm.errors import PirateError
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.events import Answer, DetectorWord, Event, OperatorCommand, Pause, Skip, Step
from pirate_sm.runtime.stop_requests import BY_SIGNAL
from pirate_sm.showing.panels import choices
from pirate_sm.showing.snapshot import Snapshot

if TYPE_CHECKING:
    from textual.app import App

    from pirate_sm.console.session import OperatorSession

    _Base = App[None]
else:
    _Base = object

_WORDS_HEARD_FROM = {"operator", "none"}


class OperatorActions(_Base):
    """The half of the console that acts; every refusal is shown with the engine's reason.

    Attributes:
        seen: Number of the last alarm that the operator has seen.
    """

    session: OperatorSession
    letters: dict[str, str]

    seen = 0
    _agreed = False
    _situation: availability.Situation | None = None
    _entries: availability.Entries | None = None
    _picking: Pick | None = None
    _ways: hand_back_plan.Ways | None = None
    _looking_for: tuple[object, ...] | None = None
    _reported: object = None
    _wants_to_go = False

    # --- the stop -----------------------------------------------------------------------------

    def stop_now(self) -> None:
        """The robot is on its way to its safe state; may be called from any thread."""
        self.session.stop()

    def leave_now(self) -> None:
        """So it is, and the console is about to end, for nobody sees it any more."""
        self.session.quit(BY_SIGNAL[SIGHUP])

    def action_stop(self) -> None:
        """The same."""
        self.stop_now()

    def action_leave(self) -> None:
        """Safe state, then the end; asked twice, at once."""
        quitting = self.session.quitting
        if quitting.stop is not None:
            quitting.insist()
        self.session.quit()
        if self.session.latest.over:
            self.exit()

    # --- commands and words -------------------------------------------------------------------

    def on_row_asked(self, message: object) -> None:
        """A row was clicked."""
        name = str(getattr(message, "name", ""))
        known = name in self.session.latest.scene.robot.table.command_index
        (self.action_command if known else self.action_control)(name)

    def action_command(self, name: str) -> None:
        """The robot has the command, if the engine takes it; a series of commands ends."""
        self.session.giver.stop()
        snapshot = self.session.latest
        reason = availability.command_reason(snapshot, name)
        if reason:
            self._refuse(name, reason)
            return
        give = partial(self._move, OperatorCommand(name))
        robot, state = snapshot.scene.robot, snapshot.state
        lets_go = robot.commands[robot.table.command_index[name]].lets_go
        if lets_go and state is not None and robot.held[state.robot.configuration]:
            question = f"{name} lets go of the pipe: nothing holds the robot then. Let go?"
            self._ask(question, "Let go", give)
        else:
            give()

    def action_word(self, word: str) -> None:
        """The operator has said one of the detector's words."""
        prepared = self.session.prepared
        if prepared.detector not in _WORDS_HEARD_FROM:
            self._refuse(word, f"the detector speaks for itself ({prepared.detector})")
            return
        valid_for_s = prepared.loaded.loaded_robot.profile.detector.valid_for
        self.session.tell(DetectorWord(word, valid_for_s))

    def action_answer(self, number: int) -> None:
        """The mission has its answer."""
        _, offered = choices(self.session.latest)
        if 1 <= number <= len(offered):
            self.session.tell(Answer(offered[number - 1]))

    # --- the mission --------------------------------------------------------------------------

    def action_control(self, name: str) -> None:
        """The mission starts, pauses, goes on, as far as it can; a series of commands ends."""
        self.session.giver.stop()
        snapshot = self.session.latest
        control = next(
            each
            for each in availability.controls(snapshot, self.entries(snapshot))
            if each.name == name
        )
        if name == "go" and control.reason == availability.LOOKING:
            self._wants_to_go = True
            self.notify("starts as soon as the check has looked at it", timeout=4, markup=False)
        elif control.reason:
            self._refuse(control.label, control.reason)
        elif name == "hand_back":
            self._choose_phase(snapshot)
        elif name == "abort":
            self.session.stop()
        elif name == "pause":
            self.session.tell(Pause())
        else:
            events: dict[str, Event] = {"step": Step(), "skip": Skip()}
            self._move(events.get(name) or availability.going_on(snapshot))

    def _choose_phase(self, snapshot: Snapshot) -> None:
        choices = self._phase_choices(snapshot)
        pick = Pick("Hand back at", choices, max(len(each.label) for each in choices))
        self._picking = pick
        self.push_screen(pick, self._hand_back)

    def _phase_choices(self, snapshot: Snapshot) -> list[Choice]:
        entries, phases = self.entries(snapshot), snapshot.scene.loaded.mission.phases
        found = []
        for name in snapshot.scene.loaded.program.phases:
            about = getattr(phases.get(name), "description", "")
            reason = availability.phase_reason(snapshot, name, entries)
            blocked = bool(reason) and entries is not None and reason == entries.get(name)
            if blocked and self._seeking(snapshot):
                reason = hand_back_plan.SEEKING
            choice = Choice(name, name, about, reason)
            plan = self._plan(snapshot, name) if reason else None
            found.append(hand_back_plan.with_way(snapshot.scene.robot, choice, plan))
        return found

    def _seeking(self, snapshot: Snapshot) -> bool:
        """Whether it is not known yet what restores the phases that cannot run."""
        return self._ways is None or self._ways.situation != availability.situation_of(snapshot)

    def _plan(self, snapshot: Snapshot, phase: str) -> Plan | None:
        """What restores a phase that cannot run as the robot is, as far as that is known."""
        if self._ways is None or self._seeking(snapshot):
            return None
        return self._ways.plans.get(phase)

    def _hand_back(self, phase: str | None) -> None:
        self._picking = None
        snapshot = self.session.latest
        if phase is None or snapshot.state is None:
            return
        reason = availability.phase_reason(snapshot, phase, self.entries(snapshot))
        plan = self._plan(snapshot, phase)
        waits = not_passed(snapshot.scene.loaded.program, phase, snapshot.story.passed)
        if not reason:
            self._ask(
                hand_back_plan.leap(phase, waits) if waits else "",
                "Hand back",
                partial(self._move, availability.hand_back(snapshot, phase)),
            )
        elif plan is None or plan.hindered is not None:
            self._refuse(phase, reason)
        else:
            robot, body = snapshot.scene.robot, snapshot.state.robot
            text = hand_back_plan.question(robot, phase, plan, body, waits)
            self._ask(text, "Give", partial(self._give, phase, plan))

    def _ask(self, question: str, yes: str, then: Callable[[], None]) -> None:
        """Do what follows once the operator has said yes; at once where there is no question."""
        if question:
            self.push_screen(Confirm(question, yes), lambda said: then() if said else None)
        else:
            then()

    def _give(self, phase: str, plan: Plan) -> None:
        """The commands are given, if the robot is still as it was looked at."""
        snapshot = self.session.latest
        robot = snapshot.scene.robot
        if self._plan(snapshot, phase) is not plan:
            self._refuse(phase, "the robot is not any more as it was looked at")
            return
        then = hand_back_plan.hand_back(robot, phase, plan)
        self._agree(partial(self.session.give, hand_back_plan.names(robot, plan), then))

    def _move(self, event: Event) -> None:
        """The engine has the event, once somebody has agreed that the robot may move at all."""
        self._agree(partial(self.session.tell, event))

    def _agree(self, move: Callable[[], None]) -> None:
        """The robot moves, once somebody has agreed that it may."""
        question = self.session.prepared.confirmation
        if self._agreed or not question:
            move()
            return

        def answered(yes: bool | None) -> None:
            self._agreed = bool(yes)
            if yes:
                move()

        self.push_screen(Confirm(f"{question}. Is it free to?", "It is free"), answered)

    def _refuse(self, what: str, reason: str) -> None:
        self.notify(f"{what}: {reason}", severity="warning", timeout=4, markup=False)

    # --- where a mission can be handed back ----------------------------------------------------

    def entries(self, snapshot: Snapshot) -> availability.Entries | None:
        """Why not at which phase, as the robot is; None while that is being looked at."""
        situation = availability.situation_of(snapshot)
        return self._entries if situation is not None and situation == self._situation else None

    def keep_up(self, snapshot: Snapshot) -> None:
        """A new situation is being looked at, beside everything else."""
        situation = availability.situation_of(snapshot)
        if situation is not None and situation != self._situation and snapshot.state is not None:
            self._situation, self._entries = situation, None
            look = partial(availability.look_at_entries, snapshot.scene, snapshot.state.robot)
            self.run_worker(look, thread=True, group="entries", exclusive=True, exit_on_error=False)
        if self._picking is not None and self._picking.is_mounted:
            self._look_for_ways(snapshot)
            self._picking.replace(self._phase_choices(snapshot))
        self._report_series()

    def _look_for_ways(self, snapshot: Snapshot) -> None:
        """What restores the phases that cannot run as the robot is, is being looked for, once."""
        situation, entries = availability.situation_of(snapshot), self.entries(snapshot)
        if situation is None or entries is None or snapshot.state is None:
            return
        if self._looking_for == (situation, snapshot.scene):
            return
        self._looking_for = (situation, snapshot.scene)
        blocked = tuple(phase for phase, reason in entries.items() if reason)
        look = partial(
            hand_back_plan.look_for_ways,
            snapshot.scene, situation, snapshot.state, blocked, self._ways,
        )  # fmt: skip
        self.run_worker(look, thread=True, group="ways", exclusive=True, exit_on_error=False)

    def _report_series(self) -> None:
        """Say once why a series of commands has been stopped, and what was not given."""
        series = self.session.giver.series
        if series is None or not series.stopped or series is self._reported:
            return
        self._reported = series
        rest = ", ".join(series.commands[series.done + series.given :]) or "nothing more"
        text = f"not handed back at {series.then.phase}: {series.stopped}; not given: {rest}"
        self.notify(text, severity="warning", timeout=10, markup=False)

    def on_worker_state_changed(self, event: Worker.StateChanged) -> None:
        """What was looked at is known, or a mission has been loaded."""
        worker, error = event.worker, event.worker.error
        if event.state is WorkerState.ERROR and isinstance(error, PirateError):
            self.notify(str(error), severity="error", timeout=10, markup=False)
        elif event.state is WorkerState.ERROR and isinstance(error, Exception):
            self._handle_exception(error)
        elif event.state is WorkerState.SUCCESS:
            self._take_in(worker.group, worker.result)

    def _take_in(self, what: str, found: Any) -> None:
        if what == "entries":
            self._entries = found
            if self._wants_to_go:
                self._wants_to_go = False
                self.action_control("go")
        elif what == "ways":
            self._ways = found
        elif what == "missions":
            self._choose_mission(found)
        elif what == "load":
            self._take_up(found)

    # --- which mission ------------------------------------------------------------------------

    def action_missions(self) -> None:
        """The list of missions is about to be shown."""
        look = partial(listed_missions, Path.cwd())
        self.run_worker(look, thread=True, group="missions", exclusive=True, exit_on_error=False)

    def _choose_mission(self, missions: list[ListedMission]) -> None:
        robot = self.session.latest.scene.loaded.loaded_robot.folder.name
        choices = [
            Choice(
                str(each.path),
                each.name,
                each.description,
                "" if each.robot == robot else f"it is for {each.robot}",
            )
            for each in missions
        ]
        self.push_screen(Pick("Missions", choices), self._load)

    def _load(self, path: str | None) -> None:
        if path is None:
            return
        self.notify(f"loading {Path(path).stem} …", timeout=2, markup=False)
        load = partial(load_listed, self.session.prepared.order, Path(path))
        self.run_worker(load, thread=True, group="load", exclusive=True, exit_on_error=False)

    def _take_up(self, loaded: LoadedMission) -> None:
        reason = availability.why_not_mission(self.session.latest, loaded)
        if reason:
            self._refuse(loaded.mission.mission, reason)
            return
        self.session.change(loaded)
        written_for = loaded.pipe_name
        here = self.session.prepared.loaded.pipe_name
        if written_for != here:
            name, pipe = loaded.mission.mission, written_for or "no pipe"
            text = f"{name} is written for {pipe}; the robot is in {here or 'a pipe not named'}"
            self.notify(text, severity="warning", timeout=8, markup=False)

    def action_seen(self) -> None:
        """Give no more of a series; else take down how a mission ended, then what is wrong."""
        series = self.session.giver.series
        if series is not None and series.active:
            self.session.giver.stop()
            return
        story = self.session.latest.story
        if story.banner is not None and story.banner.number > self.seen:
            self.seen = story.banner.number
        elif story.alarm is not None:
            self.seen = max(self.seen, story.alarm.number)

    def palette(self) -> Iterable[SystemCommand]:
        """Everything that can be asked for, by its name, with the reason where it cannot."""
        snapshot = self.session.latest
        yield SystemCommand("Stop", f"Safe state at once ({STOP_KEY})", self.action_stop)
        ask: Callable[[str], None] = self.action_command
        for name in snapshot.scene.loaded.loaded_robot.profile.commands:
            reason = availability.command_reason(snapshot, name)
            yield SystemCommand(name, reason or "Command", partial(ask, name))
        for control in availability.controls(snapshot, self.entries(snapshot)):
            go = partial(self.action_control, control.name)
            yield SystemCommand(control.label, control.reason or "Mission", go)
        yield SystemCommand("Missions", "Choose a mission", self.action_missions)
        for word in snapshot.scene.robot.detector_words:
            yield SystemCommand(f"Detector: {word}", "Say it", partial(self.action_word, word))
