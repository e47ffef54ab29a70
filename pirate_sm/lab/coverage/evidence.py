"""What takes branches of a mission: the check's exploration, and runs that are given to the engine.

The engine itself notes each branch, in a replay as in the exploration. Nothing else interprets
missions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from math import inf
from typing import Literal, NamedTuple, TypeAlias, get_args

from pirate_sm.api import Run
from pirate_sm.api.result import noted
from pirate_sm.checking.exploring.exploration import Exploration
from pirate_sm.checking.exploring.explore import conditions_of, explore
from pirate_sm.checking.permissions import SIMULATED
from pirate_sm.core.companion import entered
from pirate_sm.core.effects import Effect, Fault
from pirate_sm.core.errors import ExitCode
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import BranchKey, Program
from pirate_sm.core.robot import safety
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.replay import engine_of, rerun_steps, same
from pirate_sm.running.runtime.ending import StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice, Patience
from pirate_sm.running.wiring import Order, prepare

Evidence: TypeAlias = Literal["model", "trace", "simulated", "robot"]
EVIDENCE: tuple[Evidence, ...] = get_args(Evidence)
"""What can show that a branch is taken, the weakest first. In the model every event is possible
that the check knows; in a trace commands are done by their time; a simulated robot has physics."""


@dataclass(frozen=True)
class Taken:
    """The branches that a run, or an exploration, has taken.

    Attributes:
        branches: How often each was taken.
        rules: How often each of the robot's safety rules was broken, or a command was kept from it.
        differs_s: When a replay first differs from its recording; what came later does not count.
    """

    branches: Counter[BranchKey] = field(default_factory=Counter)
    rules: Counter[str] = field(default_factory=Counter)
    differs_s: float = inf


def evidence_of(header: RunHeader) -> Evidence:
    """Return what a run shows by its backend; one of another package counts as a simulator."""
    if header.nominal:
        return "trace"
    ours = header.backend in (*SIMULATED, "serial")
    return "robot" if ours and header.backend not in SIMULATED else "simulated"


def taken_in(run: Run) -> Taken:
    """Return the branches that a run has taken, by giving the engine its inputs again.

    Raises:
        RecordingError: The recording that it was read from is damaged.
    """
    seen: list[BranchKey] = []
    branches, rules = Counter[BranchKey](), Counter[str]()
    engine = engine_of(run.header, run.loaded, taken=seen)
    for again in rerun_steps(engine, run.steps(), run.gaps, origin_s=run.origin_s):
        if not same(again.step.effects, again.effects):
            return Taken(branches, rules, again.at_s)
        branches.update(seen)
        rules.update(_broken(run.loaded.program, again.effects))
        seen.clear()
    return Taken(branches, rules)


def names_of_commands(loaded: LoadedMission) -> tuple[str, ...]:
    """Return the names of the commands of a mission's robot, by their indexes."""
    return tuple(each.name for each in loaded.robot.commands)


def possible_in(loaded: LoadedMission) -> tuple[Exploration, Taken]:
    """Explore a mission; return the exploration, and the branches that it takes, each once."""
    program = replace(loaded.program, diameter_m=None, bores_m=())
    found = explore(loaded.robot, program, conditions_of(loaded))
    rules = {rule for step in found.steps for rule in _broken(loaded.program, step.effects)}
    return found, Taken(Counter(found.taken.keys()), Counter(rules))


def _broken(program: Program, effects: Iterable[Effect]) -> Iterable[str]:
    """Yield the names of the rules of which effects say that they are or would be broken."""
    for each in effects:
        if isinstance(each, Fault) and each.code == safety.RULE_BROKEN:
            yield from (rule.name for rule in program.rules if safety.said(rule) in each.message)


class Played(NamedTuple):
    """A run that was played, and its exit code."""

    run: Run
    exit_code: int


def played(order: Order, loaded: LoadedMission) -> Played:
    """Run a mission to its end, kept in memory; questions get their first answer.

    Raises:
        UsageError: The order does not fit the mission.
        KeyboardInterrupt: The user has interrupted the run.
    """
    prepared, requests = prepare(order, loaded), StopRequests()
    with ExitStack() as stack:
        notes = stack.enter_context(noted(prepared, None, lambda: run.state))
        stack.enter_context(entered(prepared.companions))
        answers = [] if prepared.attended else [FirstChoice()]
        companions = (*prepared.companions, *answers, Patience(requests))
        run = MissionRun(
            prepared.engine,
            prepared.backend,
            companions=companions,
            requests=requests,
            tap=notes,
        )
        result = run.execute()
    if result.error is not None and result.exit_code == ExitCode.BUG:
        raise result.error
    if result.exit_code == ExitCode.INTERRUPTED and requests.stop is None:
        raise KeyboardInterrupt(result.ended.message)
    return Played(notes.run(), result.exit_code)
