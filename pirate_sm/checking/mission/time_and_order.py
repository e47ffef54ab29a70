"""Rules about time and order: limits, timeouts, counting, faults and their handlers, resuming."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from heapq import heappop, heappush
from math import asin, atan, inf, isinf

from pirate_sm.checking.actuation_in_force import Actuated, InForce, too_slow, too_strong
from pirate_sm.checking.exploring.exploration import Exploration, Explored, ExploredStep
from pirate_sm.checking.exploring.explore import MOST_WORK
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView
from pirate_sm.checking.plans import refused_from
from pirate_sm.core.documents import Path, Place
from pirate_sm.core.expressions import tree
from pirate_sm.core.geometry import dot
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import CONTROL_WITHIN_S, Mission, Phase, WaitStep, every_step
from pirate_sm.core.program import Do, Program, Question, SwitchControl, Wait
from pirate_sm.core.robot import RobotSpec, RobotState, confirmed_parts

# --- order ---------------------------------------------------------------------------------------


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
        for target in program.successors(at):
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
    """Return for each phase some states of the robot in it, as it is once it is cut off."""
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
    holds = [node.now for node in nodes if confirmed_parts(robot, node.state.robot)]
    return min(holds, default=max(node.now for node in nodes))


# --- time limits ---------------------------------------------------------------------------------


def time_limits(view: MissionView) -> Iterator[Finding]:
    """Yield findings about the times in a mission's own file."""
    books, loaded, places = view.explored, view.loaded, view.places
    force = InForce(loaded.loaded_robot.profile, loaded.robot)
    reported: set[str] = set()
    for each in loaded.program.instructions:
        if not isinstance(each, Do | Question | SwitchControl) or each.place in reported:
            continue
        if places.read(each.place).file != loaded.documents[0].name:
            continue
        reported.add(each.place)
        place = places.read(each.place)
        if isinstance(each, Do):
            severity, message = _timeout(each, loaded)
            if not message:
                severity, message = _never_done(each, view)
            if message:
                yield places.finding(place, "step.timeout", message, severity=severity)
        elif isinstance(each, SwitchControl):
            if each.timeout_s < (least_s := force.winds_s(each.control)):
                took = f"a motor takes {least_s:.2g} s to wind its spring to the torque"
                which = "default timeout" if each.timeout_s == CONTROL_WITHIN_S else "timeout here"
                message = f"{took}, and the {which} is {each.timeout_s:g} s"
                yield places.finding(place, "step.timeout", message)
        elif isinf(each.timeout_s) and isinf(loaded.program.time_limit_s):
            message = "neither the question nor the mission has a time limit"
            yield places.finding(place, "ask.unbounded", message)
    yield from _limit(books, loaded, places)


def _timeout(it: Do, loaded: LoadedMission) -> tuple[Severity, str]:
    """Return severity and message if a command's timeout is too short; an empty message if not."""
    spec = loaded.robot.commands[it.command]
    for_s = spec.done.for_s
    if it.timeout_s is None:
        return Severity.WARNING, ""
    if it.timeout_s <= for_s:
        message = (
            f"{spec.name} is done when its criterion has held for {for_s:g} s, but its timeout "
        )
        return Severity.ERROR, f"{message}here is {it.timeout_s:g} s: it always fails"
    if it.timeout_s < spec.nominal_s:
        message = (
            f"{spec.name} usually takes {spec.nominal_s:g} s, but its timeout here is "
            f"{it.timeout_s:g} s"
        )
        return Severity.WARNING, message
    return Severity.WARNING, ""


def _never_done(it: Do, view: MissionView) -> tuple[Severity, str]:
    """Return the same for a command that is never done under a control that is active at its step.

    That of the usual actuation is a fault of the robot and reported there.
    """
    robot, spec = view.loaded.robot, view.loaded.robot.commands[it.command]
    force = InForce(view.loaded.loaded_robot.profile, robot)
    led = _led(it, view)
    faults = []
    for control in {each.control for each in led} - {0}:
        there = [each for each in led if each.control == control]
        faults.append(too_strong(force, spec.done, there) or too_slow(force, spec.done, there))
    if not any(faults):
        return Severity.WARNING, ""
    always = all(faults) and all(each.control for each in led)
    message = f"{spec.name} cannot be seen to be done: {max(faults)}"
    return Severity.ERROR if always else Severity.WARNING, message


