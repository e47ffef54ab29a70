"""Load a mission file, its robot, its pipe and the missions it calls as one program.

A loaded mission can be pickled, so that other processes can be sent it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from copyreg import pickle
from dataclasses import dataclass, field, replace
from functools import lru_cache
from hashlib import sha256
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from pydantic import ValidationError

from pirate_sm.core import library
from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.robot.criteria import CriterionSpec, HeldSpec, Sight, TorqueBorne
from pirate_sm.core._engine.robot.robot_spec import CommandSpec, RobotSpec
from pirate_sm.core._geometry.chain import holding_nm
from pirate_sm.core._geometry.network import tilted_up
from pirate_sm.core._geometry.space import GRAVITY_M_S2, dot
from pirate_sm.core._loading import references
from pirate_sm.core._loading.mission import parameter_values as parameters
from pirate_sm.core._loading.mission.program import build_program
from pirate_sm.core._loading.mission.scope import Source
from pirate_sm.core._loading.pipe import check_fit, check_section, load_pipe, part_of
from pirate_sm.core._loading.problems import LoadError, Problem, Problems, Severity, meant_key
from pirate_sm.core._loading.references import FileKind, refuse_other
from pirate_sm.core._loading.robot.loader import LoadedRobot, load_robot, with_fitted
from pirate_sm.core._loading.yaml.document import Document, read_document
from pirate_sm.core._loading.yaml.validation import try_validate
from pirate_sm.core._model.mission import Mission
from pirate_sm.core._model.pipe import Pipe
from pirate_sm.core._model.quantities import FROM_FILE
from pirate_sm.core._model.robot.profile import Profile
from pirate_sm.core.errors import Hint, UsageError
from pirate_sm.core.on_disk import here, noting, resolved
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import QuantityError


@dataclass(frozen=True)
class LoadedMission:
    """A mission without faults, with everything that a run needs.

    Attributes:
        documents: Its source files: the mission's first, the pipe's last (the mission's again if
            the pipe is written in it, or if there is none).
        files: Hash of each file, by its name.
        parameters: The values in force, as text for messages.
        notices: Messages for the user that are not faults.
        problems: What was found when it was loaded: warnings, and faults that were tolerated.
        origin: A digest of all that it was loaded from; empty for one that was changed since.
    """

    mission: Mission
    loaded_robot: LoadedRobot
    robot: RobotSpec
    program: Program
    pipe: Pipe | None
    pipe_name: str
    documents: tuple[Document, ...]
    files: Mapping[str, str]
    parameters: Mapping[str, str]
    notices: tuple[str, ...] = ()
    problems: tuple[Problem, ...] = ()
    origin: str = field(default="", init=False, compare=False)

    def __repr__(self) -> str:
        where = f"in pipe {self.pipe_name}" if self.pipe_name else "without a pipe"
        return f"<LoadedMission {self.mission.mission}: robot {self.robot.name}, {where}>"


TOLERABLE = frozenset({"mission.command"})
"""Faults that can be tolerated by leaving out the steps that have them."""


class _EveryFault(frozenset[str]):
    def __contains__(self, code: object) -> bool:
        return True


UNFINISHED: Final = _EveryFault(TOLERABLE)
"""Tolerates every fault of a mission that is being written: what it lacks is filled in. Such a
mission is for completion and hints only; targets that it does not have lead nowhere."""


def load_mission(
    path: Path,
    *,
    robot: str | None = None,
    pipe: str | None = None,
    settings: Mapping[str, str] | None = None,
    start_phase: str | None = None,
    states: Mapping[str, str] | None = None,
    fitted: Document | None = None,
    tolerated: Collection[str] = (),
) -> LoadedMission:
    """Return a mission ready to run.

    Args:
        path: The mission's file.
        robot: Name or path of a robot; overrides the mission's.
        pipe: Name or path of a pipe; overrides the mission's.
        settings: Parameter values as text, by name.
        start_phase: The first phase; overrides the mission's.
        states: Initial states of the robot by region; override ``starts_in``.
        fitted: A file with numbers of the robot's motors, instead of the profile's.
        tolerated: Codes of faults with which the mission is still returned, without the parts that
            have them, and with plausible values of parameters that nothing sets.

    Raises:
        LoadError: The files have faults; holds all of them.
        UsageError: An argument does not fit the mission.
    """
    options = robot, pipe, settings, start_phase, states, fitted, tolerated
    with noting() as asked:
        loaded = _loaded(path, *options)
    if asked.whole:
        inside, numbers = references.keeps_inside(), fitted and (fitted.name, fitted.complete_text)
        given = str(path), here(), inside, *options[:5], numbers, sorted(tolerated)
        origin = sha256(repr((given, asked.answers)).encode())
        object.__setattr__(loaded, "origin", origin.hexdigest())
    return loaded


def _loaded(
    path: Path,
    robot: str | None,
    pipe: str | None,
    settings: Mapping[str, str] | None,
    start_phase: str | None,
    states: Mapping[str, str] | None,
    fitted: Document | None,
    tolerated: Collection[str],
) -> LoadedMission:
    document = read_document(path)
    problems = Problems(document)
    mission = _shape(document, problems, tolerated)
    folder = resolved(path).parent
    loaded = with_fitted(_robot(robot, mission, folder, problems), fitted)
    if robot is not None:
        shadow = library.shadowing(robot, loaded.folder)
    else:
        shadow = _shadowing(mission, loaded, problems)
    chosen, pipe_name, pipe_document = _pipe(pipe, mission, document, folder, problems)
    chosen = _along(chosen, mission, problems)
    if chosen is not None:
        check_fit(chosen, loaded.profile, pipe_document, problems)
    values = _values(mission, settings or {}, problems, assumed=bool(tolerated))
    spec = loaded.oriented(mission.polarity or "normal")
    if start_phase is not None and start_phase not in mission.phases:
        raise UsageError(_unknown("phase", [start_phase], mission.phases))
    source = Source(mission, document, path)
    program, called = build_program(
        source, loaded, values, start_phase, states, problems, tolerated
    )
    problems.raise_errors(tolerated)
    if chosen is not None:
        length_m = sum(link.length for link in loaded.profile.body.links)
        bores_m = chosen.bores_m(length_m)
        program = replace(program, diameter_m=bores_m[0], bores_m=bores_m)
    documents = (document, *loaded.documents, *called, pipe_document)
    hashes = {each.name: _hash(each) for each in documents}
    texts = {name: value.text for name, value in values.items()}
    notices = (shadow,) if shadow else ()
    spec = holding_in(spec, loaded.profile, chosen)
    found = documents, hashes, texts, notices, problems.all
    return LoadedMission(mission, loaded, spec, program, chosen, pipe_name, *found)


def _shadowing(mission: Mission, loaded: LoadedRobot, problems: Problems) -> str:
    """Report and return a notice if another robot hides the shipped one; empty if none does."""
    shadow = library.shadowing(mission.robot, loaded.folder)
    if shadow:
        problems.add(
            "mission.robot_shadows",
            ("robot",),
            shadow,
            expected=f"./{mission.robot}, a path",
            severity=Severity.WARNING,
        )
    return shadow


def _shape(document: Document, problems: Problems, tolerated: Collection[str]) -> Mission:
    """Return the mission of the document, without its faulty parts if faults are tolerated."""
    mission = try_validate(document, Mission, problems)
    if mission is None:
        refuse_other(document, FileKind.MISSION)
        if part_of(document):
            check_section(document, problems)
    if mission is None and tolerated is UNFINISHED:
        mission = _filled_in(document)
    elif mission is None and tolerated:
        mission = _without_faulty_parts(document)
    if mission is None:
        problems.raise_errors()
        raise AssertionError("raise_errors raises here")
    return mission


def _robot(robot: str | None, mission: Mission, folder: Path, problems: Problems) -> LoadedRobot:
    if robot is not None:
        found = library.find_robot(robot, Path.cwd())
    try:
        if robot is None:
            found = library.find_robot(mission.robot, folder)
        return load_robot(found)
    except UsageError as error:
        problems.add("mission.robot", ("robot",), str(error))
    except LoadError as error:
        problems.take(error)
    raise LoadError(problems.all)


def _pipe(
    pipe: str | None, mission: Mission, document: Document, folder: Path, problems: Problems
) -> tuple[Pipe | None, str, Document]:
    if pipe is not None:
        found, source = load_pipe(library.find_pipe(pipe, Path.cwd()))
        return found, found.pipe or pipe, source
    if isinstance(mission.pipe, Pipe):
        return mission.pipe, mission.pipe.pipe or mission.mission, document
    if mission.pipe is None:
        return None, "", document
    try:
        file = references.followed(library.find_pipe(mission.pipe, folder), folder)
        found, source = load_pipe(file)
    except UsageError as error:
        problems.add(references.code_of(error, "mission.pipe"), ("pipe",), str(error))
        return None, mission.pipe, document
    except LoadError as error:
        references.tell(error, file, references.PIPE, ("pipe",), problems)
        return None, mission.pipe, document
    return found, found.pipe or mission.pipe, source


def _along(pipe: Pipe | None, mission: Mission, problems: Problems) -> Pipe | None:
    """Return the pipe with the mission's route, and report a route that it does not have."""
    route = mission.route
    if pipe is None or route is None:
        return pipe
    known = pipe.ways if pipe.runs is not None else {}
    if route in known:
        return pipe.along(route)
    problems.add_unknown("mission.route", ("route",), "route", route, known, none="no routes")
    return pipe


