"""Hands the mission back at a phase, after commands that restore the states it needs.

The commands are found in the background, and the waits that are skipped are named.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from functools import partial
from typing import NamedTuple

from rich.text import Text

from pirate_sm.checking.plans import Beginnings, beginnings, restoring
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Program, Wait
from pirate_sm.core.robot import Plan, RobotSpec, RobotState, RulePlaces, state_change
from pirate_sm.views.console import availability
from pirate_sm.views.console.check_process import CheckCall
from pirate_sm.views.console.confirmed_actions import ConfirmedActions
from pirate_sm.views.console.dialogs import Pick, PickLine
from pirate_sm.views.console.driving import CommandSeries
from pirate_sm.views.showing.snapshot import MissionScene, Snapshot
from pirate_sm.views.showing.text_styles import STRONG, Part, line

# --- the commands before it ---------------------------------------------------------------------


SEEKING = "looking for commands that lead there …"
"""Shown in the list for a blocked phase until its restoring commands are known."""


class Ways(NamedTuple):
    """The plans for the phases at which the mission cannot be handed back now.

    Attributes:
        situation: The mission and the robot's situation in it.
        begun_in: States in which the phases of the mission begin.
        plans: Plans by phase.
    """

    situation: availability.HandBackSituation
    begun_in: Beginnings
    plans: Mapping[str, Plan]


def look_for_ways(
    loaded: LoadedMission,
    situation: availability.HandBackSituation,
    body: RobotState,
    places: RulePlaces | None,
    blocked: tuple[str, ...],
    known: Ways | None,
) -> Ways:
    """Return the plan for each blocked phase; takes some tenths of a second.

    Args:
        loaded: The mission.
        situation: The robot's situation.
        body: The commanded state of the robot.
        places: Progress of the mission's safety rules; None if they are not evaluated yet.
        blocked: Phases that cannot run now.
        known: Earlier results, perhaps for another situation or mission.
    """
    same = known is not None and known.situation.mission == situation.mission
    begun_in = known.begun_in if known is not None and same else beginnings(loaded)
    found = restoring(loaded, blocked, body, begun_in, places)
    return Ways(situation, begun_in, found)


def names(robot: RobotSpec, plan: Plan) -> tuple[str, ...]:
    """Return the names of the plan's commands."""
    return tuple(robot.commands[step.command].name for step in plan.steps)


def with_way(robot: RobotSpec, choice: PickLine, plan: Plan | None) -> PickLine:
    """Return the list's line of a blocked phase, with the commands that would restore it."""
    if plan is None:
        return choice
    step = plan.hindered
    if step is None:
        return choice._replace(detail=f"first {', '.join(names(robot, plan))}", reason="")
    name = robot.commands[step.command].name
    return choice._replace(reason=f"only {name} leads there: {step.hindrance}; {choice.reason}")


def leap(phase: str, waits: str) -> str:
    """Return the question before a hand-back without commands that skips waits."""
    return f"Nothing checks where the robot is{_unseen(waits)}. Hand back at {phase}?"


def _unseen(waits: str) -> str:
    """Return which waits were not passed, as far as the console can know; empty if all were.

    Stopped runs of the same mission count; runs before the console was opened are not known.
    """
    seen = "this console has not seen the mission pass"
    return f", and since its last start {seen} {waits}" if waits else ""


def question(robot: RobotSpec, phase: str, plan: Plan, body: RobotState, waits: str) -> str:
    """Return the question before the commands are given.

    Args:
        robot: The robot.
        phase: The phase of the hand-back.
        plan: The plan for it.
        body: The robot's commanded state.
        waits: The result of :func:`~pirate_sm.views.console.hand_back.not_passed`.
    """
    given = names(robot, plan)
    each = "It is awaited" if len(given) == 1 else "Each is awaited"
    return (
        f"Only states are restored. Nothing checks where the robot is{_unseen(waits)}. "
        f"{phase} needs {_needed(robot, plan, body)}. Give {', '.join(given)}, then hand back "
        f"there? {each}. A failure ends the series, and so do Esc and whatever else you ask for; "
        "Space stops the robot."
    )


