"""Load a folder of a robot: read, check and resolve its profile and chart, and what a fit says."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

from pirate_sm.core._engine.mission.program import RuleSpec
from pirate_sm.core._engine.robot.robot_spec import ChartTable, RobotSpec
from pirate_sm.core._loading import references
from pirate_sm.core._loading.chart_exploration import cached_table
from pirate_sm.core._loading.chart_outline import ChartOutline, outline_chart
from pirate_sm.core._loading.problems import LoadError, Problems
from pirate_sm.core._loading.references import read_extended
from pirate_sm.core._loading.robot.actuation import (
    check_levelled,
    resolve_actuation,
    resolve_chain,
    resolve_slots,
)
from pirate_sm.core._loading.robot.body_check import check_body
from pirate_sm.core._loading.robot.commands import (
    resolve_commands,
    resolve_faults,
    resolve_owners,
    resolve_parts,
    resolve_rules,
)
from pirate_sm.core._loading.robot.controls import resolve_controls, resolve_postures
from pirate_sm.core._loading.robot.criteria import resolve_sight
from pirate_sm.core._loading.robot.sensing import resolve_boards, resolve_traction, thresholds
from pirate_sm.core._loading.robot.signals import resolve_signals, resolve_words, words_behind
from pirate_sm.core._loading.robot.twin import twin_in, with_twin
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core._loading.yaml.validation import try_validate
from pirate_sm.core._model.robot import signals as kinds
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.on_disk import remembered

Polarity = Literal["normal", "mirrored"]


@dataclass(frozen=True, eq=False)
class LoadedRobot:
    """A robot without faults, as its files describe it.

    Attributes:
        profile: The content of the profile.
        believed: The profile with which the specifications were resolved; its motors may have
            fitted numbers.
        table: The table of its chart.
        documents: Its source files: profile, chart, and the file with fitted numbers, if any.
        folder: The folder of the files.
        normal: The engine's specification in normal polarity.
        mirrored: The specification with every mirrored slot and wheel negated.
        rules: Its safety rules.
        outline: The declarations of the chart's file.
    """

    profile: Profile
    believed: Profile
    table: ChartTable
    documents: tuple[Document, ...]
    folder: Path
    normal: RobotSpec
    mirrored: RobotSpec
    rules: tuple[RuleSpec, ...]
    outline: ChartOutline

    def oriented(self, polarity: Polarity) -> RobotSpec:
        """Return the robot in this polarity."""
        return self.normal if polarity == "normal" else self.mirrored


def load_robot(folder: Path) -> LoadedRobot:
    """Return the robot in this folder.

    Args:
        folder: The folder with ``profile.yaml`` and the chart that it names.

    Raises:
        LoadError: Its files have faults; holds all of them.
    """
    return _sound_robot(folder, references.keeps_inside())


@remembered(8)
def _sound_robot(folder: Path, inside: bool) -> LoadedRobot:
    robot, problems = read_robot(folder)
    problems.raise_errors()
    return robot


_SOUND: Final[dict[tuple[str, ...], LoadedRobot]] = {}
"""Robots without problems by their texts: a copy, as in a recording, is not resolved again."""

_MOST_SOUND: Final = 8


def read_robot(folder: Path) -> tuple[LoadedRobot, Problems]:
    """Return the robot in this folder as far as it makes sense, and what is wrong with it.

    Raises:
        LoadError: There is so much wrong with its files that there is no robot.
    """
    document = read_extended(folder / PROFILE_FILE)
    problems = Problems(document)
    profile = try_validate(document, Profile, problems)
    if profile is None:
        problems.raise_errors()
        raise AssertionError("raise_errors raises here")
    check_body(profile, problems)
    chart_document = _chart(folder, profile.chart, problems)
    outline = outline_chart(chart_document, problems) if chart_document else None
    if outline is not None:
        _check_commands(profile, outline, problems)
        _check_regions(profile, outline, problems)
    problems.raise_errors()
    assert chart_document is not None  # raise_errors has raised otherwise
    assert outline is not None
    files = (document, chart_document)
    texts = tuple(each.complete_text for each in files)
    if known := _SOUND.get(texts):
        return replace(known, documents=files, folder=folder), problems
    table = cached_table(chart_document, outline, problems)
    _check_reached(outline, table, problems.about(chart_document))
    rules = resolve_rules(profile, table, problems)
    normal = mirrored = _resolve(profile, table, "normal", problems)
    if not problems.errors:
        mirrored = _resolve(profile, table, "mirrored", problems)
    robot = LoadedRobot(profile, profile, table, files, folder, normal, mirrored, rules, outline)
    if not problems.all:
        _SOUND[texts] = robot
        if len(_SOUND) > _MOST_SOUND:
            _SOUND.pop(next(iter(_SOUND)), None)  # another thread may have removed it
    return robot, problems


BEYOND_A_MOTOR = frozenset({"robot.control", "robot.setpoint"})
"""Faults of a profile that asks for more than a fitted motor gives, which then never settles."""


def with_fitted(robot: LoadedRobot, document: Document | None) -> LoadedRobot:
    """Return the robot of whose motors a file says what they bear; without a file as it is.

    The friction in the file is left out: what holds the robot in a pipe does not depend on a fit.

    Raises:
        LoadError: Everything that is wrong with the file, or what it leaves of the profile is not a
            robot.
    """
    if document is None:
        return robot
    twin = twin_in(document, robot.profile)
    believed = with_twin(robot.profile, twin.model_copy(update={"friction": None}))

    def resolved(polarity: Polarity) -> RobotSpec:
        problems = Problems(robot.documents[0])
        spec = _resolve(believed, robot.table, polarity, problems)
        problems.raise_errors(BEYOND_A_MOTOR)
        return spec

    return replace(
        robot,
        believed=believed,
        documents=(*robot.documents, document),
        normal=resolved("normal"),
        mirrored=resolved("mirrored"),
    )


def _chart(folder: Path, name: str, problems: Problems) -> Document | None:
    """Return the chart's document; report a missing file as a fault of the profile."""
    path = folder / name
    try:
        return read_extended(references.followed(path, folder))
    except UsageError as error:
        problems.add(references.code_of(error, "robot.chart"), ("chart",), str(error))
        return None
    except LoadError as error:
        problems.take(error, "robot.chart", ("chart",))
        return None


