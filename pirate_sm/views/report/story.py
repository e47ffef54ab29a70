"""The words of a report: the events of each phase in sentences, and the summary of the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import Literal, NamedTuple

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core.spelling import listed
from pirate_sm.views.report.contents import Outcome, Sentence
from pirate_sm.views.report.timeline import operator_action

# --- phrases ------------------------------------------------------------------------------------


def seconds(duration_s: float) -> str:
    """Return a duration in words: ``0.52 s``, ``12.3 s``, ``4 min 05 s``."""
    if duration_s >= 119.5:
        minutes, rest = divmod(round(duration_s), 60)
        return f"{minutes} min {rest:02d} s"
    return f"{duration_s:.2f} s" if duration_s < 9.95 else f"{duration_s:.1f} s"


def number_of(count: int, one: str, more: str) -> str:
    """Return a number with the singular or the plural of a word."""
    return f"{count} {one if count == 1 else more}"


def sentence(text: str) -> str:
    """Return the text with a capital first letter and a full stop."""
    return full_stop(text[:1].upper() + text[1:])


def full_stop(text: str) -> str:
    """Return the text with a full stop, unless it ends a sentence already."""
    return text if text.endswith((".", "!", "?", "…")) else f"{text}."


# --- the summary --------------------------------------------------------------------------------


class RunEnding(NamedTuple):
    """How a run ended, as far as the recording goes."""

    outcome: Outcome
    message: str
    at_s: float


class RunFacts(NamedTuple):
    """The facts of a run for its summary.

    Attributes:
        where: Its pipe, backend and seed, in words.
        odometer_m: Final reading of the odometer, None without one.
        moved_m: True distance of the robot, None if unknown.
        counts: Number of commands for each final status.
        faults: Number of reports of each fault, by code.
    """

    mission: str
    description: str
    robot: str
    where: str
    ending: RunEnding
    odometer_m: float | None
    moved_m: float | None
    counts: Mapping[str, int]
    faults: Mapping[str, int]


ENDED = {
    "succeeded": "It succeeded after",
    "failed": "It failed after",
    "interrupted": "It was interrupted after",
    "fault": "A fault ended it after",
    "unfinished": "The recording breaks off after",
    "running": "It has run for",
}


def summary(it: RunFacts) -> tuple[str, ...]:
    """Return the summary as a few sentences."""
    purpose = f" ({_lower(it.description)})" if it.description else ""
    message = f": {it.ending.message}" if it.ending.message else ""
    lines = [
        f"{it.mission}{purpose} ran on {it.robot} {it.where}.",
        f"{ENDED[it.ending.outcome]} {seconds(it.ending.at_s)}{full_stop(message)}",
    ]
    ways = []
    if it.moved_m is not None:
        back = "back " if round(it.moved_m, 2) < 0 else ""
        ways.append(f"the robot came {back}{abs(it.moved_m):.2f} m along the pipe")
    if it.odometer_m is not None:
        ways.append(f"its odometer counted {it.odometer_m:z.2f} m")
    if ways:
        lines.append(sentence(" and ".join(ways)))
    lines.append(sentence(_counted(it.counts)))
    if it.faults:
        codes = [f"{code}{f' ({n} times)' if n > 1 else ''}" for code, n in it.faults.items()]
        faults = number_of(sum(it.faults.values()), "fault was", "faults were")
        lines.append(f"{faults} reported: {listed(codes)}.")
    return tuple(lines)


def _counted(counts: Mapping[str, int]) -> str:
    words = {"done": "done", "failed": "failed", "refused": "refused", "skipped": "not needed"}
    parts = [f"{counts[key]} {word}" for key, word in words.items() if counts.get(key)]
    total = sum(counts.get(key, 0) for key in words)
    if not total:
        return "no command was given"
    if counts.get("done") == total:
        return f"{number_of(total, 'command was', 'commands were')} given and done"
    return f"{number_of(total, 'command was', 'commands were')} given: {listed(parts)}"


def _lower(text: str) -> str:
    """Return the text as it is written inside a sentence; an acronym keeps its capitals."""
    plain = text.rstrip(".")
    return plain if plain[1:2].isupper() else plain[:1].lower() + plain[1:]


# --- the story ----------------------------------------------------------------------------------


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
        at_once: The waits that were over as they began, with the reason.
    """

    def __init__(self, descriptions: Mapping[str, str], *, nominal: bool) -> None:
        self.sentences: list[Sentence] = []
        self.counts: dict[str, int] = {}
        self.faults: dict[str, int] = {}
        self.at_once: list[Sentence] = []
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
        """Return the whole story so far, in order."""
        done = copy(self)
        done.sentences = [*self.sentences]
        return done._end(ending)

    def _end(self, ending: RunEnding) -> tuple[Sentence, ...]:
        self._close(ending.at_s, "")
        if ending.outcome == "running":
            return tuple(self.sentences)
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
        """Return the description of the phase, once; not again after a called mission."""
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
            text = f"The wait was over after 0.00 s ({reason})."
            self.at_once.append(Sentence(at_s, text, "trouble", it.phase))
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
