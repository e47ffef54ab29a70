"""Check that a pipe can be built: its runs, where they meet, and what lies along them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import floor

from pirate_sm.core._geometry.network import Network, NetworkRun, Piece
from pirate_sm.core._geometry.placement import crossings, place
from pirate_sm.core._geometry.plane import crossing
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._loading.pipe_junctions import check_junctions
from pirate_sm.core._loading.problems import Path as At
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.pipe_runs import Patch, Written
from pirate_sm.core._model.pipe_segments import Elbow, Mitre, Reducer, Segment, Straight
from pirate_sm.core.units import LENGTH, format_quantity


def check_pipe(pipe: Pipe, document: Document, problems: Problems) -> None:
    """Report why a pipe cannot be built."""
    at, about = part_of(document), problems.about(document)
    before = len(problems.errors)
    check_section(document, problems)
    if pipe.section == "bars":
        _check_flat(pipe, document, problems)
    runs = pipe.network().runs
    for name, written in pipe.written.items():
        _check_shape(runs[name], written, at, about)
    check_junctions(pipe, at, about)
    if len(problems.errors) == before:  # otherwise the pieces have no positions
        _check_space(pipe, at, about)
    if len(problems.errors) == before:
        _check_places(pipe, at, about)


def part_of(document: Document) -> At:
    """Return the path of the pipe in its document, which may be a mission."""
    data = document.data
    return ("pipe",) if isinstance(data, dict) and {"pipe", "phases"} <= data.keys() else ()


def mm(length_m: float) -> str:
    """Return a length for messages."""
    if length_m < 1:
        return f"{length_m * 1000:.4g} mm"
    return format_quantity(length_m, LENGTH)


_ROUND = {"elbow": "an elbow", "reducer": "a reducer", "tee": "a tee"}


def check_section(document: Document, problems: Problems) -> None:
    """Report the parts that only a round pipe can have, whatever else is wrong with the pipe."""
    at = part_of(document)
    data = document.data["pipe"] if at else document.data
    if not isinstance(data, dict) or data.get("section", "bars") != "bars":
        return
    segments = data.get("segments")
    for number, segment in enumerate(segments if isinstance(segments, list) else ()):
        for key in _ROUND.keys() & (segment if isinstance(segment, dict) else ()):
            _leaves(_ROUND[key], ("segments", number), document, problems)
    for key, what in (("runs", "a network of runs"), ("frame", "a frame in space")):
        if data.get(key) is not None:
            _leaves(what, (key,), document, problems)


def _check_flat(pipe: Pipe, document: Document, problems: Problems) -> None:
    """Report the bends and the start of a pipe that leave its plane."""
    if pipe.start is not None and pipe.start.roll:
        _leaves("a roll at the start", ("start", "roll"), document, problems)
    for number, segment in enumerate(pipe.segments or ()):
        if isinstance(segment, Mitre) and segment.roll:
            _leaves("a bend out of the plane", ("segments", number, "roll"), document, problems)


def _leaves(what: str, path: At, document: Document, problems: Problems) -> None:
    """Report what only a round pipe can have, at `section: bars` where that is written."""
    at = part_of(document)
    said = not at and "section" in document.data
    message = f"{what} needs a round pipe: {'write' if said else 'add'} `section: round`"
    place = ("section",) if said else (*at, *path)
    problems.about(document).add("pipe.section", place, message)


def _check_shape(run: NetworkRun, written: Written, at: At, problems: Problems) -> None:
    """Report fittings without a straight beside them, and fittings that cannot be built."""
    segments, path = written.run.segments, (*at, *written.at)
    if isinstance(written.at[-1], int):  # a stub, whose length is in its tee
        _check_stub(run, written, path, problems)
        return
    if not segments:
        behind = (*path, max(written.first - 1, 0))
        problems.add("pipe.segment", behind, "before and behind a tee there is a straight")
    for number in dict.fromkeys((0, len(segments) - 1)) if segments else ():
        if not isinstance(segments[number], Straight):
            message = "a pipe begins and ends with a straight"
            problems.add("pipe.segment", (*path, written.first + number), message)
    for number, (before, after) in enumerate(pairwise(segments), start=1):
        if _touch(before, after):
            message = "between two mitres there is a straight"
            if not (isinstance(before, Mitre) and isinstance(after, Mitre)):
                message = "on either side of a mitre there is a straight"
            problems.add("pipe.segment", (*path, written.first + number), message)
    for number, segment in enumerate(segments):
        cut_m = sum(run.taken_m[max(number - 1, 0) : number + 2])
        for key, message, expected in _unsound(segment, run.diameters_m[number], cut_m):
            where = (*path, written.first + number, key)
            problems.add("pipe.segment", where, message, expected=expected)


def _check_stub(run: NetworkRun, written: Written, path: At, problems: Problems) -> None:
    """Report an arm of a tee that ends inside of the tee."""
    stub, least_m = written.run.segments[0], run.diameters_m[0] / 2
    if isinstance(stub, Straight) and stub.straight <= least_m:
        expected = f"more than {mm(least_m)}, half the diameter"
        message = "this arm ends before it leaves the tee"
        problems.add("pipe.segment", (*path, "stub"), message, expected=expected)


def _unsound(segment: Segment, diameter_m: float, cut_m: float) -> Iterator[tuple[str, str, str]]:
    """Yield the key, what is wrong, and what is expected, of a segment that cannot be built."""
    match segment:
        case Straight(straight=length_m) if length_m <= cut_m:
            message = f"the walls of its mitres meet in a straight of {mm(length_m)}"
            yield "straight", message, f"more than {mm(cut_m)}"
        case Mitre(mitre=0):
            yield "mitre", "a mitre turns by more than 0 deg", ""
        case Elbow(elbow=0):
            yield "elbow", "an elbow turns by more than 0 deg", ""
        case Elbow(radius=radius_m) if radius_m < diameter_m / 2:
            least = f"at least {mm(diameter_m / 2)}, half the diameter"
            yield "radius", "the inner wall of this elbow folds", least
        case Reducer(to=to_m) if to_m == diameter_m:
            yield "to", f"the pipe has {mm(diameter_m)} already", "another diameter"


def _touch(before: Segment, after: Segment) -> bool:
    """Return whether two neighbours need a straight between them: a mitre cuts into straights."""
    one, other = isinstance(before, Mitre), isinstance(after, Mitre)
    return (one and not isinstance(after, Straight)) or (other and not isinstance(before, Straight))


def _check_space(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report runs that miss their junctions, and pieces of the pipe that overlap."""
    network = pipe.network()
    placement = place(network)
    for name, begins, message in placement.misfits:
        key = "from" if begins else "to"
        path = ("runs", name, key) if pipe.runs is not None else pipe.written[name].at
        problems.add("pipe.junction", (*at, *path), message)
    if placement.misfits:
        return
    for one, other in _overlaps(pipe, network):
        problems.add(
            "pipe.crossing",
            (*at, *pipe.path_of(other)),
            f"this runs into {_named(pipe, one)} of the same pipe",
            expected="a pipe that keeps clear of itself",
        )