def _values(
    mission: Mission, settings: Mapping[str, str], problems: Problems, *, assumed: bool
) -> parameters.Values:
    """Return the parameter values; with `assumed`, missing ones get a plausible value."""
    values = parameters.defaults(mission.parameters, problems)
    wrong = [_unknown("parameter", settings, mission.parameters)]
    for name, text in settings.items():
        if name in mission.parameters:
            try:
                value = parameters.read_value(mission.parameters[name], text)
            except QuantityError as error:
                wrong.append(f"parameter '{name}': {error}")
            else:
                values[name] = parameters.Value(value, text)
    if any(wrong):
        raise UsageError("\n".join(filter(None, wrong)))
    if assumed:
        sampled = {name: parameters.sample(each) for name, each in mission.parameters.items()}
        return sampled | values
    missing = [name for name, each in mission.parameters.items() if each.default is None]
    if missing := [name for name in missing if name not in values]:
        names = " and ".join(f"'{name}'" for name in missing)
        has, it = ("s {} have", "them") if missing[1:] else (" {} has", "it")
        options = " ".join(f"--set {name}=…" for name in missing)
        arguments = ", ".join(f"'{name}': …" for name in missing)
        hint = Hint(f": give {it} with {options}", f": give {it} with set={{{arguments}}}")
        raise UsageError(f"parameter{has.format(names)} no default", hint=hint)
    return values


