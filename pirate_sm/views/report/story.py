"""The story of a run: the events of each phase, in sentences."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core.spelling import listed
from pirate_sm.views.report.contents import Sentence
from pirate_sm.views.report.phrases import full_stop, seconds, sentence
from pirate_sm.views.report.summary import ENDED, RunEnding
from pirate_sm.views.report.timeline import operator_action

_WORTH_TELLING_S = 0.2
"""The duration of a shorter command is left out, s."""

_MOST_NAMES = 8
"""With more commands than this in a phase, only their number is written."""


class Story:
    """Collects the effects of a run and writes a story, phase by phase.

    Args:
        descriptions: Descriptions of the phases, by name.
        nominal: Whether commands ended after their nominal duration.

    Attributes:
        at_once: The phases whose wait was over as it began, with the reason.
    """

    def __init__(self, descriptions: Mapping[str, str], *, nominal: bool) -> None:
        self.sentences: list[Sentence] = []
        self.counts: dict[str, int] = {}
        self.faults: dict[str, int] = {}
        self.at_once: list[str] = []
        self._descriptions = descriptions
        self._nominal = nominal
        self._phase = ""
        self._began_s = 0.0
        self._commands: list[str] = []
        self._sent_s = 0.0
        self._waits_since: float | None = None
        self._waits_for = ""
        self._place = 0
        self._described = ""

    def take(self, at_s: float, cause: object, effects: Sequence[fx.Effect]) -> None:
        """Take in the cause and the effects of one step."""
        action = operator_action(cause)
        if action and not (self._nominal and isinstance(cause, ev.Skip | ev.Answer)):
            self._add(at_s, f"The operator {action}.", "person")
        for effect in effects:
            self._take(at_s, effect)

    def _take(self, at_s: float, effect: fx.Effect) -> None:
        match effect:
            case fx.PhaseChange():
                self._enter(at_s, effect.phase)
            case fx.WaitArmed():
                self._waits(at_s, effect)
            case fx.TriggerFired():
                self._fired(at_s, effect)
            case fx.CommandStatus():
                self._command(at_s, effect)
            case fx.Fault():
                self._fault(at_s, effect)
            case fx.Log():
                self._log(at_s, effect)
            case fx.Ask():
                self._ask(at_s, effect)
            case _:
                pass

    def finish(self, ending: RunEnding) -> tuple[Sentence, ...]:
        """Return the whole story, in order."""
        self._close(ending.at_s, "")
        words = {**ENDED, "interrupted": "Interrupted after", "fault": "A fault ended it after"}
        opening = words[ending.outcome].removeprefix("It ").capitalize()
        tail = full_stop(f": {ending.message}" if ending.message else "")
        self._add(ending.at_s, f"{opening} {seconds(ending.at_s)}{tail}", "end")
        return tuple(self.sentences)

    def _add(
        self, at_s: float, text: str, kind: Literal["phase", "trouble", "person", "end"]
    ) -> None:
        self.sentences.append(Sentence(at_s, text, kind))

    def _enter(self, at_s: float, phase: str) -> None:
        self._close(at_s, "")
        self._phase, self._began_s, self._place = phase, at_s, len(self.sentences)

    def _close(self, at_s: float, how: str) -> None:
        """Write the sentence about the current phase, before those about its failures."""
        if not self._phase:
            return
        purpose = self._purpose()
        parts = [sentence(f"{purpose}")] if purpose else []
        if self._commands:
            number = len(self._commands)
            names = listed(self._commands) if number <= _MOST_NAMES else f"{number} commands"
            parts.append(sentence(f"{names} done"))
        if self._waits_since is not None:
            waited = f"waited {seconds(at_s - self._waits_since)}"
            parts.append(sentence(f"{waited} {how or f'for {self._waits_for}'}"))
        if parts:
            phase = Sentence(self._began_s, " ".join(parts), "phase", self._phase)
            self.sentences.insert(self._place, phase)
        self._phase, self._commands, self._waits_since = "", [], None

    def _purpose(self) -> str:
        """Return the description of the phase, once; not again behind a called mission."""
        root = self._phase.partition("/")[0]
        if root != self._described and self._phase == root:
            self._described = root
            return self._descriptions.get(root, "")
        return ""

    def _waits(self, at_s: float, it: fx.WaitArmed) -> None:
        if it.phase != self._phase:  # back from a called mission
            self._enter(at_s, it.phase)
        self._waits_since, self._waits_for = at_s, it.condition

    def _fired(self, at_s: float, it: fx.TriggerFired) -> None:
        reason = it.seen(nominal=self._nominal).reason
        if at_s == self._waits_since and not self._nominal:
            self.at_once.append(f"{it.phase} ({reason})")
        self._close(at_s, f"({reason}), then {it.go}")

    def _command(self, at_s: float, it: fx.CommandStatus) -> None:
        if it.status == "sent":
            self._sent_s = at_s
        elif it.status != "accepted":
            self.counts[it.status] = self.counts.get(it.status, 0) + 1
        if it.status == "done":
            lasted = seconds(at_s - self._sent_s)
            self._commands.append(
                f"{it.name} ({lasted})" if at_s - self._sent_s >= _WORTH_TELLING_S else it.name
            )
        elif it.status in ("failed", "refused"):
            why = f": {it.reason}" if it.reason else ""
            after = f" after {seconds(at_s - self._sent_s)}" if it.status == "failed" else ""
            verb = "failed" if it.status == "failed" else "was refused"
            self._add(at_s, f"{it.name} {verb}{after}{full_stop(why)}", "trouble")

    def _fault(self, at_s: float, it: fx.Fault) -> None:
        self.faults[it.code] = self.faults.get(it.code, 0) + 1
        then = {"continue": "The mission went on.", "stop": "The mission was stopped."}
        ending = then.get(it.handling, f"The mission went to {it.handling}.")
        self._add(at_s, f"Fault {it.code}: {full_stop(it.message)} {ending}", "trouble")

    def _log(self, at_s: float, it: fx.Log) -> None:
        kind: Literal["trouble", "phase"] = "phase" if it.level == "info" else "trouble"
        word = "The mission says" if it.level == "info" else it.level.capitalize()
        self._add(at_s, f"{word}: {full_stop(it.message)}", kind)

    def _ask(self, at_s: float, it: fx.Ask) -> None:
        if it.question:
            asked = f"The mission asks “{it.question}” ({it.answers})."
            self._add(at_s, asked, "person")
