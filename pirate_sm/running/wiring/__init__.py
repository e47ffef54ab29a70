"""Puts mission, engine, backend and detector together; the only place that picks a backend."""

# mypy: implicit-reexport
from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.core import library
from pirate_sm.core.documents import Document, read_document
from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import Hint, UsageError
from pirate_sm.core.loading import (
    LoadedMission,
    holding_in,
    load_mission,
    simulated_profile,
    twin_named,
)
from pirate_sm.core.options import OPTIONS, OTHERS
from pirate_sm.core.program import Wait
from pirate_sm.core.registry import Registry
from pirate_sm.robot import part_names
from pirate_sm.robot.detectors.registry import (
    NOBODY,
    Asked,
    Detecting,
    SecondDetector,
    counts,
    detecting,
    speaks_of_bends,
)
from pirate_sm.running.wiring.prepared import (
    Equipment,
    MakeBackend,
    Order,
    Prepared,
    Say,
    choose_panel,
)

if TYPE_CHECKING:
    from pirate_sm.running.runtime.phase_times import EarlierRuns

BACKENDS: Registry[MakeBackend] = Registry(
    "backend",
    part_names.BACKEND_GROUP,
    {name: f"pirate_sm.running.wiring.backends:{name.upper()}" for name in part_names.BACKENDS},
    returns=Equipment,
)


def load(order: Order) -> LoadedMission:
    """Read the files of the order.

    Raises:
        LoadError: The files have errors; it lists all of them.
        UsageError: An argument does not fit.
    """
    return load_mission(
        library.find_mission(order.mission),
        robot=order.robot,
        pipe=order.pipe,
        settings=order.settings,
        start_phase=order.start_phase,
        states=order.states,
        fitted=fit_of(order),
    )


def fit_of(order: Order) -> Document | None:
    """Return the order's file with fitted numbers; None without one.

    Raises:
        LoadError: It cannot be read.
    """
    return None if order.fitted is None else read_document(order.fitted)


def prepare(
    order: Order, loaded: LoadedMission | None = None, say: Say = lambda text: None
) -> Prepared:
    """Return mission, engine and backend, ready to run, without moving anything.

    Args:
        order: The options of the run.
        loaded: The result of :func:`load`, if it was called before.
        say: Takes messages about steps that take longer than a moment.

    Raises:
        LoadError: The files have errors; it lists all of them.
        UsageError: An argument does not fit, or an optional part is not installed.
        CheckError: The mission is refused.
        BackendError: A backend of another package has failed.
    """
    make = BACKENDS.find(order.backend)
    _refuse_for_others(order)
    loaded = loaded or load(order)
    if order.breakpoints:
        from pirate_sm.running.runtime.breakpoints import breakpoints

        breakpoints(loaded, order.breakpoints, "--break ")
    if order.check:
        from pirate_sm.checking.gate import pass_or_raise

        pass_or_raise(loaded, words_of_bends=speaks_of_bends(order.detector), backend=order.backend)
    forecast = None if order.forecast is None else _forecast(order.forecast, loaded)
    made = make(order, loaded, say)
    loaded = made.loaded or loaded
    found = _detecting(order, loaded, made)
    nominal = made.backend.completion == "nominal"
    given = {each.name: getattr(made, each.name) for each in fields(Equipment)}
    prepared = Prepared(
        **{
            **given,
            "loaded": loaded,
            "companions": (*made.companions, *found.companions),
            "notices": (*loaded.notices, *made.notices, *found.notices),
        },
        order=_drawn(order, loaded),
        engine=Engine(loaded.robot, loaded.program, nominal=nominal),
        detecting=found,
        panel=choose_panel(order.panel, loaded.loaded_robot) if order.panel is not None else None,
    )
    return prepared if forecast is None else _foretold(prepared, forecast)


def _forecast(file: str, loaded: LoadedMission) -> EarlierRuns:
    """Return what earlier runs of a mission say.

    Raises:
        LoadError: Their file has errors.
        UsageError: They are of another mission, or of another text of it.
    """
    from pirate_sm.running.recording.forecast_file import forecast_for, read_forecast

    return read_forecast(Path(file), forecast_for(loaded)).times


def _foretold(prepared: Prepared, forecast: EarlierRuns) -> Prepared:
    """Return the run compared with earlier ones."""
    from pirate_sm.running.runtime.phase_times import ForecastWatch

    watch = ForecastWatch(forecast)
    return replace(
        prepared,
        forecast=watch,
        companions=(*prepared.companions, watch),
        notices=(*prepared.notices, forecast.notice),
    )


def _drawn(order: Order, loaded: LoadedMission) -> Order:
    """Return the order with what its seed draws written out: a twin, numbers of defects."""
    if order.twin is not None:
        file, number = twin_named(order.twin, order.seed)
        order = order if number is None else replace(order, twin=f"{file}#{number}")
    if not any(".." in text for text in order.defects):
        return order
    from pirate_sm.simulation.defects import drawn

    return replace(order, defects=drawn(order.defects, loaded.loaded_robot.profile, order.seed))


