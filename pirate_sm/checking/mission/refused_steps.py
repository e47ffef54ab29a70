"""A rule about steps and calls that are refused on every path or on some paths."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence

from pirate_sm.checking.exploring.exploration_index import Explored, Visits
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.mission_view import MissionView
from pirate_sm.checking.plans.ways_to_states import way_to
from pirate_sm.core.effects import CommandStatus
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import STOP, Do, Program, Require


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
