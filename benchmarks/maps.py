"""How far a map is from the pipe that was driven, when seeds vary.

    python -m benchmarks.maps [--row NAME] [--seeds 10] [--workers 2]

Each seed shifts the start by up to 20 mm, friction by up to 20 % and all diameters by up to 2 mm,
and draws its own noise and its own errors of the detector's words. The map is made of the recording
by `pirate map`, and read as a pipe again. Printed are the worst differences from the driven pipe:
of straights (the first begins at the last wheel's place, the last one ends at the first wheel's, in
truth; a reducer counts at its middle), of radii, of bends' angles, and of their rolls against the
first bend. A map is near within 20 mm and 3 deg in all of these.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from math import degrees, inf, pi, remainder
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.campaign import options_of_rows
from pirate_sm.api import run
from pirate_sm.core.documents import Problems, parse_document
from pirate_sm.core.geometry import Route, RouteJoint
from pirate_sm.core.loading import check_pipe, validate
from pirate_sm.core.models import Body, Pipe
from pirate_sm.lab.mapping.mapper import mapped
from pirate_sm.lab.mapping.pipe_text import pipe_text
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission

NEAR_M, NEAR_DEG = 0.020, 3.0
"""The bar for the house connection."""


@dataclass(frozen=True)
class Row:
    """A mission to be mapped.

    Attributes:
        mission: Its name.
        pipe: Name of a pipe instead of the mission's own.
        barred: Whether the bar holds for it; else the row is only shown.
        detector: Which detector says the words.
    """

    mission: str
    pipe: str | None = None
    barred: bool = False
    detector: str = "sim"

    @property
    def name(self) -> str:
        """Return what is printed, and what ``--row`` takes."""
        named = self.pipe or self.mission
        return named if self.detector == "sim" else f"{named}_by_{self.detector}"


ROWS = (
    Row("house_connection", barred=True),
    Row("house_connection_back"),
    Row("take_elbow"),
    Row("take_elbow_backward"),
    Row("take_bend", "mitre_90_round"),
    Row("take_branch"),
    Row("take_branch_backward"),
    Row("two_bends_up"),
    Row("two_bends_down"),
    Row("take_bend", "mitre_90"),
    Row("take_bend", "mitre_90_tilted"),
    Row("take_bend", "mitre_90_up"),
    Row("take_bend", "mitre_90_down"),
    Row("take_bend", "mitre_90_from_below"),
    Row("take_bend", "mitre_90_from_above"),
    Row("mitre_bend", "mitre_60"),
    Row("mitre_bend", "mitre_45"),
    Row("mitre_bend", "mitre_90_105mm"),
    Row("mitre_bend_backward"),
    Row("mitre_bend", "mitre_90", detector="odometry"),
    Row("house_connection", detector="odometry"),
)


@dataclass(frozen=True)
class Missed:
    """How far a map is from the driven pipe; infinite where they are not of the same joints.

    Attributes:
        lengths_m: Straights, in order: the map's minus the truth.
        radii_m: Radii of elbows.
        angles_deg: Angles of bends.
        rolls_deg: Rolls of bends against the first one.
        notes: What the map says is missing.
    """

    lengths_m: tuple[float, ...] = (inf,)
    radii_m: tuple[float, ...] = ()
    angles_deg: tuple[float, ...] = (inf,)
    rolls_deg: tuple[float, ...] = (inf,)
    notes: tuple[str, ...] = ()

    @property
    def is_near(self) -> bool:
        """Return whether it is within the bar."""
        near = all(abs(each) <= NEAR_M for each in (*self.lengths_m, *self.radii_m))
        return near and all(abs(each) <= NEAR_DEG for each in (*self.angles_deg, *self.rolls_deg))


def main() -> int:
    """Print each row; return 1 when one misses its bar."""
    names = [row.name for row in ROWS]
    wishes = options_of_rows(__doc__, names, 10, "runs of every row").parse_args()
    good = True
    context = get_context("spawn")
    with ProcessPoolExecutor(wishes.workers or cpu_count(), mp_context=context) as pool:
        for row in ROWS:
            if row.name in (wishes.row or names):
                found = list(pool.map(partial(missed_in, row), range(wishes.seeds)))
                _print(row, found)
                good &= not row.barred or all(each.is_near for each in found)
    return 0 if good else 1


def _print(row: Row, found: Sequence[Missed]) -> None:
    """Print what was missed at worst."""
    near = sum(each.is_near for each in found)
    lengths = " ".join(f"{1e3 * each:+.0f}" for each in _worst([it.lengths_m for it in found]))
    radii = " ".join(f"{1e3 * each:+.0f}" for each in _worst([it.radii_m for it in found]))
    angles = " ".join(f"{each:+.1f}" for each in _worst([it.angles_deg for it in found]))
    rolls = " ".join(f"{each:+.1f}" for each in _worst([it.rolls_deg for it in found]))
    print(
        f"{row.name:24} {near:3} of {len(found)} near, at worst: straights {lengths} mm, "
        + (f"radii {radii} mm, " if radii else "")
        + f"angles {angles} deg, rolls {rolls or '-'} deg",
        flush=True,
    )
    for note in sorted({note for each in found for note in each.notes}):
        print(f"    {note}", flush=True)


def _worst(found: Sequence[tuple[float, ...]]) -> list[float]:
    """Return the worst of each place in the pipe; one infinity where maps lack joints."""
    if len({len(each) for each in found}) > 1:
        return [inf]
    return [max(values, key=abs) for values in zip(*found, strict=True)]


def missed_in(row: Row, seed: int, twin: str | None = None) -> Missed:
    """Run a mission, and return how far its map is from the driven pipe."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        run(
            row.mission,
            pipe=row.pipe,
            detector=row.detector,
            seed=seed,
            twin=twin,
            record=path,
            start_jitter_m=0.02,
            friction_jitter=0.20,
            diameter_jitter_m=0.002,
        )
        return missed(read_recording(path))


