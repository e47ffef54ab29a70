"""A rule about times: no limit is too short, and every question has one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from math import inf, isinf

from pirate_sm.checking.actuation_in_force import Actuated, InForce, too_slow, too_strong
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.mission import CONTROL_WITHIN_S
from pirate_sm.core.program import Do, Question, SwitchControl


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
    for_s = getattr(spec.done, "for_s", 0.0)
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
    """Return the same for a command that is never done under a control in force at its step.

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
    """Return where the step leads to, each with the control in force."""
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
    after: list[list[tuple[int, float]]] = [[] for _ in found.nodes]
    waiting: list[tuple[float, int]] = []
    for step in found.steps:
        if step.source < 0:
            heappush(waiting, (0.0, step.target))
        else:
            took_s = max(step.move.at_s - found.nodes[step.source].now, 0.0)
            after[step.source].append((step.target, took_s))
    known: set[int] = set()
    while waiting:
        time_s, node = heappop(waiting)
        if node in known:
            continue
        known.add(node)
        ending = found.nodes[node].state.mission.ending
        if ending is not None and ending.outcome == "succeeded":
            return time_s
        for target, took_s in after[node]:
            heappush(waiting, (time_s + took_s, target))
    return inf
