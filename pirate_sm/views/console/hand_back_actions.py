"""Hands the mission back at a phase, after commands that restore the states it needs."""

from __future__ import annotations

from functools import partial

from pirate_sm.core.robot import Plan
from pirate_sm.views.console import availability, hand_back_plan
from pirate_sm.views.console.check_process import CheckCall
from pirate_sm.views.console.confirmed_actions import ConfirmedActions
from pirate_sm.views.console.dialogs import Pick, PickLine
from pirate_sm.views.console.hand_back_plan import not_passed
from pirate_sm.views.showing.snapshot import MissionScene, Snapshot

FAULT = "an internal error"


class HandBackActions(ConfirmedActions):
    """The list of phases, with obstacles to each and commands against them."""

    ask_check: CheckCall
    """Asks the check; takes some tenths of a second, so only threads of their own call it."""

    _situation: availability.HandBackSituation | None = None
    _entries: availability.Entries | None = None
    _picking: Pick | None = None
    _ways: hand_back_plan.Ways | None = None
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
                reason = hand_back_plan.SEEKING
            elif blocked and failed and FAULT not in reason:
                reason = f"{reason}; whether commands restore it is not known: {FAULT}"
            choice = PickLine(name, name, about, reason)
            plan = self._plan(snapshot, name) if reason else None
            found.append(hand_back_plan.with_way(snapshot.scene.robot, choice, plan))
        return found

    def _seeking(self, snapshot: Snapshot) -> bool:
        """Return whether the search for restoring commands still goes on."""
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

    def _give(self, phase: str, plan: Plan) -> None:
        """Give the commands of a plan if the robot's states have not changed since."""
        snapshot = self.session.latest
        robot = snapshot.scene.robot
        if self._plan(snapshot, phase) is not plan:
            self._refuse(phase, "the robot's states have changed since the list was made")
            return
        then = hand_back_plan.hand_back(robot, phase, plan)
        self._agree(partial(self.session.give, hand_back_plan.names(robot, plan), then))

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
        look = partial(self.ask_check, hand_back_plan.look_for_ways, *what)
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