def _overlaps(pipe: Pipe, network: Network) -> Iterator[tuple[Piece, Piece]]:
    if pipe.section == "round":
        yield from crossings(network, place(network))
    elif (found := crossing(Route(network))) is not None:
        yield found


def _named(pipe: Pipe, piece: Piece) -> str:
    *_, number = pipe.path_of(piece)
    in_run = f" of the run '{piece.run}'" if pipe.runs is not None else ""
    return f"segment {int(number) + 1}{in_run}"


def _check_places(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report what lies beyond the end of the pipe, and patches that overlap."""
    length = pipe.route().length_m
    places = [
        ((*at, "blockages", n, "at"), each.at, length) for n, each in enumerate(pipe.blockages)
    ]
    if pipe.start is not None:
        run = pipe.start.run
        if run is not None and pipe.runs is None:
            message = "a pipe of segments has no runs: leave `run` out"
            problems.add("pipe.route", (*at, "start", "run"), message)
            return
        most = length if run is None else _length_m(pipe, run)
        places.append(((*at, "start", "at"), pipe.start.at, most))
    for name, (run_, _, _) in pipe.written.items():
        prefix = (*at, "runs", name, "patches") if pipe.runs is not None else (*at, "patches")
        most = _length_m(pipe, name)
        places += [((*prefix, n, "to"), each.to, most) for n, each in enumerate(run_.patches)]
        _check_patches(run_.patches, prefix, problems)
    for path, found, most in places:
        if found > most:
            message = f"{mm(found)} is beyond the end of the pipe"
            limit = f"at most {mm(floor(most * 1000) / 1000)}"
            problems.add("pipe.place", path, message, expected=limit)


def _length_m(pipe: Pipe, run: str) -> float:
    """Return the length of a run, m."""
    return place(pipe.network()).runs[run][-1].ends_m


def _check_patches(patches: Sequence[Patch], prefix: At, problems: Problems) -> None:
    """Report patches that overlap or end before they begin."""
    free_from = 0.0
    for n, patch in sorted(enumerate(patches), key=lambda each: each[1].from_m):
        path = (*prefix, n, "to" if patch.to <= patch.from_m else "from")
        if patch.to <= patch.from_m:
            problems.add("pipe.place", path, f"the patch ends at or before {mm(patch.from_m)}")
        elif patch.from_m < free_from:
            problems.add("pipe.place", path, f"{mm(patch.from_m)} lies in another patch")
        free_from = max(free_from, patch.to)