def missed(recording: Recording) -> Missed:
    """Return how far the map of a recording is from the pipe in it."""
    made = mapped(recording)
    text = pipe_text(made, "found", "run.mcap")
    document = parse_document(text, "found.yaml")
    pipe, problems = validate(document, Pipe), Problems(document)
    check_pipe(pipe, document, problems)
    problems.raise_errors()
    found = pipe.route()
    with recorded_mission(recording.header) as loaded:
        assert loaded.pipe is not None  # it was driven through
        driven = loaded.pipe.route()
        body = loaded.loaded_robot.profile.body
    arcs_m = list(_ends(recording, driven, body))
    from_m, to_m = min(rear for _, rear in arcs_m), max(front for front, _ in arcs_m)
    true = [it for it in driven.joints if from_m < it.arc_m < to_m and _turns(it)]
    seen = [it for it in found.joints if _turns(it)]
    if len(true) != len(seen):
        return Missed(notes=(*made.notes, f"{len(seen)} joints, not {len(true)}"))
    lengths = zip(
        _straights(seen, 0.0, found.length_m), _straights(true, from_m, to_m), strict=True
    )
    bends = [pair for pair in zip(seen, true, strict=True) if pair[1].kind != "reducer"]
    turns = [[remainder(it.towards_rad, 2 * pi) for it in pair] for pair in bends]
    return Missed(
        tuple(here - there for here, there in lengths),
        tuple(_radius(here) - _radius(it) for here, it in bends if it.kind == "elbow"),
        tuple(degrees(here.turn_rad - it.turn_rad) for here, it in bends),
        tuple(
            degrees(remainder(here - turns[0][0] - there + turns[0][1], 2 * pi))
            for here, there in turns[1:]
        ),
        tuple(made.notes),
    )


def _turns(joint: RouteJoint) -> bool:
    return joint.kind == "reducer" or joint.turn_rad != 0.0


def _radius(joint: RouteJoint) -> float:
    """Return the radius of an elbow, m; 0 of a corner."""
    return 2 * joint.behind_m / joint.turn_rad if joint.kind == "elbow" else 0.0


def _straights(joints: Sequence[RouteJoint], from_m: float, to_m: float) -> list[float]:
    """Return the lengths between joints; a corner and a reducer count at one place."""
    ends = [(from_m, from_m)]
    for joint in joints:
        before_m, behind_m = 0.0, 0.0
        if joint.kind == "elbow":
            before_m, behind_m = joint.before_m, joint.behind_m
        elif joint.kind == "reducer":
            before_m, behind_m = -joint.behind_m / 2, joint.behind_m / 2
        ends.append((joint.arc_m - before_m, joint.arc_m + behind_m))
    ends.append((to_m, to_m))
    return [after[0] - before[1] for before, after in pairwise(ends)]


def _ends(recording: Recording, route: Route, body: Body) -> Iterator[tuple[float, float]]:
    """Yield where the first and the last wheel were along the route, in truth."""
    for placed in recorded_places(recording, body):
        heights = placed.space.z_m if placed.space else [0.0] * len(placed.wheels)
        points = [(x, y, z) for (x, y), z in zip(placed.wheels, heights, strict=True)]
        if points:
            yield route.arc_of(points[0]), route.arc_of(points[-1])


if __name__ == "__main__":
    sys.exit(main())
