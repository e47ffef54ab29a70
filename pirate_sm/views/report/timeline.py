"""Lanes of the timeline: phases, state machines, commands, waits, words and faults."""

from __future__ import annotations

from collections.abc import Sequence

from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core.effects import LaneMark, LaneSpan, MarkKind, SpanKind, with_reason
from pirate_sm.core.engine import SHOWN, Evidence
from pirate_sm.core.spelling import listed
from pirate_sm.views.report.contents import Lane, Span, TimelineMark

PHASE, CONTROL, COMMANDS, WAITS = "phase", "control", "commands", "waits for"
DETECTOR, OPERATOR = "detector", "operator"

_LASTING = {"phase", "state", "unconfirmed", "word"}
"""Spans of these kinds are left out if they are empty, because several can begin together."""


class _Track:
    """A lane under construction, with at most one open span."""

    def __init__(self) -> None:
        self.spans: list[Span] = []
        self.marks: list[TimelineMark] = []
        self._open: Span | None = None

    @property
    def current(self) -> str:
        """Return the text of the open span; empty if there is none."""
        return self._open.text if self._open else ""

    def begin(self, at_s: float, text: str, kind: SpanKind, about: str = "") -> None:
        """End the open span and begin a new one."""
        self.end(at_s)
        self._open = Span(at_s, at_s, text, kind, about)

    def end(self, at_s: float, kind: SpanKind | None = None, about: str = "") -> None:
        """End the open span with this kind and text."""
        if self._open is None:
            return
        span, self._open = self._open._replace(end_s=at_s), None
        if kind is not None:
            span = span._replace(kind=kind, about=about or span.about)
        if span.kind in _LASTING:
            if span.end_s <= span.start_s:
                return
            before = self.spans[-1] if self.spans else None
            if before and before[1:4] == (span.start_s, span.text, span.kind):
                span = self.spans.pop()._replace(end_s=span.end_s)
        self.spans.append(span)

    def add(self, at_s: float, entry: LaneSpan | LaneMark) -> None:
        """Add what an effect declares."""
        if isinstance(entry, LaneMark):
            self.mark(at_s, *entry[1:])
        elif entry.text:
            self.begin(at_s, *entry[1:])
        else:
            self.end(at_s)

    def ended(self, at_s: float) -> _Track:
        """Return a copy whose open span ends here."""
        track = _Track()
        track.spans, track.marks, track._open = [*self.spans], [*self.marks], self._open
        track.end(at_s)
        return track

    def mark(self, at_s: float, text: str, kind: MarkKind, about: str = "") -> None:
        """Add a mark."""
        self.marks.append(TimelineMark(at_s, text, kind, about))


