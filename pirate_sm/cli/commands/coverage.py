"""`pirate coverage`: says which branches of missions were ever taken, and rehearses the others."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path

from pirate_sm.api import read
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.project_files import find_targets
from pirate_sm.cli.errors import say
from pirate_sm.cli.options.checks import CoverageOptions
from pirate_sm.cli.options.declaring import read_settings
from pirate_sm.cli.output.files import is_recording, refuse_losses, write_and_name
from pirate_sm.cli.output.terminal import progress, writable
from pirate_sm.cli.settings import runs
from pirate_sm.core.branches import branches
from pirate_sm.core.documents import FileKind
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.on_disk import is_folder
from pirate_sm.core.program import BranchKey
from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.plan import varied
from pirate_sm.lab.coverage.coverage_text import as_json, as_lcov, as_page, as_text
from pirate_sm.lab.coverage.evidence import (
    Evidence,
    evidence_of,
    names_of_commands,
    played,
    possible_in,
    taken_in,
)
from pirate_sm.lab.coverage.file_coverage import Coverage
from pirate_sm.lab.coverage.missing import rehearsals, write_scene, written_files
from pirate_sm.running.recording.format.header import RecordedFile, recorded_files
from pirate_sm.running.wiring import Order

ENOUGH, TOO_FEW = 0, 1


@dataclass(frozen=True)
class _Target:
    """A mission whose branches count; its order is that of a run, as the files say."""

    order: Order
    loaded: LoadedMission
    files: Sequence[RecordedFile]
    found: Exploration


def measure_coverage(options: CoverageOptions) -> int:
    """Print which branches were taken; return the exit code, which says whether they are enough.

    Raises:
        LoadError: A mission or a campaign has faults.
        UsageError: There is neither a mission nor a recording, or a file cannot be written.
    """
    places = [str(runs())] if options.paths is None and runs() else options.paths or ()
    recordings = sorted(set(_recordings(map(Path, places))))
    refuse_losses([options.html, options.lcov], inputs=recordings, overwrite=options.overwrite)
    coverage, targets = Coverage(), dict[Path, _Target]()
    missions, campaigns = _files(options.paths)
    with progress("exploring missions") as watch:
        for number, path in enumerate(missions):
            watch(number / len(missions))
            targets[path] = _declared(coverage, _order(path, options), _loaded(path, options))
    _rehearse(coverage, [*targets.values()], campaigns, options.rehearse)
    _count(coverage, recordings, declares=not (missions or campaigns))
    if not coverage.files:
        raise UsageError("there is neither a mission nor a recording there that can be read")
    if options.write_missing is not None:
        _write_missing(coverage, targets, options.write_missing, options)
    _report(coverage, options, with_lines=options.lines or len(missions) == 1)
    share = coverage.share(options.evidence).percent
    return TOO_FEW if share < options.at_least else ENOUGH


def _recordings(places: Iterable[Path]) -> Iterator[Path]:
    for place in places:
        if is_folder(place):
            yield from place.rglob("*.mcap")
        elif place.suffix == ".mcap" or is_recording(place):
            yield place


def _files(paths: list[str] | None) -> tuple[list[Path], list[Path]]:
    """Return the missions and campaigns at these paths; without any those of the project."""
    others = [each for each in paths or () if not [*_recordings([Path(each)])] or is_folder(each)]
    found = find_targets(others).targets if others or not paths else ()
    kinds = (FileKind.MISSION, FileKind.CAMPAIGN)
    missions, campaigns = ([each.path for each in found if each.kind is kind] for kind in kinds)
    return missions, [each for each in campaigns if paths]


def _order(path: Path, options: CoverageOptions) -> Order:
    settings = read_settings(options.settings)
    return Order(shown(path), robot=options.robot, pipe=options.pipe, settings=settings)


def _loaded(path: Path, options: CoverageOptions) -> LoadedMission:
    settings = read_settings(options.settings)
    return load_mission(path, robot=options.robot, pipe=options.pipe, settings=settings)


def _declared(coverage: Coverage, order: Order, loaded: LoadedMission) -> _Target:
    """Return a mission after its branches are declared, and those counted that are possible."""
    files = recorded_files(loaded)
    coverage.declare(loaded, files)
    found, taken = possible_in(loaded)
    coverage.count(taken, loaded.robot.name, files, "model", "the check")
    return _Target(order, loaded, files, found)


def _rehearse(
    coverage: Coverage, targets: Sequence[_Target], campaigns: Sequence[Path], seeds: int
) -> None:
    """Run missions and the cells of campaigns in the simulator, and count what they take."""
    planned = [
        (replace(each.order, seed=seed), each.loaded)
        for each in targets
        if each.loaded.pipe is not None
        for seed in range(seeds)
    ]
    for path in campaigns:
        plan = read_campaign(path, range(seeds) if seeds else None, check=False)
        missions = {key: pickle.loads(each) for key, each in plan.missions.items()}
        for cell in plan.cells:
            target = _declared(coverage, cell.order, missions[cell.mission])
            runs_of_cell = [*cell.seeds][:seeds] if cell.design is None else []
            planned += [(varied(cell, seed, {}), target.loaded) for seed in runs_of_cell]
    with progress("rehearsing in the simulator") as watch:
        for number, (order, loaded) in enumerate(planned):
            watch(number / len(planned))
            run = played(order, loaded).run
            source = " ".join(["run", *replace(order, check=True).command()])
            files = run.header.files
            coverage.count(taken_in(run), loaded.robot.name, files, evidence_of(run.header), source)


def _count(coverage: Coverage, recordings: Sequence[Path], *, declares: bool) -> None:
    """Count what recorded runs have taken.

    Args:
        coverage: The coverage.
        recordings: The recordings.
        declares: Whether their own missions are those of which branches count.
    """
    known = set[tuple[str, ...]]()
    with progress("reading recordings") as watch:
        for number, path in enumerate(recordings):
            watch(number / len(recordings))
            name = visible(shown(path))
            try:
                run = read(path)
                texts = tuple(each.sha256 for each in run.header.files)
                if declares and texts not in known:
                    known.add(texts)
                    coverage.declare(run.loaded, run.header.files)
                    _, possible = possible_in(run.loaded)
                    robot = run.loaded.robot.name
                    coverage.count(possible, robot, run.header.files, "model", "the check")
                taken, robot = taken_in(run), run.loaded.robot.name
                by = evidence_of(run.header)
                if not coverage.count(taken, robot, run.header.files, by, name):
                    coverage.others.append(f"{name}: of no mission here, or of another text of it")
                elif taken.differs_s < inf:
                    why = f"its replay differs at {taken.differs_s:.3f} s; counted up to there"
                    coverage.others.append(f"{name}: {why}")
            except RecordingError as error:
                coverage.others.append(f"{name}: {error}")


# --- rehearsals of what no run has taken ----------------------------------------------------------


def _write_missing(
    coverage: Coverage, targets: Mapping[Path, _Target], folder: Path, options: CoverageOptions
) -> None:
    """Find runs that take what no run has taken, count them, and write them as scenes.

    Raises:
        UsageError: The folder is not writable, or a scene or a script there would be lost.
    """
    written = [each for path in targets for each in written_files(folder, path)]
    refuse_losses(written, overwrite=options.overwrite)
    for path, target in targets.items():
        known = branches(target.loaded.program, names_of_commands(target.loaded))
        untaken, untraced = (
            {key for key in known if not _taken(coverage, target, key, least)}
            for least in ("simulated", "trace")
        )
        kept = []
        with progress(f"looking for runs of {visible(path.stem)}") as watch:
            plain, loaded, found = target.order, target.loaded, target.found
            for each in rehearsals(plain, loaded, untaken, untraced, found, options.tries, watch):
                kept.append(each)
                by = evidence_of(each.played.run.header)
                source = f"rehearsal {len(kept)} of {path.stem}"
                coverage.count(each.taken, loaded.robot.name, target.files, by, source)
        if kept:
            try:
                scene = write_scene(folder, path, loaded, kept)
            except OSError as error:
                raise UsageError(f"'{folder}' cannot be written: {error.strerror}") from None
            say(f"{scene}: steps: {len(kept)}; pirate demo {scene} plays them")
    for file, branch in coverage.missing("trace"):
        say(f"{file.name}:{branch.line}: no run was found that takes {branch.it.words}")


def _taken(coverage: Coverage, target: _Target, key: BranchKey, least: Evidence) -> bool:
    branch = coverage.branch(key, target.files)
    return branch is None or branch.taken(least)


# --- the report -----------------------------------------------------------------------------------


def _report(coverage: Coverage, options: CoverageOptions, *, with_lines: bool) -> None:
    least = options.evidence
    for each in coverage.others:
        say(each)
    if options.html is not None:
        write_and_name(options.html, as_page(coverage, least))
    if options.lcov is not None:
        write_and_name(options.lcov, as_lcov(coverage, least))
    if options.format == "json":
        sys.stdout.write(as_json(coverage, least) + "\n")
    else:
        for line in as_text(coverage, least, with_lines=with_lines):
            print(writable(visible(line)))