def _check_commands(profile: Profile, outline: ChartOutline, problems: Problems) -> None:
    events, commands = set(outline.commands), profile.commands.keys()
    for name in sorted(events - commands):
        message = f"the chart's event '{name}' is missing here"
        problems.add("robot.command", ("commands",), message, key=True)
    for name in commands - events:
        _dangling(problems, ("commands", name), f"the chart has no event '{name}'", name, events)
    for alias, name in profile.aliases.items():
        if name not in commands:
            _dangling(problems, ("aliases", alias), f"there is no command '{name}'", name, commands)
        if alias in commands:
            problems.add("robot.alias", ("aliases", alias), f"'{alias}' is a command", key=True)
    for name in profile.not_commands.keys() & {*commands, *profile.aliases}:
        problems.add("robot.alias", ("not_commands", name), f"'{name}' is a command", key=True)


def _check_regions(profile: Profile, outline: ChartOutline, problems: Problems) -> None:
    states = dict(zip(outline.regions, outline.states, strict=True))
    for region in profile.actuation.keys() - states.keys():
        _dangling(
            problems, ("actuation", region), f"the chart has no region '{region}'", region, states
        )
    for region, names in states.items():
        given = profile.actuation.get(region)
        if given is None:
            message = f"region '{region}' is missing here"
            problems.add("robot.actuation", ("actuation",), message, key=True)
            continue
        for name in given.keys() - set(names):
            _dangling(
                problems,
                ("actuation", region, name),
                f"{region} has no state '{name}'",
                name,
                names,
            )
        for name in (name for name in names if name not in given):
            message = f"{region}.{name} is missing here"
            problems.add("robot.actuation", ("actuation", region), message, key=True)


def _check_reached(outline: ChartOutline, table: ChartTable, problems: Problems) -> None:
    """Report states that no command sequence reaches."""
    for place, (region, states) in enumerate(zip(table.regions, table.states, strict=True)):
        reached = {configuration[place] for configuration in table.configurations}
        for state in states:
            if state not in reached:
                problems.add(
                    "chart.unreachable",
                    outline.place_of(region, state),
                    f"no commands lead to {region}.{state}",
                    key=True,
                )


def _dangling(
    problems: Problems, path: tuple[str, ...], message: str, name: str, valid: Iterable[str]
) -> None:
    names = sorted(valid)
    problems.add_unknown(
        "robot.name", path, "", name, names, message=message, key=path[0] != "aliases"
    )


def _resolve(
    profile: Profile, table: ChartTable, polarity: Polarity, problems: Problems
) -> RobotSpec:
    signals = resolve_signals(profile, table, polarity, problems)
    slots = resolve_slots(signals)
    parts, held, part_regions = resolve_parts(table, signals)
    actuation = resolve_actuation(table, signals, slots)
    postures = resolve_postures(table, signals, slots, held, actuation)
    commands, unneeded = resolve_commands(table, held, signals, postures)
    check_levelled(table, actuation, commands, problems)
    owners = resolve_owners(signals)
    faults = resolve_faults(signals, parts, owners)
    zero = tuple(
        slots.index(name, ("safe_state", "zero", number))
        for number, name in enumerate(profile.safe_state.zero)
    )
    boards = resolve_boards(signals, faults)
    return RobotSpec(
        name=profile.robot,
        polarity=polarity,
        table=table,
        vocabulary=signals.vocabulary,
        slots=slots.specs,
        actuation=actuation,
        commands=commands,
        parts=parts,
        held=held,
        part_regions=part_regions,
        unneeded=unneeded,
        safe_zero=zero,
        boards=boards,
        wheels=signals.wheels,
        odometry=signals.derived_by(kinds.OdometryOf),
        bound=signals.derived_by(kinds.BoundOf),
        speed=signals.derived_by(kinds.SpeedOf),
        faults=faults,
        link=signals.link,
        plausibility=thresholds(profile),
        detector_words=tuple(profile.detector.words),
        words_behind=words_behind(profile),
        body=resolve_chain(signals),
        sight=resolve_sight(table, slots.specs, actuation, signals),
        traction=resolve_traction(signals, boards),
        outside={
            name: (signals.vocabulary.numbers.index(name), each.valid_for)
            for name, each in profile.outside.items()
        },
        word_conditions=tuple(resolve_words(signals)),
        words_joint={
            name: word.joint for name, word in profile.detector.words.items() if word.joint
        },
        overlays=resolve_controls(table, signals, slots, actuation),
        owners=owners,
    )
