"""Whether a run has done anything that the check has ruled out, or not told of."""

from __future__ import annotations

from agreement.running import Run, situation
from pirate_sm.checking.findings import Severity
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.core import effects as fx
from pirate_sm.core.program import ROUND_AND_ROUND, Do, Require, Wait
from pirate_sm.core.robot import safety

CERTAIN = {"step.impossible", "step.unneeded"}
CALLS = {"call.starts_in", "call.maybe_starts_in"}
REFUSALS = {
    *CERTAIN, *CALLS, "step.maybe_impossible", "step.maybe_unneeded", "handler.impossible",
}  # fmt: skip


class Judge:
    """Knows what a check has said of a mission, and holds runs against it.

    Attributes:
        codes: Of all findings.
        complete: Whether the check says that it has looked at everything.
        clean: Whether it has found no error, nor anything that may be one.
    """

    def __init__(self, check: MissionCheck) -> None:
        assert check.loaded is not None
        self.check, self.program = check, check.loaded.program
        self.codes = {each.code for each in check.findings}
        self.complete = "check.too_large" not in self.codes
        self.clean = all(each.severity is Severity.WARNING for each in check.findings)
        self._explored = {situation(node.state) for node in check.explored[0].found.nodes}
        steps = [each for each in self.program.instructions if isinstance(each, Do | Require)]
        self._expected = {each.place for each in steps if each.expected}
        self._handled = {each.place for each in steps if each.handled}
        self._refused_calls = {
            self.program.phase_of[each.next]
            for each in self.program.instructions
            if isinstance(each, Require) and each.place in self._at({"call.starts_in"})
        } - {
            self.program.phase_of[each.next]
            for each in self.program.instructions
            if isinstance(each, Require) and each.place not in self._at({"call.starts_in"})
        }
        self._triggers = {
            (each.phase, trigger.name): trigger.place
            for each in self.program.instructions
            if isinstance(each, Wait)
            for trigger in each.triggers
        }

    def _at(self, codes: set[str]) -> set[str]:
        return {str(each.place) for each in self.check.findings if each.code in codes}

    def _named(self, code: str) -> set[str]:
        """What findings with this code have between quotes."""
        return {each.message.split("'")[1] for each in self.check.findings if each.code == code}

    def hold(self, run: Run) -> None:
        """The run did nothing but what the check has told."""
        effects = [effect for many in run.effects for effect in many]
        self._hold_commands(effects)
        self._hold_phases(effects)
        self._hold_triggers(run)
        self._hold_ends(effects)
        if self.complete:
            self._hold_situations(run)

    def _hold_commands(self, effects: list[fx.Effect]) -> None:
        told, certain = self._at(REFUSALS), self._at(CERTAIN)
        unneeded = self._at({"step.never_needed"})
        for effect in effects:
            if not isinstance(effect, fx.CommandStatus):
                continue
            if effect.status == "refused" and self.complete:
                impossible = effect.reason.startswith("impossible")
                thought_of = self._expected | (self._handled if impossible else set())
                assert effect.place in told | thought_of, f"not told: {effect}"
            if effect.status in {"sent", "skipped"}:
                assert effect.place not in certain, f"was to be refused: {effect}"
            if effect.status == "sent":
                assert effect.place not in unneeded, f"was not to be needed: {effect}"

    def _hold_phases(self, effects: list[fx.Effect]) -> None:
        entered = {each.phase for each in effects if isinstance(each, fx.PhaseChange)}
        assert not entered & self._named("phase.unreachable"), "was not to be reached"
        assert not entered & self._refused_calls, "a call was to be refused"
        told = {each.message for each in self.check.findings if each.code == "rule.violated"}
        for effect in effects:
            if isinstance(effect, fx.Fault) and effect.code == safety.RULE_BROKEN and self.complete:
                assert effect.message in told, f"not told: {effect}"

    def _hold_triggers(self, run: Run) -> None:
        idle = self._at({"trigger.never", "trigger.shadowed"})
        at_once = self._at({"trigger.at_once"})
        for effects in run.effects:
            armed = {each.phase for each in effects if isinstance(each, fx.WaitArmed)}
            fired = [each for each in effects if isinstance(each, fx.TriggerFired)]
            for each in fired:
                place = self._triggers.get((each.phase, each.trigger), "")
                assert place not in idle, f"was never to fire: {each}"
            for (phase, _), place in self._triggers.items():
                if phase in armed and place in at_once:
                    assert phase in {each.phase for each in fired}, f"did not fire at once: {place}"

    def _hold_ends(self, effects: list[fx.Effect]) -> None:
        unreachable = self._named("end.unreachable")
        for each in effects:
            if not isinstance(each, fx.Ended):
                continue
            assert each.end not in unreachable, f"was not to be reached: {each}"
            if each.outcome == "succeeded":
                assert "mission.no_success" not in self.codes
            if each.message == ROUND_AND_ROUND and self.complete:
                assert "loop.instant" in self.codes

    def _hold_situations(self, run: Run) -> None:
        """Wherever a run gets, the exploration has been."""
        for found in run.situations:
            assert found in self._explored, f"never explored: {found}"
