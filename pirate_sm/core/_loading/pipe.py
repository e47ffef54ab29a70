"""Read pipe files, check that a pipe can be built, and that a robot can clamp in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import degrees, floor, pi, radians
from pathlib import Path

from pirate_sm.core._geometry.chain import height_m
from pirate_sm.core._geometry.network import BRANCH, IN, ON, Network, NetworkRun, Piece, port_of
from pirate_sm.core._geometry.placement import Placement, crossings, place
from pirate_sm.core._geometry.route import crossing, passages_of
from pirate_sm.core._loading.problems import Path as At
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.references import FileKind, refuse_other
from pirate_sm.core._loading.yaml.document import Document, read_document
from pirate_sm.core._loading.yaml.validation import try_validate
from pirate_sm.core._model.pipe import Pipe, PipeFile
from pirate_sm.core._model.pipe_runs import (
    Elbow,
    Mitre,
    Patch,
    PipeRun,
    Reducer,
    Segment,
    Straight,
    Written,
)
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core.spelling import nearest
from pirate_sm.core.units import LENGTH, format_quantity

FOLDING_ROOM_RAD = radians(10.0)
"""Smallest distance of a V's apex joint from its end stop in a pipe that fits.

A V under load folds further than the pipe's walls require, by up to 12 deg in a stuck robot. At its
end stop a V exerts no force on the wall. Of 60 simulated bends, 60 succeeded with 8 deg left, 46
with 6 deg and none with 5 deg (docs/measurements.md).
"""


def load_pipe(path: Path) -> tuple[Pipe, Document]:
    """Return the pipe in a file, and the file's document.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    document = read_document(path)
    problems = Problems(document)
    pipe = try_validate(document, PipeFile, problems)
    if pipe is None:
        refuse_other(document, FileKind.PIPE)
        check_section(document, problems)
    problems.raise_errors()
    assert pipe is not None
    return pipe, document


def reach(profile: Profile) -> tuple[float, float]:
    """Return the smallest and the largest inner diameter that every part can clamp, m.

    The largest is l sin(g/2) + 2r with the apex ``FOLDING_ROOM_RAD`` before its end stop, or fully
    folded if that is nearer (thesis eq. 3-2). At the smallest the wheels alone fill the pipe.
    """
    body = profile.body
    least = 2 * body.wheel_radius
    stops = {joint.name: joint.end_stop for joint in body.joints}
    largest = []
    for name, part in body.parts.items():
        apex = min(max(stops[part.apex] - FOLDING_ROOM_RAD, 0.0), pi)
        largest.append(height_m(min(body.legs_m(name)), apex) + least)
    return least, min(largest)


def check_fit(pipe: Pipe, profile: Profile, document: Document, problems: Problems) -> None:
    """Report why a pipe cannot be built, or why the robot cannot clamp in it."""
    check_pipe(pipe, document, problems)
    check_reach(pipe, profile, document, problems)


def check_reach(pipe: Pipe, profile: Profile, document: Document, problems: Problems) -> None:
    """Report the inner diameters of a pipe in which the robot cannot clamp."""
    at, about = part_of(document), problems.about(document)
    least, largest = reach(profile)
    for path, diameter_m in dict(_diameters(pipe)).items():
        if not least < diameter_m <= largest:
            about.add(
                "pipe.reach",
                (*at, *path),
                f"{profile.robot} cannot clamp an inner diameter of {mm(diameter_m)}",
                expected=f"more than {mm(least)} and at most {mm(largest)}: l sin(g / 2) + 2r with"
                f" the joint {degrees(FOLDING_ROOM_RAD):g} deg before its end stop",
            )


def _diameters(pipe: Pipe) -> Iterator[tuple[At, float]]:
    """Yield the inner diameters of the pipe that routes lead through, with their paths."""
    for name in dict.fromkeys(run for way in pipe.ways.values() for run in way):
        written = pipe.written.get(name)
        if written is None:
            continue
        run, at, first = written
        behind_tee = pipe.runs is None and first > 0
        own = pipe.runs is not None and pipe.runs[name].diameter is not None
        if not behind_tee:
            yield (*at[:-1], "diameter") if own else ("diameter",), run.diameter or pipe.diameter
        elif run.diameter is not None:
            yield (*at, first - 1, "diameter"), run.diameter
        for number, segment in enumerate(run.segments):
            if isinstance(segment, Reducer):
                yield (*at, first + number, "to"), segment.to


def check_pipe(pipe: Pipe, document: Document, problems: Problems) -> None:
    """Report why a pipe cannot be built."""
    at, about = part_of(document), problems.about(document)
    before = len(problems.errors)
    check_section(document, problems)
    if pipe.section == "bars":
        _check_flat(pipe, document, problems)
    network = pipe.network()
    for name, written in pipe.written.items():
        _check_shape(network.runs[name], written, at, about)
    _check_junctions(pipe, network, at, about)
    if len(problems.errors) == before:  # otherwise the pieces have no positions
        _check_space(pipe, network, at, about)
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


def _check_space(pipe: Pipe, network: Network, at: At, problems: Problems) -> None:
    """Report runs that miss their junctions, and pieces of the pipe that overlap."""
    placement = place(network)
    for name, begins, message in placement.misfits:
        key = "from" if begins else "to"
        path = ("runs", name, key) if pipe.runs is not None else pipe.written[name].at
        problems.add("pipe.junction", (*at, *path), message)
    if placement.misfits:
        return
    for one, other in _overlaps(pipe, network, placement):
        problems.add(
            "pipe.crossing",
            (*at, *pipe.path_of(other)),
            f"this runs into {_named(pipe, one)} of the same pipe",
            expected="a pipe that keeps clear of itself",
        )