class Timeline:
    """Collects the effects of a run and makes the lanes of its timeline.

    Args:
        regions: Names of the state machines.
        nominal: Whether it is a trace, in which triggers without a sensor were fired by its script.

    Attributes:
        proofs: What has shown the state of each region, after the step that is taken in next.
    """

    def __init__(self, regions: Sequence[str], *, nominal: bool) -> None:
        self._regions = tuple(regions)
        self._nominal = nominal
        states = map(_region, regions)
        names = (
            PHASE,
            *states,
            CONTROL,
            *(COMMANDS, WAITS, "triggers", DETECTOR, "pipe", OPERATOR, "faults"),
        )
        self._tracks = {name: _Track() for name in names}
        self._states: tuple[str, ...] = ()
        self._unconfirmed: tuple[str, ...] = ()
        self.proofs: Sequence[Evidence] = ()

    def take(
        self, at_s: float, cause: object, effects: Sequence[fx.Effect], control: str = ""
    ) -> None:
        """Take in the cause and the effects of one step, and the active control after it.

        The usual control has no name and no span.
        """
        track = self._tracks[CONTROL]
        if control != track.current:
            track.begin(at_s, control, "state") if control else track.end(at_s)
        action = operator_action(cause)
        if action and not (self._nominal and isinstance(cause, ev.Skip)):  # its script does
            self._tracks[OPERATOR].mark(at_s, action, "operator")
        for effect in effects:
            self._take(at_s, effect)

    def _take(self, at_s: float, effect: fx.Effect) -> None:
        tracks = self._tracks
        match effect:
            case fx.CommandStatus():
                self._command(at_s, effect)
            case fx.StateChange():
                self._state(at_s, effect)
            case fx.WaitArmed(phase) if self.phase != phase:  # back from a called mission
                tracks[PHASE].begin(at_s, phase, "phase")
            case fx.PhaseChange() | fx.TriggerFired():
                tracks[WAITS].end(at_s)
            case fx.Ended():
                for track in tracks.values():
                    track.end(at_s)
            case _:
                pass
        if entry := fx.display_of(effect, nominal=self._nominal).entry:
            tracks[entry.lane].add(at_s, entry)

    @property
    def phase(self) -> str:
        """Return the current phase; empty before the first one and after the end."""
        return self._tracks[PHASE].current

    def lanes(self, until_s: float) -> tuple[Lane, ...]:
        """Return the lanes that are not empty, in order; open spans reach to ``until_s``."""
        found = []
        for name, open_track in self._tracks.items():
            track = open_track.ended(until_s)
            if track.spans or track.marks:
                shown = name.removeprefix(_REGION)
                found.append(Lane(shown, tuple(track.spans), tuple(track.marks)))
        return tuple(found)

    def _command(self, at_s: float, it: fx.CommandStatus) -> None:
        track, about = self._tracks[COMMANDS], _about(it)
        match it.status:
            case "sent":
                track.begin(at_s, it.name, "open", about)
            case "done" | "failed" if track.current == it.name:
                track.end(at_s, it.status, about)
            case "skipped" | "refused":
                if track.current == it.name:
                    track.end(at_s, "failed", about)
                track.mark(at_s, it.name, it.status, about)
            case "accepted" | "done" | "failed":
                pass

    def _state(self, at_s: float, it: fx.StateChange) -> None:
        for place, (region, state) in enumerate(zip(self._regions, it.states, strict=True)):
            doubtful = region in it.unconfirmed
            known = bool(self._states) and self._states[place] == state
            if known and doubtful == (region in self._unconfirmed):
                continue
            kind: SpanKind = "unconfirmed" if doubtful else "state"
            about = SHOWN[self.proofs[place].source] if self.proofs else ""
            self._tracks[_region(region)].begin(at_s, state, kind, about)
        self._states, self._unconfirmed = it.states, it.unconfirmed


_REGION = "region "
"""Prefix that distinguishes regions from the other lanes."""


def _region(name: str) -> str:
    return f"{_REGION}{name}"


def _about(it: fx.CommandStatus) -> str:
    place = f" ({it.place})" if it.place else ""
    return f"{with_reason(it.status, it.reason)}{place}"


def operator_action(cause: object) -> str:
    """Return what the operator did, in words; empty if it was not the operator."""
    if isinstance(cause, ev.DetectorWord):
        return f"says {cause.word} on the {cause.by}" if cause.by else ""
    if not isinstance(cause, ev.Request):
        return ""
    by = getattr(cause, "by", "")
    return f"{_asked(cause)} on the {by}" if by else _asked(cause)


def _asked(request: ev.Request) -> str:  # noqa: C901 - one case for each request
    match request:
        case ev.OperatorCommand(command, share):
            return f"commands {command}" + (f" at {share:.0%}" if share != 1.0 else "")
        case ev.Observation():
            return f"says: {request.words}"
        case ev.Answer(choice):
            return f"answers {choice}"
        case ev.Pause():
            return "pauses"
        case ev.Resume(until=until):
            return f"resumes until {until}" if until else "resumes"
        case ev.Breakpoints(at):
            return f"sets breakpoints at {listed(at)}" if at else "clears all breakpoints"
        case ev.Step():
            return "asks for one step"
        case ev.GoTo(phase, until=until):
            return f"hands back at {phase}{f', until {until}' if until else ''}"
        case ev.Skip(trigger):
            return f"passes over {trigger or 'a wait'}"
        case ev.Abort(reason):
            return f"ends the run: {reason}"
