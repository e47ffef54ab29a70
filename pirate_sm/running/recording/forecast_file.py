"""Earlier runs as a file, their times and bands, and whether they are of the same mission."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePath
from typing import Annotated, NamedTuple

from pydantic import Field, StringConstraints

from pirate_sm.core.documents import read_document
from pirate_sm.core.effects import Effect
from pirate_sm.core.errors import UsageError
from pirate_sm.core.fields import Format, Frozen, Name
from pirate_sm.core.loading import LoadedMission, validate
from pirate_sm.running.recording.format.header import RecordedFile, RunHeader, recorded_files
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.signal_bands import SignalBands
from pirate_sm.running.runtime.phase_times import EarlierRuns, PhaseVisits, Visit

_Sha256 = Annotated[str, StringConstraints(pattern="^[0-9a-f]{64}$")]
_Seconds = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class OfText(Frozen):
    """A text that the runs were made from.

    Attributes:
        role: What it is for a run, such as ``mission`` or ``pipe``.
        name: Name of its file.
        sha256: Its hash, hexadecimal.
    """

    role: str
    name: str
    sha256: _Sha256


class ForecastFile(Frozen):
    """The times of runs that succeeded.

    Attributes:
        format: Version of this format.
        forecast: Name of the mission.
        robot: Name of the robot; ``pipe`` likewise, empty without one.
        backend: What they ran on.
        parameters: The values of the mission's parameters.
        texts: Everything that the mission and its robot were read from.
        runs: Of each run its phases in order, with their times, s.
        signals: The bands of what the plots of a report show; None unless asked for.
    """

    format: Format
    forecast: Name
    robot: str
    pipe: str = ""
    backend: str
    parameters: Mapping[Name, str] = Field(default_factory=dict)
    texts: tuple[OfText, ...]
    runs: tuple[tuple[tuple[str, _Seconds], ...], ...]
    signals: SignalBands | None = None

    @property
    def times(self) -> EarlierRuns:
        """Return what they say about the next run."""
        return EarlierRuns(self.runs, self.backend)

    def text(self) -> str:
        """Return the file's text, which :func:`read_forecast` reads."""
        names = "forecast", "robot", "pipe", "backend", "parameters"
        head = {name: getattr(self, name) for name in names}
        return "\n".join(
            [
                "# How long the phases took in runs that succeeded, by `pirate forecast`.",
                "# A run is compared with them: pirate-run MISSION --forecast FILE",
                "format: 1",
                *(f"{name}: {json.dumps(value)}" for name, value in head.items()),
                "texts:",
                *(f"- {json.dumps(each.model_dump())}" for each in self.texts),
                "runs:",
                *(
                    f"- {json.dumps([(phase, round(took_s, 3)) for phase, took_s in run])}"
                    for run in self.runs
                ),
                *self._lines_of_signals(),
                "",
            ]
        )

    def _lines_of_signals(self) -> Iterator[str]:
        if self.signals is None:
            return
        yield from ("signals:", f"  runs: {self.signals.runs}", "  phases:")
        for each in self.signals.phases:
            yield f"  - phase: {json.dumps(each.phase)}"
            yield from (f"    time: {each.time}", f"    step_s: {each.step_s:g}", "    curves:")
            yield from (f"    - {json.dumps(curve)}" for curve in each.curves)


class CountedRun(NamedTuple):
    """What a recording says for a forecast.

    Attributes:
        header: The set-up of the run.
        visits: Its phases, with their times.
        why_not: Why it does not count; empty if it does.
    """

    header: RunHeader
    visits: Sequence[Visit]
    why_not: str


def counted(recording: Recording) -> CountedRun:
    """Return what a recording says for a forecast.

    Raises:
        RecordingError: It is damaged.
    """
    steps = ((step.effects, step.at_s) for step in recording.effects())
    found = counted_run(recording.header, steps)
    return found._replace(why_not="damaged") if recording.gaps else found


def counted_run(header: RunHeader, steps: Iterable[tuple[Iterable[Effect], float]]) -> CountedRun:
    """Return what a run says for a forecast, from its effects and their times."""
    seen = PhaseVisits()
    for effects, at_s in steps:
        seen.see(effects, at_s)
    why_not = _why_not(header)
    if not why_not and (seen.ended is None or seen.ended.outcome != "succeeded"):
        why_not = "without success"
    return CountedRun(header, seen.visits, why_not)


def _why_not(header: RunHeader) -> str:
    if header.nominal:
        return "a trace, in which nothing moved"
    if header.resumed:
        return "resumed another run"
    if header.options.get("start_phase"):
        return "begun with another phase"
    if header.options.get("defects") or header.options.get("numbers"):
        return "with a defect or other numbers of the robot or the pipe"
    return ""


def forecast_of(header: RunHeader, runs: Iterable[Sequence[Visit]] = ()) -> ForecastFile:
    """Return the forecast from runs with the set-up in this header."""
    return ForecastFile(
        format=1,
        forecast=header.mission,
        robot=header.robot,
        pipe=header.pipe,
        backend=header.backend,
        parameters=dict(header.parameters),
        texts=_texts(header.files),
        runs=tuple(map(tuple, runs)),
    )


def forecast_for(loaded: LoadedMission) -> ForecastFile:
    """Return the forecast of a mission that is to be run, without any run."""
    return ForecastFile(
        format=1,
        forecast=loaded.mission.mission,
        robot=loaded.robot.name,
        pipe=loaded.pipe_name,
        backend="",
        parameters=dict(loaded.parameters),
        texts=_texts(recorded_files(loaded)),
        runs=(),
    )


def _texts(files: Iterable[RecordedFile]) -> tuple[OfText, ...]:
    return tuple(
        OfText(role=each.role, name=PurePath(each.name).name, sha256=each.sha256) for each in files
    )


def unlike(it: ForecastFile, own: ForecastFile) -> str:
    """Return how the set-up of a forecast differs from another one, in words; empty if not at all.

    What the runs were made on may differ: a simulated robot says something about the real one.
    """
    for what, name in (("mission", "forecast"), ("robot", "robot"), ("pipe", "pipe")):
        its, wanted = getattr(it, name), getattr(own, name)
        if its != wanted:
            return f"of the {what} {its or 'none'}, not {wanted or 'none'}"
    theirs, ours = ({(text.role, text.sha256) for text in each.texts} for each in (it, own))
    for text in it.texts:
        if (text.role, text.sha256) not in ours:
            now = next((each.sha256[:12] for each in own.texts if each.role == text.role), "none")
            of = f"of another text of the {text.role}: {text.name}"
            return f"{of} has the SHA-256 {text.sha256[:12]}…, not {now}…"
    if ours - theirs:
        return "of a run without one of the texts"
    return "" if it.parameters == own.parameters else "of runs with other values of parameters"


def read_forecast(path: Path, own: ForecastFile | None = None) -> ForecastFile:
    """Return the forecast in a file.

    Args:
        path: The file.
        own: The set-up of the run that it must be of; None: any.

    Raises:
        LoadError: Everything that is wrong with it.
        UsageError: It is of another kind, of another mission, or of another text of it.
    """
    document = read_document(path)
    if not isinstance(document.data, dict) or "forecast" not in document.data:
        raise UsageError(f"{path} is not a forecast: `pirate forecast` makes one")
    found = validate(document, ForecastFile)
    if own is not None and (why := unlike(found, own)):
        raise UsageError(
            f"the forecast {path} is {why}: `pirate forecast` makes one from runs of this mission"
        )
    return found
