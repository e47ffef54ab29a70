"""The summary of a run: how it ended, how far it came, its commands and faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

from pirate_sm.core.spelling import listed
from pirate_sm.views.report.phrases import full_stop, number_of, seconds, sentence


class RunEnding(NamedTuple):
    """How a run ended, as far as the recording goes."""

    outcome: Literal["succeeded", "failed", "interrupted", "fault", "unfinished"]
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
        at_once: The waits that were over as they began.
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
    at_once: Sequence[str] = ()


ENDED = {
    "succeeded": "It succeeded after",
    "failed": "It failed after",
    "interrupted": "It was interrupted after",
    "fault": "A fault ended it after",
    "unfinished": "The recording breaks off after",
}


def summary(it: RunFacts) -> tuple[str, ...]:
    """Return the summary as a few sentences."""
    purpose = f" ({_lower(it.description)})" if it.description else ""
    message = f": {it.ending.message}" if it.ending.message else ""
    lines = [
        f"{it.mission}{purpose} ran on {it.robot} {it.where}.",
        f"{ENDED[it.ending.outcome]} {seconds(it.ending.at_s)}{full_stop(message)}",
    ]
    if it.at_once:
        waits = number_of(len(it.at_once), "wait was", "waits were")
        lines.append(f"{waits} over after 0.00 s: {listed(tuple(dict.fromkeys(it.at_once)))}.")
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
    """Return the text as it stands inside a sentence; an acronym keeps its capitals."""
    plain = text.rstrip(".")
    return plain if plain[1:2].isupper() else plain[:1].lower() + plain[1:]
