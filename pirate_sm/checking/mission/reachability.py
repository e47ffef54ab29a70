"""Rules about reachability: phases, ends, steps and decisions that are never or always reached."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

from pirate_sm.checking.exploring.conditions import Fact
from pirate_sm.checking.exploring.exploration import (
    MISHAPS,
    Exploration,
    Explored,
    ExploredState,
    Visits,
)
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.mission_view import MissionPlaces, MissionView, within_reach
from pirate_sm.checking.plans import way_to
from pirate_sm.core.documents import Path, Place
from pirate_sm.core.effects import CommandStatus, PhaseChange
from pirate_sm.core.expressions import Expression
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import ChooseStep, Mission, every_step
from pirate_sm.core.program import STOP, Branch, Do, Program, Require


def reachability(view: MissionView) -> Iterator[Finding]:
    """Yield findings about the paths through the mission."""
    books, seen, loaded, places = view.explored, view.seen, view.loaded, view.places
    if not view.complete:
        yield from _round_and_round(books, loaded, places)
        yield from _rules(books, places)
        return
    yield from _unreachable(seen, loaded, places)
    endless = list(_endless(books, loaded, places))
    yield from endless
    yield from _round_and_round(books, loaded, places)
    reached = {end for book in seen for end in book.ends}
    succeeds = [name for name, end in loaded.mission.ends.items() if end.succeed is not None]
    if not any(outcome == "succeeded" for outcome, _ in reached):
        message = "no path leads to an end that succeeds"
        if not succeeds:
            message = "it has no end that succeeds"
        yield places.finding(places.mission(), "mission.no_success", message)
    yield from _rules(books, places)


def _unreachable(
    seen: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    phases = {phase for book in seen for phase in book.phases}
    ends = {end for book in seen for _, end in book.ends}
    for code, kind, names, reached in (
        ("phase.unreachable", "phase", loaded.mission.phases, phases),
        ("end.unreachable", "end", loaded.mission.ends, ends),
    ):
        for name in names:
            if name not in reached:
                place = places.of((f"{kind}s", name), key=True)
                yield places.finding(place, code, f"nothing leads to the {kind} '{name}'")


def _endless(
    books: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    """Yield phases from which no end can be reached without a failure, a fault or the operator."""
    found = books[-1].found
    if isfinite(loaded.program.time_limit_s):
        return
    lost = cannot_end(found)
    if not lost:
        return
    first = min(lost)
    phase = found.program.phase_of[found.nodes[first].state.mission.pc]
    own = phase.split("/", 1)[0]
    sure = any(found.nodes[node].sure for node in lost)
    others = sorted(
        {
            found.program.phase_of[found.nodes[node].state.mission.pc].split("/", 1)[0]
            for node in lost
        }
        - {own, ""}
    )
    also = f" (nor from {', '.join(others)})" if others else ""
    place = places.of(("phases", own), key=True)
    message = f"from the phase '{own}' no end can be reached{also} unless something fails"
    yield places.finding(
        place,
        "loop.endless",
        message,
        severity=None if sure else Severity.POSSIBLE,
        happens=(found, found.nodes[first].step),
        playable=len(books) == 1,
    )


def cannot_end(found: Exploration) -> set[int]:
    """Return states from which no end, or none that succeeds, is reached without a mishap."""
    usual: dict[int, list[int]] = defaultdict(list)
    every: dict[int, list[int]] = defaultdict(list)
    for step in found.steps:
        every[step.target].append(step.source)
        if step.move.kind not in MISHAPS:
            usual[step.target].append(step.source)
    over = {index for index, node in enumerate(found.nodes) if node.over}
    good = {index for index in over if _succeeds(found.nodes[index])}
    return set(range(len(found.nodes))) - _leading_to(over, usual) - _leading_to(good, every)


def _succeeds(node: ExploredState) -> bool:
    ending = node.state.mission.ending
    return ending is not None and ending.outcome == "succeeded"


def _leading_to(targets: set[int], before: Mapping[int, Sequence[int]]) -> set[int]:
    """Return the states from which one of the targets is reached, including the targets."""
    can, pending = set(targets), list(targets)
    while pending:
        for source in before.get(pending.pop(), ()):
            if source >= 0 and source not in can:
                can.add(source)
                pending.append(source)
    return can


def _round_and_round(
    books: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    for book in books:
        if not book.round_and_round:
            continue
        step = book.found.steps[book.round_and_round[0]]
        entered = [each.phase for each in step.effects if isinstance(each, PhaseChange)]
        circle = list(dict.fromkeys(entered[entered.index(entered[-1]) :]))
        first = next((each for each in entered if each in circle), "")
        phase = first.split("/", 1)[0]
        path = ("phases", phase) if phase in loaded.mission.phases else ("phases",)
        way = " → ".join([*circle[circle.index(first) :], *circle[: circle.index(first)], first])
        place, message = places.of(path, key=True), f"{way}: this loop never waits"
        severity = None if step.sure else Severity.POSSIBLE
        yield places.finding(place, "loop.instant", message, severity=severity)
        return


def _rules(books: Sequence[Explored], places: MissionPlaces) -> Iterator[Finding]:
    reported: set[str] = set()
    for book in books:
        for message, number in book.broken.items():
            if message in reported:
                continue
            reported.add(message)
            state = book.found.nodes[book.found.steps[number].target].state.mission
            at = getattr(book.found.program.instructions[state.pc], "place", "")
            yield places.finding(
                places.read(at) if at else places.mission(),
                "rule.violated",
                message,
                severity=None if book.sure(number) else Severity.POSSIBLE,
                happens=(book.found, number),
                playable=book is books[0],
            )


# --- branches ------------------------------------------------------------------------------------


def branches(view: MissionView) -> Iterator[Finding]:
    """Yield conditions in the mission's own file that have the same value wherever they are tested.

    A called mission is checked on its own, because other missions may call it too. A condition on
    states that no command has changed yet is not reported if the mission may start in other states.
    A condition that repeats what a trigger has just tested is not reported either.
    """
    seen, loaded, places = view.seen, view.loaded, view.places
    reported = set[Place]()
    for finding in _arms(view):
        reported.add(finding.place)
        yield finding
    if view.complete:
        found = _decided(seen, loaded, places)
        yield from (each for each in found if each.place not in reported)


def _decided(
    seen: Sequence[Explored], loaded: LoadedMission, places: MissionPlaces
) -> Iterator[Finding]:
    """Yield conditions that had the same value each time they were tested."""
    truths: dict[str, set[bool]] = defaultdict(set)
    guards = set[str]()
    for book in seen:
        for where, asked in book.found.branches.items():
            for each in asked:
                truths[where].add(each.truth)
                if not each.moved:
                    guards.add(where)
    known = set(loaded.mission.starts_in or ())
    for where, condition in _conditions(loaded).items():
        place, text = places.read(where), condition.text
        if place.file != loaded.documents[0].name or len(truths[where]) != 1:
            continue
        if where in guards and not (condition.names and condition.names <= known):
            continue
        if True in truths[where]:
            message = f"'{text}' is true whenever it is asked"
            yield places.finding(place, "branch.always", message, fix="leave the condition out")
        else:
            message = f"'{text}' is never true when it is asked"
            yield places.finding(place, "branch.never", message, fix="leave the steps out")


def _conditions(loaded: LoadedMission) -> dict[str, Expression]:
    """Return the conditions of steps and choices by their places."""
    return {
        each.place: each.condition
        for each in loaded.program.instructions
        if isinstance(each, Branch)
    }


def _arms(view: MissionView) -> Iterator[Finding]:
    """Yield arms of a `choose`, and its `else`, that earlier arms make unreachable."""
    loaded, places = view.loaded, view.places
    asked, conditions = _conditions(loaded), within_reach(view)
    every = loaded.robot.table.configurations
    for step, path in _chooses(loaded.mission):
        others: list[Fact] = []
        for number in range(len(step.choose)):
            place = places.of((*path, "choose", number, "if"))
            condition = asked.get(str(place))
            if condition is None:
                break
            node = condition.tree
            own: list[Fact] = [(node, True)]
            shadowed = not conditions.anywhere([*others, *own], every)
            if others and shadowed and conditions.anywhere(own, every):
                message = f"an earlier arm is taken wherever '{condition.text}' is true"
                fix = "put it first, or leave it out"
                yield places.finding(place, "branch.never", message, fix=fix)
            others.append((node, False))
        else:
            if step.otherwise and len(others) > 1 and not conditions.anywhere(others, every):
                message = "one of the arms is always taken: nothing is left for `else`"
                place = places.of((*path, "else"))
                yield places.finding(place, "branch.never", message)


def _chooses(mission: Mission) -> Iterator[tuple[ChooseStep, Path]]:
    """Yield every `choose` of a mission with its path."""
    for name, phase in mission.phases.items():
        for step, path in every_step(phase.do, ("phases", name, "do")):
            if isinstance(step, ChooseStep):
                yield step, path


# --- refused steps -------------------------------------------------------------------------------


def refused_steps(view: MissionView) -> Iterator[Finding]:
    """Yield one finding for each step that is refused on some path."""
    books, seen, loaded, places = view.explored, view.seen, view.loaded, view.places
    steps = {
        each.place: each
        for each in loaded.program.instructions
        if isinstance(each, Do | Require) and each.place
    }
    handlers = handler_phases(loaded.program)
    phases = _phases(loaded.program)
    done: set[str] = set()
    for number, book in enumerate(books):
        assumed = number > 0
        for place, visits in book.visits.items():
            if place in done or place not in steps:
                continue
            done.add(place)
            step = steps[place]
            if _needed(place, seen) and not visits.refused:
                continue
            name = places.written(place, visits.name)
            handling = bool(phases[place] & handlers)
            found = _judge(book, visits, name, step, loaded, handling=handling)
            if found is None:
                continue
            code, severity, message, step_number, fix = found
            if assumed:
                message += " (after the step before it that cannot run is corrected)"
            yield places.finding(
                places.read(place),
                code,
                message,
                severity=severity,
                fix=fix,
                happens=(book.found, step_number) if step_number >= 0 else None,
                playable=not assumed,
            )


def handler_phases(program: Program) -> frozenset[str]:
    """Return the phases that handle failures and faults."""
    targets = {
        each.failed
        for each in program.instructions
        if isinstance(each, Do | Require) and each.failed not in {STOP, each.next}
    }
    targets |= {
        handler.go for each in program.handlers for handler in each if handler.go is not None
    }
    return frozenset(program.phase_of[target] for target in targets) - {""}


def _phases(program: Program) -> dict[str, set[str]]:
    """Return the phases of the step at each place; a step of a called mission can have several."""
    found: dict[str, set[str]] = defaultdict(set)
    for each, phase in zip(program.instructions, program.phase_of, strict=True):
        if isinstance(each, Do | Require):
            found[each.place].add(phase)
    return found


def _needed(place: str, seen: Sequence[Explored]) -> bool:
    """Return whether the step is executed anywhere."""
    return any(place in book.visits and book.visits[place].given for book in seen)


def _judge(
    book: Explored,
    visits: Visits,
    name: str,
    step: Do | Require,
    loaded: LoadedMission,
    *,
    handling: bool,
) -> tuple[str, Severity, str, int, str] | None:
    """Return code, severity, message, step and fix of a finding; None without a fault."""
    complete = book.found.complete
    if isinstance(step, Do) and not visits.given and not visits.refused and complete:
        message = f"{name} is never needed: its states hold already whenever the step is reached"
        return "step.never_needed", Severity.WARNING, message, -1, "leave the step out"
    if not visits.refused:
        return None
    always = visits.never_fine and complete
    refused = visits.refused if always else _unexpected(visits, step)
    if not refused:
        return None
    first = _first(book, refused)
    severity = _severity(book, refused, first, handling=handling)
    reason = visits.reasons[first]
    code = _code(visits, step, first, "" if always else "maybe_", handling=handling)
    word = "is refused" if always else "can be refused"
    message = f"{name} {word} as {reason}"
    if always and len({visits.reasons[each] for each in visits.refused}) > 1:
        message += ", or for another reason, on every path"
    if isinstance(step, Require):
        return code, severity, message, first, _way_to(step, book, first, loaded, always=always)
    return code, severity, message, first, _mend(visits, first, always=always)


def _unexpected(visits: Visits, step: Do | Require) -> list[int]:
    """Return the refusals that the mission does not handle, of a step that is not always refused.

    A step with its own failure target handles all refusals. A phase with one handles impossible
    steps only, because an unneeded step would skip the steps after it.
    """
    if step.expected:
        return []
    return visits.unneeded if step.handled else visits.refused


def _first(book: Explored, refused: Sequence[int]) -> int:
    """Return the refusal to report: the first sure one, otherwise the first."""
    sure = [each for each in refused if book.sure(each)]
    return min(sure or refused)


def _severity(book: Explored, refused: Sequence[int], first: int, *, handling: bool) -> Severity:
    """Return the severity: a handler that fails only after two mishaps is a warning."""
    if not book.sure(first):
        return Severity.POSSIBLE
    again = handling and min(book.found.mishaps(each) for each in refused) > 1
    return Severity.WARNING if again else Severity.ERROR


def _code(visits: Visits, step: Do | Require, first: int, maybe: str, *, handling: bool) -> str:
    if isinstance(step, Require):
        return f"call.{maybe}starts_in"
    if handling:
        return "handler.impossible"
    kind = "unneeded" if first in visits.unneeded else "impossible"
    return f"step.{maybe}{kind}"


def _way_to(
    step: Require, book: Explored, first: int, loaded: LoadedMission, *, always: bool
) -> str:
    """Return how the required states of a call can be reached."""
    source = book.found.steps[first].source
    body = book.found.nodes[max(source, 0)].state.robot
    # Unconfirmed states count as confirmed, because each command is given separately.
    at_rest = body.at_rest()._replace(marks=frozenset())
    plan = way_to(loaded.robot, loaded.program, at_rest, dict(step.states)).plan
    if plan is None:
        return "no commands lead there from where the robot is: let another phase come before it"
    commands = [loaded.robot.commands[each.command].name for each in plan.steps]
    if not commands:
        return "put a command before it that confirms these states"
    given = ", ".join(commands)
    before = f"put {given} before the call"
    if always:
        return before
    failed = [each for each in commands if each in _failed(book, first)]
    if failed:
        stand, its = ("stands", "its") if len(failed) == 1 else ("stand", "their")
        message = f"{', '.join(failed)} {stand} before the call and can fail: let {its} failure"
        return f"{message} lead elsewhere, or set `on_failure` at the call"
    each = "each " if len(commands) > 1 else ""
    return f"{before}, {each}with `unneeded: skip`, or set `on_failure` at the call"


def _failed(book: Explored, step: int) -> set[str]:
    """Return the names of the commands that fail before a step."""
    return {
        effect.name
        for each in book.found.path(step)
        for effect in each.effects
        if isinstance(effect, CommandStatus) and effect.status in ("refused", "failed")
    }


def _mend(visits: Visits, first: int, *, always: bool) -> str:
    if first in visits.unneeded:
        if always:
            return "leave the step out, or set `unneeded: skip`"
        return "set `unneeded: skip`: then it is skipped where it is not needed"
    return "put the commands before it that make it possible, or set `on_failure` at the step"
