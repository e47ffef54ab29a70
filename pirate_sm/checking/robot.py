"""What is wrong with a robot that loads: its chart, its commands and faults, its parts.

Only what the files themselves contradict is reported. How well the numbers fit a real robot
they cannot show.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.chart import check_chart, cut_off, examine
from pirate_sm.checking.exploring.conditions import Conditions, Fact
from pirate_sm.checking.exploring.ranges import ranges
from pirate_sm.checking.findings import Finding, Severity, finding_of
from pirate_sm.checking.robot_limits import check_limits
from pirate_sm.checking.robot_parts import check_parts
from pirate_sm.checking.robot_sight import check_sight
from pirate_sm.checking.robot_view import RobotView
from pirate_sm.expressions import tree
from pirate_sm.loading.chart.outline_reader import outline_chart
from pirate_sm.loading.chart.table_cache import cached_table
from pirate_sm.loading.file_names import PROFILE_FILE, shown
from pirate_sm.loading.problems import LoadError, Problem, Problems
from pirate_sm.loading.robot import LoadedRobot, load_robot
from pirate_sm.loading.yaml.document import Document, read_document

UNREACHABLE = "chart.unreachable"


class RobotCheck(NamedTuple):
    """What is known of a robot's folder.

    Attributes:
        findings: By place.
        documents: Profile and chart, as far as they could be read.
        loaded: The robot; None where it cannot be loaded.
    """

    findings: tuple[Finding, ...]
    documents: tuple[Document, ...]
    loaded: LoadedRobot | None


def check_robot(folder: Path) -> RobotCheck:
    """Everything that is wrong with the robot in this folder, found at loading or after it."""
    try:
        loaded = load_robot(folder)
    except LoadError as error:
        documents = _readable(folder)
        return RobotCheck(_of_loading(error.problems, documents), documents, None)
    findings = sorted((*check_chart(loaded), *robot_findings(loaded)), key=lambda each: each.order)
    return RobotCheck(tuple(findings), loaded.documents, loaded)


def robot_findings(loaded: LoadedRobot) -> tuple[Finding, ...]:
    """What is wrong with a robot beside its chart, by place."""
    view = RobotView(loaded)
    found = [*_asked(view), *_faults(view), *check_limits(view), *check_parts(view)]
    found += check_sight(view)
    return tuple(sorted(found, key=lambda each: each.order))


# --- a robot that cannot be loaded -------------------------------------------------------------


def _readable(folder: Path) -> tuple[Document, ...]:
    """The robot's files, as far as they can be read."""
    try:
        profile = read_document(folder / PROFILE_FILE, shown(folder / PROFILE_FILE))
    except LoadError:
        return ()
    name = profile.data.get("chart") if isinstance(profile.data, dict) else None
    try:
        path = folder / str(name)
        return profile, read_document(path, shown(path))
    except LoadError:
        return (profile,)


def _of_loading(
    problems: tuple[Problem, ...], documents: tuple[Document, ...]
) -> tuple[Finding, ...]:
    """The problems, and where states are unreachable the reason in place of them."""
    rest = [finding_of(each) for each in problems if each.code != UNREACHABLE]
    if len(rest) < len(problems):
        rest += _unreachable([each for each in problems if each.code == UNREACHABLE], documents[1])
    return tuple(sorted(rest, key=lambda each: each.order))


def _unreachable(problems: list[Problem], document: Document) -> list[Finding]:
    collected = Problems(document)
    outline = outline_chart(document, collected)
    assert outline is not None  # it has been explored
    checked = examine(document, outline, cached_table(document, outline, collected))
    excused = {
        document.place_of(outline.place_of(region, state), key=True)
        for region, state in cut_off(outline, checked.silent)
    }
    alone = [finding_of(each) for each in problems if each.place not in excused]
    return [*checked.findings, *alone]


# --- commands and faults -----------------------------------------------------------------------


def _asked(view: RobotView) -> Iterator[Finding]:
    """Commands whose `asks_for` does not describe what they lead to."""
    table, unneeded = view.loaded.table, view.loaded.normal.unneeded
    for number, name in enumerate(table.commands):
        if view.profile.commands[name].asks_for.strip() == "false":
            continue  # a toggle is never unneeded
        message = ""
        met = [row[number] for row in unneeded]
        if not any(met):
            message = f"no combination of states is ever what {name} asks for"
        elif all(met):
            message = f"every combination of states is what {name} asks for"
        else:
            missed = [after for _, after in view.moves(number) if not met[after]]
            if missed:
                pairs = zip(table.regions, table.configurations[missed[0]], strict=True)
                states = ", ".join(f"{region} {state}" for region, state in pairs)
                message = f"{name} leads to {states}, which is not what it asks for"
        if message:
            yield view.at(
                ("commands", name, "asks_for"),
                "robot.asks_for",
                Severity.WARNING,
                message,
                offset=0,
            )


def _faults(view: RobotView) -> Iterator[Finding]:
    """Fault rules that the signals can never, or always, make true."""
    robot = view.loaded.normal
    # A joint beyond its end stop is a sensor that shows nonsense, which a rule may well look for.
    joints = {joint.name for joint in view.profile.body.joints}
    known = ranges(view.profile, robot)
    spans = {name: span for name, span in known.items() if name not in joints}
    conditions = Conditions(robot.vocabulary, spans, len(robot.regions))
    rules = iter(robot.faults)
    for number, fault in enumerate(view.profile.faults):
        written_out = [next(rules) for _ in fault.for_each or (None,)]
        path = ("faults", number, "when")
        for rule in written_out:
            verdict = _verdict(view, conditions, rule.when.tree)
            if verdict is None:
                continue
            word = "always" if verdict else "never"
            message = f"this can {'only' if verdict else 'never'} be true, so {fault.code} is"
            message += " raised whatever happens" if verdict else " never raised"
            yield view.at(path, f"robot.fault_{word}", Severity.WARNING, message, offset=0)
            break


def _verdict(view: RobotView, conditions: Conditions, node: tree.Node) -> bool | None:
    """Whether the condition always (True) or never (False) holds while its signals are known."""
    signals = [each for each in tree.walk(node) if isinstance(each, tree.Signal)]
    known: list[Fact] = [(tree.Known(each), True) for each in dict.fromkeys(signals)]
    seen = view.configurations({each.name for each in signals})
    if not any(conditions.ask([(node, True)], states).possible for states in seen):
        return False
    if not any(conditions.ask([(node, False), *known], states).possible for states in seen):
        return True
    return None