def _needed(robot: RobotSpec, plan: Plan, body: RobotState) -> str:
    """Return the states that are not reached or not confirmed yet."""
    now, then = state_change(robot, body), state_change(robot, plan.body)
    doubted = set(now.unconfirmed) - set(then.unconfirmed)
    each = zip(robot.regions, now.states, then.states, strict=True)
    return ", ".join(
        f"{region} {after}" + (" confirmed" if before == after else "")
        for region, before, after in each
        if before != after or region in doubted
    )


def bar(series: CommandSeries | None) -> list[Text]:
    """Return the progress of a series of commands; nothing without one."""
    if series is None or not series.active:
        return []
    parts: list[Part] = [(f" ▶ for {series.then.phase}:  ", STRONG)]
    for number, name in enumerate(series.commands):
        sign = "✓" if number < series.done else "…" if number == series.done else " "
        parts.append((f"{name} {sign}  ", STRONG if sign == "…" else ""))
    return [line(*parts, "  (Esc: no more)")]


def not_passed(program: Program, phase: str, passed: Container[str]) -> str:
    """Return the waits before the phase that have not been passed, in words; empty if none.

    Args:
        program: The mission.
        phase: One of its phases.
        passed: Places of the passed waits.
    """
    left = [each.phase for each in waits_before(program, phase) if each.place not in passed]
    phases = list(dict.fromkeys(left))
    return f"its wait{'s' if len(left) > 1 else ''} of {', '.join(phases)}" if phases else ""


def waits_before(program: Program, phase: str) -> tuple[Wait, ...]:
    """Return the waits of which a trigger must fire on every way from the start to the phase.

    Failures, faults and time limits are ways too: a phase that they can reach from anywhere has
    no waits before it.
    """
    goal = program.enter(phase)
    if goal is None or goal not in program.reached():
        return ()
    return tuple(
        each
        for at, each in enumerate(program.instructions)
        if isinstance(each, Wait) and goal not in program.reached(without=at)
    )


# --- the list of phases -------------------------------------------------------------------------


FAULT = "an internal error"


