"""A page that lists many runs, with their outcomes and a link to the report of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Literal, TypeAlias

from pirate_sm import __version__
from pirate_sm.core import effects as fx
from pirate_sm.core.models import SIMULATORS
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.views.report.report_page import SIGNS, page_style
from pirate_sm.views.report.story import seconds

Outcome: TypeAlias = Literal[
    "succeeded", "failed", "interrupted", "fault", "unfinished", "unreadable"
]


@dataclass(frozen=True)
class ListedRun:
    """A line of the list.

    Attributes:
        name: Name of its file.
        outcome: How it ended; ``unfinished`` if the recording does not contain the end,
            ``unreadable`` if it cannot be read.
        message: The reason for the outcome, in a sentence.
        link: Link to its report, relative to the list; empty without one.
        began: ISO 8601 with the zone.
        seed: Seed of the simulator; None without random numbers.
        conditions: A coarser fidelity, defects and parameters that the user set, in words.
        faults: Number of reports of each fault, by code.
    """

    name: str
    outcome: Outcome
    message: str = ""
    link: str = ""
    mission: str = ""
    robot: str = ""
    backend: str = ""
    began: str = ""
    seed: int | None = None
    conditions: tuple[str, ...] = ()
    duration_s: float = 0.0
    faults: Mapping[str, int] = field(default_factory=dict)


def listed(recording: Recording, link: str) -> ListedRun:
    """Return the line of a run.

    Args:
        recording: The run; it is read, but not replayed.
        link: Link to its report.

    Raises:
        RecordingError: The recording is damaged.
    """
    faults: Counter[str] = Counter()
    ended: fx.Ended | None = None
    for step in recording.steps():
        for effect in step.effects:
            if isinstance(effect, fx.Fault):
                faults[effect.code] += 1
            elif isinstance(effect, fx.Ended):
                ended = effect
    header = recording.header
    return ListedRun(
        name=recording.path.name,
        outcome=ended.outcome if ended else "unfinished",
        message=ended.message if ended else "The recording breaks off.",
        link=link,
        mission=header.mission,
        robot=header.robot,
        backend=header.backend,
        began=header.began,
        seed=header.options.get("seed", 0) if header.backend in SIMULATORS else None,
        conditions=_conditions(header),
        duration_s=recording.until_s,
        faults=dict(faults),
    )


def unreadable(path: Path, why: str) -> ListedRun:
    """Return the line of a recording that cannot be read."""
    return ListedRun(name=path.name, outcome="unreadable", message=why)


def _conditions(header: RunHeader) -> tuple[str, ...]:
    settings = header.options.get("settings") or {}
    parameters = (f"{name} = {value}" for name, value in settings.items())
    return (*header.coarser, *header.options.get("defects", ()), *parameters)


_SIGNS = {**SIGNS, "unreadable": ("?", "Unreadable")}
_COLUMNS = (
    *("Outcome", "Mission", "Robot", "Backend", "Seed"),
    *("With", "Began", "Duration", "Faults", "Message"),
)


def index_html(runs: Sequence[ListedRun]) -> str:
    """Return the page as HTML, with the newest run first."""
    folder = files("pirate_sm.views.report") / "page"
    newest = sorted(runs, key=lambda each: (each.began, each.name), reverse=True)
    heads = [f'<th scope="col"><button type="button">{name}</button></th>' for name in _COLUMNS]
    return Template((folder / "index.html").read_text("utf-8")).substitute(
        generator=f"pirate-sm {escape(__version__)}",
        title=f"{len(runs)} run{'' if len(runs) == 1 else 's'}",
        style=f"{page_style()}\n{(folder / 'index.css').read_text('utf-8')}",
        outcomes="\n".join(_outcomes(runs)),
        heads="".join(heads),
        rows="\n".join(map(_run_row, newest)),
        script=(folder / "index.js").read_text("utf-8"),
    )


def _outcomes(runs: Sequence[ListedRun]) -> Iterable[str]:
    """Yield a button for each outcome in the list, which shows only the runs with it."""
    counts = Counter[str](run.outcome for run in runs)
    for outcome, (sign, word) in _SIGNS.items():
        if outcome in counts:
            yield (
                f'<button type="button" class="outcome {outcome}" data-outcome="{outcome}" '
                f'aria-pressed="false"><span aria-hidden="true">{sign}</span> '
                f"{counts[outcome]} {word.lower()}</button>"
            )


def _run_row(it: ListedRun) -> str:
    sign, word = _SIGNS[it.outcome]
    ended = f'<span aria-hidden="true">{sign}</span> {word}'
    faults = ", ".join(f"{code}{f' × {n}' if n > 1 else ''}" for code, n in it.faults.items())
    name = escape(it.mission or it.name)
    link = f'<a href="{escape(it.link)}">{name}</a>' if it.link else name
    file = f"<small>{escape(it.name)}</small>" if it.mission else ""
    cells = (
        (f'<span class="outcome {it.outcome}">{ended}</span>', list(_SIGNS).index(it.outcome)),
        (f"<div>{link} {file}</div>", None),
        (escape(it.robot), None),
        (escape(it.backend), None),
        ("" if it.seed is None else str(it.seed), -1 if it.seed is None else it.seed),
        (escape(", ".join(it.conditions)), None),
        (_began(it.began), escape(it.began)),
        (seconds(it.duration_s) if it.began else "", f"{it.duration_s:.3f}"),
        (escape(faults), sum(it.faults.values())),
        (escape(it.message), None),
    )
    tds = (_cell(name, *cell) for name, cell in zip(_COLUMNS, cells, strict=True))
    return f'<tr data-ended="{it.outcome}" title="{escape(it.name)}">{"".join(tds)}</tr>'


def _cell(column: str, text: str, value: object) -> str:
    """Return a cell; ``value`` is its sorting key, None: its text."""
    key = "" if value is None else f' data-value="{value}"'
    return f'<td data-name="{column}"{key}>{text}</td>'


def _began(began: str) -> str:
    """Return the time for people; the whole of it shows on hovering."""
    try:
        read = f"{datetime.fromisoformat(began):%Y-%m-%d %H:%M:%S}"
    except ValueError:  # the header may contain anything
        return escape(began)
    return f'<span title="{escape(began)}">{read}</span>'
