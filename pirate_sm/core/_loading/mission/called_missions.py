"""Read the missions that a mission calls, and check in which states missions start."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path as FilePath

from pirate_sm.core import library
from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._loading import references
from pirate_sm.core._loading.mission import parameter_values as parameters
from pirate_sm.core._loading.mission.parameter_values import Values
from pirate_sm.core._loading.mission.scope import Scope, Source
from pirate_sm.core._loading.problems import LoadError, Path, Problems
from pirate_sm.core._loading.references import extended_folders
from pirate_sm.core._loading.yaml.document import Document, read_document
from pirate_sm.core._loading.yaml.validation import validate
from pirate_sm.core._model import mission as model
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.library import PROFILE_FILE
from pirate_sm.core.on_disk import resolved
from pirate_sm.core.spelling import nearest, one_of

DEEPEST_CALL = 16


@dataclass
class Calls:
    """The files of called missions, read on demand.

    Attributes:
        files: Every file that was read.
    """

    files: dict[FilePath, Document] = field(default_factory=dict)
    _known: dict[FilePath, Source] = field(default_factory=dict)
    _lengths: dict[FilePath, int] = field(default_factory=dict)

    def least_length(self, source: Source, calls: frozenset[FilePath] = frozenset()) -> int:
        """Return the smallest number of instructions of a mission, each repeat counted once.

        Each file is counted once, however often it is called: thirty levels of doubled calls are
        counted at once, but would take far too long to write.
        """
        if source.path in calls:
            return 0  # a recursion, which is reported at the call
        if source.path not in self._lengths:
            inner = len(source.mission.ends)
            for phase in source.mission.phases.values():
                inner += 1 + bool(phase.wait)
                for step, _ in model.every_step(phase.do):
                    inner += not isinstance(step, model.RepeatStep)
                    if isinstance(step, model.CallStep):
                        called = self._quietly(step.call, resolved(source.path).parent)
                        if called is not None:
                            inner += self.least_length(called, calls | {source.path})
            self._lengths[source.path] = inner
        return self._lengths[source.path]

    def source(self, name: str, scope: Scope, path: Path) -> Source | None:
        """Return the called mission, cached; None after reporting why it cannot be used."""
        folder = resolved(scope.source.path).parent
        try:
            found = self._read(name, folder)
        except LoadError as error:
            references.tell(
                error, library.find_mission(name, folder), references.MISSION, path, scope.problems
            )
            return None
        except PirateError as error:
            scope.problems.add(references.code_of(error, "mission.call"), path, str(error))
            return None
        return None if _is_too_deep(found, scope, path) else found

    def _quietly(self, name: str, folder: FilePath) -> Source | None:
        """Return the mission that a file in this folder calls; None where it cannot be used."""
        try:
            return self._read(name, folder)
        except (LoadError, PirateError):
            return None  # reported at the call

    def _read(self, name: str, folder: FilePath) -> Source:
        file = resolved(references.followed(library.find_mission(name, folder), folder))
        if file not in self._known:
            document = read_document(file)
            self.files[file] = document
            self._known[file] = Source(validate(document, model.Mission), document, file)
        return self._known[file]


def suits(called: Source, calling: Source) -> bool:
    """Return whether a mission is for the robot of the mission that calls it, or for one below.

    Different paths to a robot are the same. Files are read only where the robots differ.
    """
    own, other = _robot_of(calling), _robot_of(called)
    if own is None or other is None:
        return own is other and called.mission.robot == calling.mission.robot
    try:
        return other == own or other in extended_folders(own / PROFILE_FILE)
    except PirateError:
        return False  # reported with the robot


def _robot_of(source: Source) -> FilePath | None:
    """Return the folder of a mission's robot; None if there is none."""
    try:
        return library.find_robot(source.mission.robot, resolved(source.path).parent)
    except PirateError:
        return None


def _is_too_deep(found: Source, scope: Scope, path: Path) -> bool:
    """Return whether the mission calls itself, or too many call each other; report that."""
    if found.path in scope.calls:
        chain = " → ".join(each.stem for each in (*scope.calls, found.path))
        scope.problems.add("mission.recursion", path, f"a mission cannot call itself: {chain}")
        return True
    if len(scope.calls) >= DEEPEST_CALL:
        scope.problems.add("mission.depth", path, f"calls are nested more than {DEEPEST_CALL}")
        return True
    return False