class HandBackActions(ConfirmedActions):
    """The list of phases, with obstacles to each and commands against them."""

    ask_check: CheckCall
    """Asks the check; takes some tenths of a second, so only threads of their own call it."""

    _situation: availability.HandBackSituation | None = None
    _entries: availability.Entries | None = None
    _picking: Pick | None = None
    _ways: Ways | None = None
    _searched: availability.HandBackSituation | None = None
    _searched_scene: MissionScene | None = None
    _search_failed_in: availability.HandBackSituation | None = None
    _reported: object = None

    def _choose_phase(self, snapshot: Snapshot) -> None:
        choices = self._phase_choices(snapshot)
        names, left = [each.name for each in choices], snapshot.story.stopped_in_phase
        title = f"Hand back at (it was stopped in {left})" if left else "Hand back at"
        wide, at = max(map(len, names)), names.index(left) if left in names else 0
        pick = Pick(title, choices, wide, at)
        self._picking = pick
        self._open(pick, self._hand_back)

    def _phase_choices(self, snapshot: Snapshot) -> list[PickLine]:
        entries, phases = self.entries(snapshot), snapshot.scene.loaded.mission.phases
        failed = self._search_failed_in == availability.situation_of(snapshot)
        found = []
        for name in snapshot.scene.loaded.program.phases:
            about = getattr(phases.get(name), "description", "")
            reason = availability.phase_reason(snapshot, name, entries)
            blocked = bool(reason) and entries is not None and reason == entries.get(name)
            if blocked and self._seeking(snapshot):
                reason = SEEKING
            elif blocked and failed and FAULT not in reason:
                reason = f"{reason}; whether commands restore it is not known: {FAULT}"
            choice = PickLine(name, name, about, reason)
            plan = self._plan(snapshot, name) if reason else None
            found.append(with_way(snapshot.scene.robot, choice, plan))
        return found

    def _seeking(self, snapshot: Snapshot) -> bool:
        """Return whether the search for restoring commands is still running."""
        situation = availability.situation_of(snapshot)
        looked_in = self._search_failed_in, self._ways and self._ways.situation
        return situation is None or situation not in looked_in

    def _plan(self, snapshot: Snapshot, phase: str) -> Plan | None:
        """Return the plan that restores a blocked phase; None while it is unknown."""
        ways = self._ways
        known = ways is not None and ways.situation == availability.situation_of(snapshot)
        return ways.plans.get(phase) if ways is not None and known else None

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
                leap(phase, waits) if waits else "",
                "Hand back",
                partial(
                    self._move,
                    availability.hand_back(snapshot.scene.robot, snapshot.state.robot, phase),
                ),
            )
        elif plan is None or plan.hindered is not None:
            self._refuse(phase, reason)
        else:
            robot, body = snapshot.scene.robot, snapshot.state.robot
            text = question(robot, phase, plan, body, waits)
            self._ask(text, "Give", partial(self._give, phase, plan))

    def _give(self, phase: str, plan: Plan) -> None:
        """Give the commands of a plan if the robot's states have not changed since."""
        snapshot = self.session.latest
        robot = snapshot.scene.robot
        if self._plan(snapshot, phase) is not plan:
            self._refuse(phase, "the robot's states have changed since the list was made")
            return
        then = availability.hand_back(robot, plan.body, phase)
        self._agree(partial(self.session.give, names(robot, plan), then))

    def entries(self, snapshot: Snapshot) -> availability.Entries | None:
        """Return why the mission cannot start at each phase; None while that is being checked."""
        situation = availability.situation_of(snapshot)
        return self._entries if situation is not None and situation == self._situation else None

    def starts(self, snapshot: Snapshot) -> availability.Entries | None:
        """Return why the mission cannot start at each phase; with ``--no-check`` it can."""
        if self.session.prepared.order.check:
            return self.entries(snapshot)
        return dict.fromkeys(snapshot.scene.loaded.program.phases, "")

    def keep_up(self, snapshot: Snapshot) -> None:
        """Check a new situation in the background, and refresh the list of phases."""
        situation = availability.situation_of(snapshot)
        if situation is not None and situation != self._situation and snapshot.state is not None:
            self._situation, self._entries = situation, None
            what = snapshot.scene.loaded, snapshot.state.robot
            look = partial(self.ask_check, availability.look_at_entries, *what)
            self.run_worker(look, thread=True, group="entries", exclusive=True, exit_on_error=False)
        if self._picking is not None and self._picking.is_mounted:
            self._look_for_ways(snapshot)
            self._picking.replace(self._phase_choices(snapshot))
        self._report_series()

    def _look_for_ways(self, snapshot: Snapshot) -> None:
        """Look once, in the background, for commands that restore the phases that cannot run."""
        situation, entries = availability.situation_of(snapshot), self.entries(snapshot)
        if situation is None or entries is None or snapshot.state is None:
            return
        if (self._searched, self._searched_scene) == (situation, snapshot.scene):
            return
        if self._search_failed_in == situation:
            return
        self._searched, self._searched_scene = situation, snapshot.scene
        blocked = tuple(phase for phase, reason in entries.items() if reason)
        body, places = snapshot.state.robot, snapshot.state.rules
        what = snapshot.scene.loaded, situation, body, places, blocked, self._ways
        look = partial(self.ask_check, look_for_ways, *what)
        self.run_worker(look, thread=True, group="ways", exclusive=True, exit_on_error=False)

    def _report_series(self) -> None:
        """Report once why a series of commands has stopped, and which were not given."""
        series = self.session.giver.series
        if series is None or not series.stopped or series is self._reported:
            return
        self._reported = series
        rest = ", ".join(series.commands[series.done + series.given :]) or "nothing more"
        text = f"not handed back at {series.then.phase}: {series.stopped}; not given: {rest}"
        self.notify(text, severity="warning", timeout=10, markup=False)
