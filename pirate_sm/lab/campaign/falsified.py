"""Keeps what a search has found: its recording, and a scene that plays it again."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from dataclasses import dataclass

from pirate_sm.core.on_disk import replace_file
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import Recorded, record_chunk
from pirate_sm.lab.campaign.crew import DaskCrew
from pirate_sm.lab.campaign.falsify import FailingChange, is_wrong, values_at
from pirate_sm.lab.campaign.margin_factors import level_of
from pirate_sm.lab.campaign.plan import Cell, command_of
from pirate_sm.lab.campaign.store import Store

_OTHER_SEEDS = 10
"""With so many seeds the change is tried again."""

_LOOK_S = 0.5
_SAID = {
    "failed": "it fails",
    "false": "it says falsely that it has succeeded",
    "bug": "an internal error ends it",
}


@dataclass(frozen=True)
class KeptChange:
    """A change with which a mission does not pass, and where it can be seen.

    Attributes:
        kind: ``failed``, ``false`` or ``bug``.
        size: How large it is: its length, with the range of every factor as 1.
        factors: The value of each factor that is changed, and that of the files.
        why: What came of it.
        seeds: With how many of ten seeds the same comes of it.
        command: Repeats the run.
        recording: Its recording; empty if it could not be kept.
        scene: Plays it again; empty without a recording, and for an internal error.
    """

    kind: str
    size: float
    factors: dict[str, tuple[str, str]]
    why: str
    seeds: int
    command: str
    recording: str
    scene: str

    def lines(self) -> Iterator[str]:
        """Yield it as lines of text."""
        yield f"least change with which {_SAID[self.kind]} (size {self.size:.2f}):"
        for name, (value, nominal) in self.factors.items():
            yield f"    {name} {value} instead of {nominal}"
        yield f"    {self.why}; the same with {self.seeds} of {_OTHER_SEEDS} seeds"
        yield f"    {self.command}"
        if self.recording:
            yield f"    recorded in {shlex.quote(self.recording)}"
        if self.scene:
            yield f"    pirate demo {shlex.quote(self.scene)}"


def keep(found: FailingChange, cell: Cell, store: Store, crew: DaskCrew) -> KeptChange:
    """Record the run of a change, try it with other seeds, write its scene, and return all that.

    Raises:
        BackendError: The workers are lost.
        UsageError: A file cannot be written.
    """
    (seed,) = cell.seeds
    values = values_at(cell.around, found.point)
    level = level_of(cell, values)
    seeds = tuple(range(seed, seed + _OTHER_SEEDS))
    chunk = Chunk(level.key, level.order, level.end, level.mission, seeds)
    rows = [row for each in seeds for row in _done(crew, chunk, each)]
    recorder = crew.doing(record_chunk)
    kind = found.row.verdict
    recorded = [each for each in _done(recorder, chunk, seed) if isinstance(each, Recorded)]
    name = f"least_{kind}"
    recording, scene = store.recordings / f"{name}.mcap", store.folder / f"{name}.yaml"
    command = command_of(level.order, seed)
    kept = bool(recorded and recorded[0].content)
    played = kept and kind != "bug"
    if kept:
        store.keep(recording.name, recorded[0].content)
    if played:
        replace_file(scene, _scene(found, name, command).encode())
    changed = {f.name: (f.written(v), f.written(f.nominal)) for f, v in values.items()}
    wrong = [each for each in rows if isinstance(each, RunRow) and is_wrong(each)]
    alike = sum(each.verdict == kind for each in wrong)
    places = str(recording) if kept else "", str(scene) if played else ""
    return KeptChange(kind, found.size, changed, found.row.why, alike, command, *places)


def _done(crew: DaskCrew, chunk: Chunk, seed: int) -> list[object]:
    """Return what comes of a chunk with one seed."""
    crew.submit(Chunk(chunk.cell, chunk.order, chunk.end, chunk.mission, (seed,)))
    while not (done := crew.wait(_LOOK_S)):
        pass
    return [row for each in done for row in each.rows]


def _scene(found: FailingChange, name: str, command: str) -> str:
    """Return a scene of the gallery, whose JSON is YAML, too."""
    words = command.partition(" ")[2].replace(" --speed max", "")
    row = found.row
    expect = {"exit": 0 if row.verdict == "false" else 1, "ended": row.outcome, "held": row.held}
    said = _SAID[row.verdict]
    scene = {
        "format": 1,
        "scene": name,
        "title": f"The least change that was found with which {said}",
        "look_at": row.why[:1000],
        "steps": [{"command": f"{words} --record {{out}}/run.mcap", "expect": expect}],
    }
    return json.dumps(scene, indent=1) + "\n"
