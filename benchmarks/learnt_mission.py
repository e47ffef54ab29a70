"""Writes what an agent has done in an episode as a mission, which any backend runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from benchmarks.learning_table import WAIT
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission

_LONGEST_WAIT = "60 s"


def mission_of(course: Sequence[str], loaded: LoadedMission, name: str) -> str:
    """Return the text of a mission that takes the same course.

    A phase gives the commands up to a wait, and waits for the word that ended it, or as long. The
    last phase waits until the detector says that the whole robot has passed.

    Args:
        course: Commands and waits, as :class:`~benchmarks.learning_table.Played` has them.
        loaded: The mission that the episodes began with; its robot, pipe and start are kept.
        name: The name of the mission.

    Raises:
        UsageError: There is no course, or no word says that the robot has passed.
    """
    if not course or not loaded.robot.words_behind:
        raise UsageError("a mission needs a course, and a detector that says when it is passed")
    if not course[-1].startswith(WAIT):
        course = (*course, WAIT)
    heard = {f"{WAIT} {word}" for word in loaded.robot.words_behind}
    for number, step in enumerate(course, start=1):
        if step in heard and all(each.startswith(WAIT) for each in course[number:]):
            course = course[:number]  # it says that the robot has passed, a little early
            break
    phases: list[str] = []
    commands: list[str] = []
    behind = f"detector in ({', '.join(sorted(loaded.robot.words_behind))})"
    for number, step in enumerate(course, start=1):
        wait, _, word = step.partition(" ")
        if wait != WAIT:
            commands.append(step)
            continue
        last = number == len(course)
        go = "arrived" if last else f"part_{len(phases) + 2}"
        trigger = f"after: {word}" if word.endswith(" s") else f"when: detector == {word}"
        trigger = f"when: {behind}" if last else trigger
        phases.append(_phase(f"part_{len(phases) + 1}", commands, trigger, go))
        commands = []
    return _text(loaded, name, phases)


def _phase(name: str, commands: Iterable[str], trigger: str, go: str) -> str:
    lines = [f"  {name}:"]
    if commands:
        lines.append(f"    do: [{', '.join(commands)}]")
    lines.append(f"    wait: [{{{trigger}, go: {go}}}]")
    if trigger.startswith("when"):
        lines.append(f"    within: {{time: {_LONGEST_WAIT}, go: not_heard}}")
    return "\n".join(lines) + "\n"


def _text(loaded: LoadedMission, name: str, phases: Iterable[str]) -> str:
    configuration = loaded.robot.table.configurations[loaded.program.start_configuration]
    states = zip(loaded.robot.regions, configuration, strict=True)
    starts_in = ", ".join(f"{region}: {state}" for region, state in states)
    body = "".join(phases)
    not_heard = f"  not_heard: {{fail: The detector said nothing new within {_LONGEST_WAIT}}}\n"
    return (
        "# A course that was learnt by trying; see the documentation's page Learning.\n"
        f"format: 1\nmission: {name}\ndescription: What an agent has learnt to do\n"
        f"robot: {loaded.mission.robot}\npipe: {loaded.pipe_name}\n"
        f"starts_in: {{{starts_in}}}\ntime_limit: 10 min\nstart: part_1\n"
        f"phases:\n{body}ends:\n  arrived: {{succeed: The whole robot has passed}}\n"
        f"{not_heard if 'not_heard' in body else ''}"
    )