def _overlaps(pipe: Pipe, network: Network, placement: Placement) -> Iterator[tuple[Piece, Piece]]:
    if pipe.section == "round":
        yield from crossings(network, placement)
    elif (found := crossing(pipe.route())) is not None:
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
    return pipe.route().placement.runs[run][-1].ends_m


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


_SAME_M = 1e-6


def _check_junctions(pipe: Pipe, network: Network, at: At, problems: Problems) -> None:
    """Report ports, ends and routes that do not exist, and diameters that do not fit a tee."""
    if pipe.runs is not None:
        _check_ports(pipe, at, problems)
        _check_routes(pipe, network, at, problems)
    for junction in pipe.tees:
        _check_mouth(pipe, network, junction, at, problems)


def _ports(pipe: Pipe) -> Iterator[tuple[str, str, str]]:
    """Yield name of run, key and port of all beginnings and ends."""
    for name, (run, _, _) in pipe.written.items():
        yield name, "from", run.from_port
        yield name, "to", run.to


def _check_ports(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report ports that are unknown, taken twice, or that nothing is at."""
    count = Counter(port for _, _, port in _ports(pipe))
    known = [*pipe.junctions, *pipe.ends, *count]
    for name, key, port in _ports(pipe):
        path = (*at, "runs", name, key)
        junction, arm = port_of(port)
        tee = junction in pipe.junctions
        if count[port] > (1 if tee or port in pipe.ends else 2):
            problems.add("pipe.junction", path, f"more than one run begins or ends at '{port}'")
        elif (arm and not tee) or (not tee and port not in pipe.ends and count[port] == 1):
            others = [each for each in known if each not in (port, junction)]
            problems.add(
                "pipe.junction",
                path,
                f"there is no junction or end '{junction if arm else port}'",
                expected="a tee in `junctions`, a name in `ends`, or where another run ends",
                suggestion=nearest(junction, others) or "",
            )
    for junction in pipe.junctions:
        for arm in (IN, ON, BRANCH):
            port = f"{junction}.{arm}" if arm else junction
            if not count[port]:
                message = f"no run begins or ends at '{port}'; a stub closes it: a short run to a"
                message += " closed end"
                problems.add("pipe.junction", (*at, "junctions", junction), message, key=True)
    for end in pipe.ends:
        if not count[end]:
            message = f"no run begins or ends at '{end}'"
            problems.add("pipe.junction", (*at, "ends", end), message, key=True)


def _check_routes(pipe: Pipe, network: Network, at: At, problems: Problems) -> None:
    """Report routes through unknown runs or runs that do not meet, and a missing route."""
    assert pipe.runs is not None  # as _check_junctions has seen
    runs = pipe.runs
    if not pipe.routes and len(runs) > 1:
        message = "a network of several runs needs a route: `routes: {NAME: [RUN, RUN]}`"
        problems.add("pipe.route", (*at, "runs"), message, key=True)
    for route, names in pipe.routes.items():
        for number, name in enumerate(names):
            if name not in runs:
                close = nearest(name, list(runs)) or ""
                path = (*at, "routes", route, number)
                problems.add("pipe.route", path, f"there is no run '{name}'", suggestion=close)
        if runs.keys() >= {*names}:
            _check_route(network, route, names, at, problems)
    first = next(iter(pipe.ways.values()))
    begins = pipe.start.run if pipe.start is not None else None
    if begins is not None and begins not in first and runs.keys() >= {*first}:
        message = f"the first route does not lead through '{begins}'"
        problems.add("pipe.route", (*at, "start", "run"), message)


def _check_route(
    network: Network, route: str, names: tuple[str, ...], at: At, problems: Problems
) -> None:
    path = (*at, "routes", route)
    twice = next((n for n, name in enumerate(names) if name in names[:n]), None)
    if twice is not None:
        message = f"the route passes the run '{names[twice]}' twice"
        problems.add("pipe.route", (*path, twice), message)
        return
    try:
        passages_of(network, names)
    except ValueError as error:
        problems.add("pipe.route", path, str(error))


def _check_mouth(pipe: Pipe, network: Network, junction: str, at: At, problems: Problems) -> None:
    """Report a branch that is wider than the run of its tee, and a run that changes there."""
    arms: dict[str, tuple[str, PipeRun, float]] = {}
    for name, (run, _, _) in pipe.written.items():
        diameters = network.runs[name].diameters_m
        for port, diameter_m in ((run.from_port, diameters[0]), (run.to, diameters[-1])):
            if port_of(port)[0] == junction:
                arms[port_of(port)[1]] = (name, run, diameter_m)
    if IN not in arms:
        return
    along_m = arms[IN][2]
    for arm, wrong in ((ON, "has another diameter than"), (BRANCH, "is wider than")):
        if arm not in arms:
            continue
        name, _, diameter_m = arms[arm]
        if diameter_m > along_m + _SAME_M or (arm == ON and diameter_m < along_m - _SAME_M):
            if pipe.runs is not None:
                path: At = ("runs", name, "from")
                message = f"{diameter_m * 1000:.4g} mm here {wrong} the run of the tee '{junction}'"
            else:
                path, message = _inline(pipe, name, diameter_m)
            hint = f"{along_m * 1000:.4g} mm" if arm == ON else f"at most {along_m * 1000:.4g} mm"
            problems.add("pipe.junction", (*at, *path), message, expected=hint)


def _inline(pipe: Pipe, name: str, diameter_m: float) -> tuple[At, str]:
    """Return the place of a tee in a list of segments, by its branch, and what is wrong with it."""
    _, at, first = pipe.written[name]
    tee = at if len(at) > 1 else (*at, first - 1)  # a stub stands where its tee does
    return (*tee, "diameter"), f"a branch of {diameter_m * 1000:.4g} mm is wider than its run"