def _unknown(kind: str, names: Iterable[str], known: Mapping[str, object]) -> str:
    return unknown(f"the mission has no {kind}", names, known, "" if known else "it has none")


def _hash(document: Document) -> str:
    return sha256(document.complete_text.encode()).hexdigest()


_NAMING = frozenset({"mission", "robot", "parameters", "start", "phases", "ends"})
"""Keys that a mission needs, or whose names its other parts use."""


def _without_faulty_parts(document: Document) -> Mission | None:
    """Return the mission with its faulty phases and ends emptied, without other faulty parts.

    This allows checking the names in all the rest. An emptied phase leads to itself. It is None if
    a part is faulty without which nothing can be said of the rest.
    """
    data, fields = document.data, Mission.model_fields
    try:
        return Mission.model_validate(data, **_LIKE_A_FILE)
    except ValidationError as error:
        places = [each["loc"] for each in error.errors(include_url=False) if each["loc"]]
    entries = [loc[:2] for loc in places if loc[0] in _EMPTIED and len(loc) > 1]
    faulty = {str(loc[0]) for loc in places if loc[:2] not in entries}
    naming = _NAMING & {key if key in fields else meant_key(key, fields) for key in faulty}
    if naming or not isinstance(data, dict):
        return None
    rest = {"format": 1, **{key: value for key, value in data.items() if key not in faulty}}
    for section, key in _EMPTIED.items():
        kept = rest[section].items()
        rest[section] = {n: {key: n} if (section, n) in entries else body for n, body in kept}
    try:
        return Mission.model_validate(rest, **_LIKE_A_FILE)
    except ValidationError:
        return None


def _filled_in(document: Document) -> Mission | None:
    """Return the mission with all that it lacks; None if the document holds no mapping.

    Its phases and ends are those of the document. Without a robot it is for the first shipped one.
    """
    from pirate_sm.core._loading.yaml.filled_in import filled_in  # noqa: PLC0415 - for editors only

    if not isinstance(document.data, dict):
        return None
    data = {"robot": library.robots()[0].name, **document.data}
    filled = filled_in(Mission, data)
    if filled is None:
        return None
    mission = Mission.model_validate(filled, **_LIKE_A_FILE)
    written = {key: data.get(key) or () for key in _EMPTIED}
    named = {
        key: {name: each for name, each in getattr(mission, key).items() if name in written[key]}
        for key in _EMPTIED
    }
    start = mission.start if "start" in data else next(iter(named["phases"]), mission.start)
    return mission.model_copy(update={**named, "start": start})