def _refuse_for_others(order: Order) -> None:
    """Refuse options that the backend does not have, instead of running without them.

    Raises:
        UsageError: One is given.
    """
    ours = order.backend in part_names.BACKENDS
    if ours and order.backend != "trace" and (order.firings or order.course):
        hint = Hint(": use --backend trace", ": use backend='trace'")
        raise UsageError("triggers can be fired in a trace only", hint=hint)
    if ours and order.backend != "bay" and order.line is not None:
        hint = Hint(": use --backend bay, or leave out --line", ": use backend='bay'")
        raise UsageError(f"the backend {order.backend} has no emulated line", hint=hint)
    backend = order.backend if ours else OTHERS
    given = [each for name, each in OPTIONS.items() if getattr(order, name) != each.default]
    wrong = [each for each in given if each.only and backend not in each.only.backends]
    if wrong and (only := wrong[0].only):
        alike = [each for each in wrong if each.only == only]
        flags, names = ", ".join(o.flag for o in alike), ", ".join(o.name for o in alike)
        use = only.backends[0]
        raise UsageError(
            f"the backend {order.backend} {only.lacks}",
            hint=Hint(
                f": use --backend {use}, or leave out {flags}",
                f": use backend='{use}', or leave out {names}",
            ),
        )


def _detecting(order: Order, loaded: LoadedMission, made: Equipment) -> Detecting:
    """Return the detector of the run."""
    if made.usual_detector is None:
        if (order.detector, order.also, order.start_at_m) != (None, None, None):
            raise UsageError(
                f"the backend {order.backend} takes no detector and no start position",
                hint=Hint(" (--detector, --start-at)", " (detector, start_at_m)"),
            )
        return NOBODY
    of_robot, robot = loaded.loaded_robot.profile, loaded.robot
    # A twin says how far the words of a simulated detector are off, too.
    profile = simulated_profile(of_robot, order.twin, order.seed, order.numbers)
    asked = Asked(
        profile, robot, loaded.pipe, order.start_at_m, made.places, made.wheels, order.seed
    )
    found = detecting(order.detector, made.usual_detector, asked)
    return found if order.also is None else _with_another(found, order.also, asked)


def _with_another(found: Detecting, also: str, asked: Asked) -> Detecting:
    """Return the detector with a second one, whose words are logged only.

    Raises:
        UsageError: The second one is the operator, or cannot be made.
    """
    start_m = asked.first_wheel_m if counts(also) else None
    other = detecting(also, also, replace(asked, first_wheel_m=start_m))
    if other.kind == "operator":
        raise UsageError("the operator's keys are for the mission; name another second detector")
    seconds = tuple(SecondDetector(other.kind, each) for each in other.companions)
    notices = tuple(f"also {notice}" for notice in other.notices)
    return found._replace(
        companions=(*found.companions, *seconds), notices=(*found.notices, *notices)
    )


def placed(prepared: Prepared, start_at_m: float) -> Prepared:
    """Return the run with its detector counting from this place of the first wheel, in m.

    Raises:
        UsageError: The place is outside the pipe.
    """
    order, before = replace(prepared.order, start_at_m=start_at_m), prepared.detecting
    found = _detecting(order, prepared.loaded, prepared)
    others = (each for each in prepared.companions if each not in before.companions)
    notices = (each for each in prepared.notices if each not in before.notices)
    return replace(
        prepared,
        order=order,
        companions=(*others, *found.companions),
        notices=(*notices, *found.notices),
        detecting=found,
    )


def chosen(order: Order, mission: str) -> Order:
    """Return the order with another mission, and without what was ordered for the one before."""
    return replace(
        order,
        mission=mission,
        settings={},
        start_phase=None,
        states=None,
        forecast=None,
        breakpoints=(),
    )


def again(prepared: Prepared, loaded: LoadedMission, *, other: bool = False) -> Prepared:
    """Return another run on the same open backend, with the robot where the last one left it.

    Args:
        prepared: The run before.
        loaded: The mission.
        other: Whether the mission was chosen instead of the ordered one.

    Raises:
        UsageError: The mission is for another robot.
    """
    before = prepared.loaded
    if loaded.loaded_robot.folder != before.loaded_robot.folder:
        name = before.loaded_robot.profile.robot
        raise UsageError(f"{loaded.mission.mission} is for {loaded.robot.name}, this is {name}")
    order = chosen(prepared.order, loaded.mission.mission) if other else prepared.order
    if other:
        companions = (each for each in prepared.companions if each is not prepared.forecast)
        prepared = replace(prepared, companions=tuple(companions), forecast=None)
    # The robot stays in the same pipe, whatever pipe the mission names.
    own = loaded.loaded_robot
    robot = holding_in(own.oriented(loaded.robot.polarity), own.profile, before.pipe)
    loaded = prepared.adapted(replace(loaded, robot=robot))
    program = replace(loaded.program, diameter_m=before.program.diameter_m)
    loaded = replace(loaded, program=program, pipe=before.pipe, pipe_name=before.pipe_name)
    engine = Engine(loaded.robot, loaded.program, nominal=prepared.engine.nominal)
    return replace(prepared, order=order, loaded=loaded, engine=engine, notices=(), resumed=None)


def answers(loaded: LoadedMission) -> dict[str, tuple[str, ...]]:
    """Return the operator's words that the wait of each phase listens to."""
    heard: dict[str, tuple[str, ...]] = {}
    for instruction in loaded.program.instructions:
        if isinstance(instruction, Wait):
            words = tuple(each.answer for each in instruction.triggers if each.answer)
            if words:
                heard[instruction.phase] = words
    return heard