def arguments_of(step: model.CallStep, source: Source, scope: Scope, path: Path) -> Values:
    """Return the values of the parameters of a called mission."""
    mission = source.mission
    at = (*path, "with")
    values = parameters.defaults(mission.parameters, scope.problems.about(source.document))
    given = {name: scope.argument(v, (*at, name)) for name, v in step.arguments.items()}
    values |= parameters.given(mission.parameters, given, at, scope.problems)
    for name in mission.parameters.keys() - values.keys():
        values[name] = parameters.stand_in(mission.parameters[name])
        scope.problems.add(
            "mission.parameter", path, f"'{mission.mission}' needs the parameter '{name}'"
        )
    return values


def check_call(source: Source, scope: Scope, path: Path) -> bool:
    """Return whether a called mission is for this robot, or report why it is not.

    A mission for a robot that this one extends is: it has all of its states and commands.
    """
    mission, own = source.mission, scope.source
    polarity = scope.robot.polarity
    if mission.polarity not in {None, polarity}:
        message = f"'{mission.mission}' is {mission.polarity}, this mission is {polarity}"
        scope.problems.add("mission.polarity", path, message)
    if not suits(source, own):
        message = f"'{mission.mission}' is for the robot '{mission.robot}'"
        scope.problems.add("mission.robot", path, message)
        return False
    return True


def start_configuration(
    source: Source, table: ChartTable, states: Mapping[str, str] | None, problems: Problems
) -> int:
    """Return the index of the mission's initial configuration (rule 2).

    Regions that ``starts_in`` does not name are in their initial state.

    Raises:
        UsageError: ``states``, from the command line, do not fit.
    """
    if states is not None:
        return _declared(table, states)
    about = problems.about(source.document)
    wanted = dict(zip(table.regions, table.configurations[table.initial], strict=True))
    for region, state in (source.mission.starts_in or {}).items():
        if _check(table, region, state, ("starts_in", region), about):
            wanted[region] = state
    index = table.index_of(tuple(wanted.values()))
    if index is None:
        shown = ", ".join(f"{region} {state}" for region, state in wanted.items())
        about.add("mission.start", ("starts_in",), f"no commands lead to {shown}")
        return table.initial
    return index


def required_states(
    source: Source, table: ChartTable, problems: Problems
) -> tuple[tuple[int, str], ...]:
    """Return the states that a called mission requires: its ``starts_in`` or initial states."""
    named = source.mission.starts_in
    if named is None:
        return tuple(enumerate(table.configurations[table.initial]))
    return tuple(
        (table.regions.index(region), state)
        for region, state in named.items()
        if _check(table, region, state, ("starts_in", region), problems)
    )


def _check(table: ChartTable, region: str, state: str, path: Path, problems: Problems) -> bool:
    if region not in table.regions:
        problems.add_unknown("mission.start", path, "region", region, table.regions, key=True)
        return False
    names = table.states[table.regions.index(region)]
    if state not in names:
        problems.add_unknown(
            "mission.start", path, "", state, names, message=f"{region} has no state '{state}'"
        )
        return False
    return True


def read_states(table: ChartTable, states: Mapping[str, str]) -> dict[int, str]:
    """Return states from the command line by the index of their region.

    Raises:
        UsageError: Some are not in the chart; the message lists all, with suggestions.
    """
    found: dict[int, str] = {}
    wrong = []
    for region, state in states.items():
        if region not in table.regions:
            wrong.append(f"there is no region '{region}'{_meant(region, table.regions)}")
            continue
        index = table.regions.index(region)
        if state not in table.states[index]:
            wrong.append(f"{region} has no state '{state}'{_meant(state, table.states[index])}")
        found[index] = state
    if wrong:
        raise UsageError("\n".join(wrong))
    return found


def _meant(word: str, names: Collection[str]) -> str:
    close = nearest(word, names)
    return f"; did you mean '{close}'?" if close else f": {one_of(names)}"


def _declared(table: ChartTable, states: Mapping[str, str]) -> int:
    wanted = list(table.configurations[table.initial])
    for region, state in read_states(table, states).items():
        wanted[region] = state
    index = table.index_of(tuple(wanted))
    if index is None:
        filled = ", ".join(
            f"{region} {state}"
            for region, state in zip(table.regions, wanted, strict=True)
            if region not in states
        )
        message = f"no commands lead to {', '.join(' '.join(each) for each in states.items())}"
        if filled:
            message += f" with {filled}: regions that are not declared are in their initial state"
        raise UsageError(message)
    return index
