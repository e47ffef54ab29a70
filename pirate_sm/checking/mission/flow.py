"""Rules about time and order: limits never over, counting, resuming, faults again, late clamps."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from math import asin, atan, inf, isinf

from pirate_sm.checking.exploring.exploration import Exploration, ExploredStep
from pirate_sm.checking.exploring.explore import MOST_WORK
from pirate_sm.checking.findings import Finding, at
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView
from pirate_sm.checking.plans.phase_entry import refused_from
from pirate_sm.core.documents import Path, Place
from pirate_sm.core.expressions import tree
from pirate_sm.core.geometry import dot
from pirate_sm.core.mission import Mission, Phase, WaitStep, every_step
from pirate_sm.core.program import Do, Program, Question, Wait, successors
from pirate_sm.core.robot import RobotSpec, RobotState, robot_state

_MOST_BODIES = 4
"""In how many states of a phase its `resume` is tried [decided]; all share one limit of work."""


def beyond_the_limit(view: MissionView) -> Iterator[Finding]:
    """Yield times in the mission's own file that are longer than the whole mission may take."""
    loaded, places = view.loaded, view.places
    limit_s = loaded.program.time_limit_s
    if isinf(limit_s):
        return
    withins = _withins(loaded.mission, places)
    reported = set[Place]()
    for it in loaded.program.instructions:
        found = list[tuple[Place, str, float]]()
        if isinstance(it, Wait):
            place = places.read(it.place)
            found += [(withins.get(it.place, place), "`within`", it.within_s)]
            found += [(places.read(t.place), "`after`", t.after_s or 0.0) for t in it.triggers]
        elif isinstance(it, Do | Question) and it.place:
            place = places.read(it.place)
            found += [(withins.get(it.place, place), "this timeout", it.timeout_s or 0.0)]
        for place, what, time_s in found:
            own = place.file == loaded.documents[0].name and place not in reported
            if own and limit_s < time_s < inf:
                reported.add(place)
                message = f"{what} of {time_s:g} s is never over: the mission lasts {limit_s:g} s"
                yield places.finding(place, "limit.beyond", message)


def _withins(mission: Mission, places: MissionPlaces) -> dict[str, Place]:
    """Return the place of each `within` by that of its wait, of each `timeout` by its step's."""
    found = {}
    for name, phase in mission.phases.items():
        waits: list[tuple[Path, Phase | WaitStep]] = [(("phases", name), phase)]
        for step, path in every_step(phase.do, ("phases", name, "do")):
            if isinstance(step, WaitStep):
                waits.append((path, step))
            elif getattr(step, "timeout", None) is not None:
                found[str(places.of(path))] = places.of((*path, "timeout"))
        for path, each in waits:
            if each.within is not None:
                found[str(places.of((*path, "wait")))] = places.of((*path, "within", "time"))
    return found


def counts_what_was_counted(view: MissionView) -> Iterator[Finding]:
    """Yield waits that count on a change which no wait before them has counted."""
    loaded, places = view.loaded, view.places
    waits = {n: it for n, it in enumerate(loaded.program.instructions) if isinstance(it, Wait)}
    changes = loaded.robot.vocabulary.with_changes.numbers[len(loaded.robot.vocabulary.numbers) :]
    used = {number: _used(it, set(changes)) for number, it in waits.items()}
    known = _counted_before(loaded.program, used)
    for number, it in waits.items():
        place, counted = places.read(it.place), known[number]
        if not it.counts_on or place.file != loaded.documents[0].name:
            continue
        for name in sorted(used[number] - counted) if counted else ():  # else from its beginning
            others = " and ".join(sorted(counted))
            message = f"it counts on {name}, and the waits before it have counted {others}"
            yield places.finding(place, "wait.counts_on", message)


def _used(it: Wait, names: set[str]) -> set[str]:
    nodes = (t.condition.tree for t in it.triggers if t.condition is not None)
    return {e.name for node in nodes for e in tree.walk(node) if isinstance(e, tree.Signal)} & names


def _counted_before(program: Program, used: Mapping[int, set[str]]) -> Mapping[int, set[str]]:
    """Return for each instruction the changes that waits count which can lead to it."""
    found = defaultdict[int, set[str]](set)
    waiting = [at for at, names in used.items() if names]
    while waiting:
        at = waiting.pop()
        counted = found[at] | used.get(at, set())
        for target in successors(program, at):
            if target >= 0 and not counted <= found[target]:
                found[target] |= counted
                waiting.append(target)
    return found


def resumes_in_vain(view: MissionView) -> Iterator[Finding]:
    """Yield phases that resume in a phase whose commands are refused then."""
    loaded, left = view.loaded, float(MOST_WORK)
    phases = loaded.mission.phases.items()
    elsewhere = {n: p.resume for n, p in phases if p.resume not in ("here", "never", n)}
    bodies = _resting(view) if elsewhere else {}
    known = dict[tuple[str, RobotState], str]()
    for name, resume in elsewhere.items():
        why = ""
        for body in bodies.get(name, {}).values():
            if (resume, body) not in known:
                known[resume, body], work = refused_from(loaded, resume, body, left)
                left -= work
            why = known[resume, body]
            if not why:
                break
        if why:
            message = f"'{resume}' cannot continue from here: {why}"
            place = view.places.of(("phases", name, "resume"))
            yield view.places.finding(place, "resume.refused", message)