def _led(it: Do, view: MissionView) -> set[Actuated]:
    """Return where the step leads to, each with the active control."""
    found = set()
    for book in view.explored:
        for number in book.visits[it.place].given if it.place in book.visits else ():
            body = book.found.nodes[book.found.steps[number].target].state.robot
            if body.motion is not None:
                found.add(Actuated(body.motion.target, body.control))
    return found


def _limit(
    books: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    """Yield a finding if the mission cannot succeed in time with nominal durations."""
    limit_s = loaded.program.time_limit_s
    if isinf(limit_s) or not books[-1].found.complete:
        return
    least_s = _shortest_s(books[-1].found)
    if limit_s < least_s < inf:
        message = (
            f"the shortest way to an end that succeeds usually takes {least_s:.3g} s, "
            f"but the mission's time limit is {limit_s:g} s"
        )
        yield places.finding(places.of(("time_limit",)), "limit.too_short", message)


def _shortest_s(found: Exploration) -> float:
    """Return the shortest time to an end that succeeds, with nominal durations, s."""
    endings = ((found.nodes[n].state.mission.ending, s) for n, s in earliest_s(found).items())
    return min((s for end, s in endings if end and end.outcome == "succeeded"), default=inf)


def earliest_s(found: Exploration) -> Mapping[int, float]:
    """Return for each node the shortest time to it, with nominal durations, s."""
    after: list[list[tuple[int, float]]] = [[] for _ in found.nodes]
    waiting: list[tuple[float, int]] = []
    for step in found.steps:
        if step.source < 0:
            heappush(waiting, (0.0, step.target))
        else:
            after[step.source].append((step.target, took_s(found, step)))
    known: dict[int, float] = {}
    while waiting:
        time_s, node = heappop(waiting)
        if node in known:
            continue
        known[node] = time_s
        for target, more_s in after[node]:
            heappush(waiting, (time_s + more_s, target))
    return known


def took_s(found: Exploration, step: ExploredStep) -> float:
    """Return how long after the node before it a step is made, with nominal durations, s."""
    before_s = found.nodes[step.source].now if step.source >= 0 else step.move.at_s
    return max(step.move.at_s - before_s, 0.0)


# --- fault handlers ------------------------------------------------------------------------------


def fault_handlers(view: MissionView) -> Iterator[Finding]:
    """Yield a finding for each fault in `on_fault` that an earlier line handles already."""
    loaded = view.loaded
    document, owners = loaded.documents[0], loaded.robot.owners
    handled = list[tuple[str, frozenset[str] | None, int]]()
    for number, handler in enumerate(loaded.mission.on_fault):
        of = owners.things_of(handler.of) if handler.of else None
        for place, code in enumerate(handler.fault):
            before = [
                line
                for known, whose, line in handled
                if known == code and (whose is None or (of is not None and of <= whose))
            ]
            handled.append((code, of, number))
            if not before:
                continue
            message = f"'{code}' is handled by an earlier line"
            if before[0] == number:
                message = f"'{code}' appears twice in one list"
            where = document.place_of(("on_fault", number, "fault", place))
            yield at(document, where, "handler.twice", message)


def ignored_holding(view: MissionView) -> Iterator[Finding]:
    """Yield a finding for each line that only logs a fault of a part while that part holds."""
    found: dict[tuple[str, str], set[int]] = defaultdict(set)
    for book in view.seen:
        robot, program = book.found.robot, book.found.program
        for pc, configuration in {
            (node.state.mission.pc, node.state.robot.configuration) for node in book.found.nodes
        }:
            for handler in program.handlers[pc] if pc < len(program.handlers) else ():
                if handler.go is None:
                    can_be = robot.possible_owners.get(handler.code, frozenset())
                    of = can_be if handler.of is None else can_be & handler.of
                    held = (part for part in robot.held[configuration] if robot.proofs[part] & of)
                    found[handler.place, handler.code].update(held)
    for (place, code), parts in found.items():
        if parts:
            names = " and ".join(f"the {view.loaded.robot.parts[part]}" for part in sorted(parts))
            message = f"continues after '{code}' of a joint of {names}, while that part holds"
            yield view.places.finding(view.places.read(place), "handler.holding", message)
