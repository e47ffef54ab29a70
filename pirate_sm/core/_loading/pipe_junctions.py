"""Check the names of a network: ports, ends, routes, and what meets at a tee."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from pirate_sm.core._geometry.network import BRANCH, IN, ON, Network, port_of
from pirate_sm.core._geometry.route import passages_of
from pirate_sm.core._loading.problems import Path as At
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.pipe_runs import PipeRun
from pirate_sm.core.spelling import nearest

_SAME_M = 1e-6


def check_junctions(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report ports, ends and routes that do not exist, and diameters that do not fit a tee."""
    if pipe.runs is not None:
        _check_ports(pipe, at, problems)
        _check_routes(pipe, at, problems)
    for junction in pipe.tees:
        _check_mouth(pipe, junction, at, problems)


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


def _check_routes(pipe: Pipe, at: At, problems: Problems) -> None:
    """Report routes through unknown runs or runs that do not meet, and a missing route."""
    assert pipe.runs is not None  # as check_junctions has seen
    runs = pipe.runs
    if not pipe.routes and len(runs) > 1:
        message = "a network of several runs needs a route: `routes: {NAME: [RUN, RUN]}`"
        problems.add("pipe.route", (*at, "runs"), message, key=True)
    network = pipe.network()
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


def _check_mouth(pipe: Pipe, junction: str, at: At, problems: Problems) -> None:
    """Report a branch that is wider than the run of its tee, and a run that changes there."""
    arms: dict[str, tuple[str, PipeRun, float]] = {}
    for name, (run, _, _) in pipe.written.items():
        diameters = pipe.network().runs[name].diameters_m
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