def _resting(view: MissionView) -> Mapping[str, Mapping[tuple[int, int], RobotState]]:
    """Return for each phase some states of the robot in it, as it stands once it is cut off."""
    found = defaultdict[str, dict[tuple[int, int], RobotState]](dict)
    phase_of = view.loaded.program.phase_of
    for node in view.explored[0].found.nodes:
        body, at = node.state.robot, node.state.mission.pc
        if 0 <= at < len(phase_of):
            bodies, key = found[phase_of[at]], (body.configuration, body.control)
            if len(bodies) < _MOST_BODIES and key not in bodies:
                rest = body.at_rest()._replace(control=body.control, next_id=1)
                bodies[key] = rest
    return found


def faults_again(view: MissionView) -> Iterator[Finding]:
    """Yield lines of `on_fault` after which the robot drives on as it did when the fault came."""
    loaded, again, fine = view.loaded, dict[str, str](), set[str]()
    for found in (book.found for book in view.explored):
        after: dict[int, list[int]] = {}
        for each in found.steps:
            if not each.went_wrong:
                after.setdefault(each.source, []).append(each.target)
        for step in found.steps:
            if step.move.kind != "fault" or step.source < 0:
                continue
            handlers = found.program.handlers[found.nodes[step.source].state.mission.pc]
            for line in (h for h in handlers if h.code == step.move.word and h.go is not None):
                goes = found.program.phase_of[line.go or 0]
                if _drives_on(found, step, goes, after):
                    again.setdefault(line.place, line.code)
                else:
                    fine.add(line.place)
    for text, code in again.items():
        place = view.places.read(text)
        if text not in fine and place.file == loaded.documents[0].name:
            message = f"after '{code}' the robot drives on as before, so that it comes up again"
            yield view.places.finding(place, "handler.again", message)


@lru_cache(maxsize=8)
def _driving(robot: RobotSpec) -> frozenset[int]:
    """Return the commands that begin to drive wheels or stop them."""
    return frozenset(
        command
        for before, row in enumerate(robot.table.following)
        for command, target in enumerate(row)
        if bool(robot.driven[before]) != bool(robot.driven[target])
    )


def _drives_on(
    found: Exploration, fault: ExploredStep, phase: str, after: Mapping[int, Sequence[int]]
) -> bool:
    """Return whether after a fault nothing but driving comes before the next wait, on every way."""
    was = found.nodes[fault.source].state.robot
    seen, waiting, again = set[int](), [fault.target], False
    while waiting:
        node = waiting.pop()
        mission, body = found.nodes[node].state.mission, found.nodes[node].state.robot
        if body.motion is not None and body.motion.command not in _driving(found.robot):
            return False
        if mission.diverting is None and found.program.phase_of[mission.pc] != phase:
            continue  # after the phase that handles it
        if mission.begun and isinstance(found.program.instructions[mission.pc], Wait):
            same = (body.configuration, body.control) == (was.configuration, was.control)
            if not same or not found.robot.driven[body.configuration]:
                return False
            again = True
        elif found.nodes[node].over:
            return False
        else:
            waiting += [each for each in after.get(node, ()) if each not in seen]
            seen.update(after.get(node, ()))
    return again


def rises_while_loose(mission: MissionView) -> Iterator[Finding]:
    """Report a pipe that rises before any part of the robot can hold it."""
    view = mission.in_pipe
    turns = view.pipe.turns if view is not None else None
    if view is None or turns is None:
        return
    loose_s = _loose_until_s(mission)
    if loose_s <= turns.from_s:
        return
    until_s = min(loose_s, turns.to)
    up = view.fit.ups(until_s)[-1]
    slopes = (abs(dot(up, each.frame.ahead)) for each in view.fit.route.pieces)
    slope_rad = asin(min(max(slopes), 1.0))
    if slope_rad > atan(view.fit.friction):
        message = (
            f"the pipe turns from {turns.from_s:g} s on, and no part of the robot holds before"
            f" {loose_s:.3g} s: it slides"
        )
        fix = "clamp before, or let the pipe turn later"
        own = view.loaded.documents[0]
        related = [(view.place_in_pipe(("turns",)), "it turns here")]
        place = own.place_of(("pipe",))
        yield at(own, place, "geometry.loose", message, fix=fix, related=related)


def _loose_until_s(mission: MissionView) -> float:
    """Return when a part can hold at the earliest, with nominal durations; else the last time."""
    nodes = [node for book in mission.explored for node in book.found.nodes]
    robot = mission.loaded.robot
    holds = [node.now for node in nodes if robot_state.confirmed_parts(robot, node.state.robot)]
    return min(holds, default=max(node.now for node in nodes))