_EMPTIED = {"phases": "go", "ends": "succeed"}
"""Sections whose faulty entries are emptied, each with the key of what is left of one."""

_LIKE_A_FILE: Final[dict[str, Any]] = {
    "context": dict(FROM_FILE),
    "by_alias": True,
    "by_name": False,
}


def holding_in(robot: RobotSpec, profile: Profile, pipe: Pipe | None) -> RobotSpec:
    """Return the robot whose parts count as clamped only with a torque that holds it in a pipe.

    Each part must be able to hold the robot alone at the steepest place of the route, with the
    friction of the pipe. An unknown pipe is as steep, and as narrow, as can be.
    """
    numbers, body = robot.vocabulary.numbers, profile.body
    weight_n = body.mass_kg * GRAVITY_M_S2
    friction = ((pipe and pipe.friction) or profile.simulation.friction).static
    least_nm: dict[int, float] = {}
    for part in body.parts:
        apex, leg_m = body.apex_of(part), min(body.legs_m(part), default=0.0)
        if apex is not None and apex.torque in numbers:
            least_nm[numbers.index(apex.torque)] = max(
                holding_nm(weight_n * slope, friction, leg_m, bore_m - 2 * body.wheel_radius)
                for slope, bore_m in _steep_places(pipe, 2 * body.wheel_radius)
            )
    commands, sight = _with_torques(robot, tuple(least_nm.items()))
    # Each mission has a robot of its own: what is compiled of its triggers is kept with that.
    return replace(robot, commands=commands, sight=sight)


@lru_cache(maxsize=16)  # most missions are for the same few pipes
def _with_torques(
    robot: RobotSpec, torques: tuple[tuple[int, float], ...]
) -> tuple[tuple[CommandSpec, ...], Sight]:
    """Return its commands and its sight with these torques as the smallest, by number indexes."""
    least_nm = dict(torques)
    commands = tuple(
        replace(
            command,
            done=_asked_of(command.done, least_nm),
            postures=tuple(
                each and replace(each, done=_asked_of(each.done, least_nm))
                for each in command.postures
            ),
        )
        for command in robot.commands
    )
    parts = tuple(each and _held(each, least_nm) for each in robot.sight.parts)
    return commands, replace(robot.sight, parts=parts)


def _steep_places(pipe: Pipe | None, narrowest_m: float) -> Iterator[tuple[float, float]]:
    """Yield the slope, as a sine, and the inner diameter of each piece of a route."""
    if pipe is None:
        yield 1.0, narrowest_m
        return
    route, turns = pipe.route(), pipe.turns
    ups = [route.up] if turns is None else [route.up, tilted_up(turns.tilt, pipe.uphill)]
    for piece in route.pieces:
        yield max(abs(dot(up, piece.frame.ahead)) for up in ups), piece.diameter_m


def _asked_of(criterion: CriterionSpec, least_nm: Mapping[int, float]) -> CriterionSpec:
    """Return the criterion with these torques as the smallest, by their number indexes.

    A criterion that names a torque instead of a share means just that torque.
    """
    if not any(it.full_nm for it in criterion.asked(TorqueBorne)):
        return criterion
    raised = _raised(criterion, least_nm)
    return replace(raised, settled=criterion.settled and _raised(criterion.settled, least_nm))


def _raised(criterion: CriterionSpec, least_nm: Mapping[int, float]) -> CriterionSpec:
    demands = tuple(
        each._replace(least_nm=max(each.least_nm, least_nm.get(each.torque, 0.0)))
        if isinstance(each, TorqueBorne)
        else each
        for each in criterion.demands
    )
    return replace(criterion, demands=demands)


def _held(held: HeldSpec, least_nm: Mapping[int, float]) -> HeldSpec:
    joints = []
    for joint in held.joints if held.settled_s < inf else ():
        least = least_nm.get(joint.torque, 0.0)
        needed_nm, least = max(joint.needed_nm, least), max(joint.least_nm, least)
        joints.append(joint._replace(needed_nm=needed_nm, least_nm=least))
    return held._replace(joints=tuple(joints) or held.joints)


def _read_only(values: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    return MappingProxyType(values)


def _reduced(view: MappingProxyType[Any, Any]) -> tuple[Any, ...]:
    return _read_only, (dict(view),)


# A loaded mission holds read-only views, of which :mod:`pickle` knows nothing itself.
pickle(MappingProxyType, _reduced)
