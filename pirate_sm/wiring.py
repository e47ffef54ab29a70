"""The one place that picks a backend and puts mission, engine and backend together."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NoReturn

from pirate_sm.detectors.choice import Detecting, Kind, detecting
from pirate_sm.detectors.odometry import Odometry
from pirate_sm.detectors.true_places import TruePlaces
from pirate_sm.engine.engine import Engine
from pirate_sm.engine.mission.program import Wait
from pirate_sm.engine.robot.robot_state import at_rest_in
from pirate_sm.errors import UsageError
from pirate_sm.loading import library
from pirate_sm.loading.mission import LoadedMission, load_mission
from pirate_sm.model.course import Happening
from pirate_sm.model.truth import Truth
from pirate_sm.runtime.companions import Companion, Firing, LoopWatch, TriggerScript
from pirate_sm.spelling import nearest, one_of

if TYPE_CHECKING:
    from pirate_sm.backends.pico.health import LinkHealth
    from pirate_sm.backends.protocol import Backend
    from pirate_sm.runtime.loop import MissionRun

_Say = Callable[[str], None]

BACKENDS: Mapping[str, str] = {
    "serial": "the real robot, at the port given with --port",
    "sim": "the kinematic simulator",
    "trace": "nothing moves; shows what would be sent",
}

COMPILING = (
    "Compiling the simulator to machine code for this processor, so that it runs hundreds of "
    "times faster than real time: some ten seconds, once ..."
)

_COMPILED = {"llvmlite", "numba", "numpy"}
"""What the extra `sim` installs."""


@dataclass(frozen=True)
class Order:
    """What somebody wants to be run, in their own words.

    Attributes:
        mission: Name of a shipped mission, or the path of a file.
        backend: One of ``BACKENDS``.
        robot: Name or path, in place of the mission's own; likewise ``pipe``.
        settings: Values of parameters, as text.
        start_phase: The phase to begin with, in place of the mission's own.
        states: State names by region that the robot is in, in place of the mission's own.
        seed: Of everything random.
        start_jitter_m: How far a simulated robot may start from its place; likewise
            ``diameter_jitter_m`` of the pipe, and ``friction_jitter`` as a share.
        defects: Known defects that the simulated robot has.
        firings: What a trace fires instead of the first trigger of each wait.
        course: What happens in a trace, everything and in order.
        detector: Who says the detector's words, ``odometry``, ``operator``, ``socket:ADDRESS`` or
            ``sim``; None for what is usual on the backend.
        start_at_m: Where odometry takes the first wheel to begin, in place of the pipe's own.
        port: Where the real robot is, a device or a URL of pyserial; ``baud`` in place of the
            robot's own rate.
        guard_for_s: How long a guardian goes on without us if the robot does not confirm its stop;
            None: the usual time.
        calibration: Whether the joint zeros of the real robot are subtracted, where it has any.
        check: Whether a mission with something certainly wrong is refused.
    """

    mission: str
    backend: str = "sim"
    robot: str | None = None
    pipe: str | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    start_phase: str | None = None
    states: Mapping[str, str] | None = None
    seed: int = 0
    start_jitter_m: float = 0.0
    friction_jitter: float = 0.0
    diameter_jitter_m: float = 0.0
    defects: tuple[str, ...] = ()
    firings: tuple[Firing, ...] = ()
    course: tuple[Happening, ...] = ()
    detector: str | None = None
    start_at_m: float | None = None
    port: str | None = None
    baud: int | None = None
    guard_for_s: float | None = None
    calibration: bool = True
    check: bool = False


@dataclass(frozen=True)
class Prepared:
    """Everything that a run needs; nothing has moved.

    Attributes:
        companions: Who must be beside the mission for this backend.
        notices: What a person must know before they see the run.
        truth: Where the robot really is, for backends that know.
        wheels: The same of its wheels alone, in the plane of the pipe, m, for whoever asks often.
        reckoned: Where a detector takes it to be, where one does; None before it knows.
        link: How the link is, where there is one.
        parting: What a person must do once the run has ended; empty: nothing.
        confirmation: What a person must agree to before anything moves; empty: nothing.
        follow: Must be given the run before it begins.
        detector: Who says the detector's words; ``operator`` still wants a keyboard.
        attended: Whether a companion answers the mission's questions.
    """

    order: Order
    loaded: LoadedMission
    engine: Engine
    backend: Backend
    companions: tuple[Companion, ...] = ()
    notices: tuple[str, ...] = ()
    truth: Callable[[], Truth] | None = None
    wheels: Callable[[], tuple[tuple[float, float], ...]] | None = None
    reckoned: Callable[[], Truth | None] | None = None
    link: Callable[[], LinkHealth] | None = None
    parting: Callable[[], str] = lambda: ""
    confirmation: str = ""
    follow: Callable[[MissionRun], None] = lambda run: None
    detector: Kind = "none"
    attended: bool = False


def load(order: Order) -> LoadedMission:
    """The files are read and free of faults.

    Raises:
        LoadError: Everything that is wrong with them.
        UsageError: An argument does not fit.
    """
    return load_mission(
        library.find_mission(order.mission),
        robot=order.robot,
        pipe=order.pipe,
        settings=order.settings,
        start_phase=order.start_phase,
        states=order.states,
    )


def prepare(
    order: Order, loaded: LoadedMission | None = None, say: Callable[[str], None] | None = None
) -> Prepared:
    """Mission, engine and backend are at hand.

    Args:
        order: What is wanted.
        loaded: What :func:`load` made of it, where that has been done before.
        say: Takes what a person should know while this takes longer than a moment.

    Raises:
        LoadError: Everything that is wrong with the files.
        UsageError: An argument does not fit, or an optional part is not installed.
        CheckError: The mission is refused.
    """
    make = _BACKENDS.get(order.backend) or _unknown_backend(order.backend)
    loaded = loaded or load(order)
    if order.check:
        from pirate_sm.checking.gate import pass_or_raise

        pass_or_raise(loaded)
    made = make(order, loaded, say or (lambda text: None))
    return replace(made, notices=(*loaded.notices, *made.notices))


def again(prepared: Prepared, loaded: LoadedMission) -> Prepared:
    """Another mission on the same open backend; the robot is where the one before has left it.

    Raises:
        UsageError: It is a mission for another robot.
    """
    before = prepared.loaded
    if loaded.loaded_robot.folder != before.loaded_robot.folder:
        name = before.loaded_robot.profile.robot
        raise UsageError(f"{loaded.mission.mission} is for {loaded.robot.name}, this is {name}")
    order = replace(prepared.order, mission=loaded.mission.mission)
    if order.backend == "serial" and order.calibration:
        loaded, _ = _calibrated(loaded)
    # The robot stays in the pipe that it is in, whatever the mission was written for.
    program = replace(loaded.program, diameter_m=before.program.diameter_m)
    loaded = replace(loaded, program=program, pipe=before.pipe, pipe_name=before.pipe_name)
    engine = Engine(loaded.robot, loaded.program, nominal=prepared.engine.nominal)
    return replace(prepared, order=order, loaded=loaded, engine=engine, notices=())


def answers(loaded: LoadedMission) -> dict[str, tuple[str, ...]]:
    """The operator's words that the wait of each phase listens to."""
    heard: dict[str, tuple[str, ...]] = {}
    for instruction in loaded.program.instructions:
        if isinstance(instruction, Wait):
            words = tuple(each.answer for each in instruction.triggers if each.answer)
            if words:
                heard[instruction.phase] = words
    return heard


def _simulator(order: Order, loaded: LoadedMission, say: _Say) -> Prepared:
    if loaded.pipe is None:
        raise UsageError("the mission names no pipe to simulate: give one with --pipe NAME")
    if order.firings or order.course:
        raise UsageError("triggers can be fired in a trace only: use --backend trace")
    try:
        from pirate_sm.backends.simulator import kernel
        from pirate_sm.backends.simulator.backend import SimulatorBackend
        from pirate_sm.backends.simulator.scene import Jitter
    except ModuleNotFoundError as error:
        if error.name not in _COMPILED:
            raise
        raise UsageError(
            f"the simulator needs {error.name}, which is not installed: "
            "pip install 'pirate-sm[sim]' (or use --backend trace)"
        ) from None
    if not kernel.is_compiled():
        say(COMPILING)
    detector = _detecting(order, loaded, usual="sim")
    jitter = Jitter(order.start_jitter_m, order.friction_jitter, order.diameter_jitter_m)
    backend = SimulatorBackend(
        loaded.loaded_robot.profile,
        loaded.pipe,
        seed=order.seed,
        start_values=start_values(loaded),
        jitter=jitter,
        defects=order.defects,
    )
    if detector.kind == "sim":
        sees = TruePlaces(
            loaded.loaded_robot.profile, loaded.robot, backend.crossings_m,
            lambda: backend.arcs_m, order.seed,
        )  # fmt: skip
        detector = detector._replace(companions=(sees,))

    def truth() -> Truth:
        real = backend.truth
        return Truth(
            real.wheels, real.wheel_radius_m, real.walls, real.distance_m, real.touching,
            real.rolls_rad,
        )  # fmt: skip

    engine = Engine(loaded.robot, loaded.program, nominal=False)
    return Prepared(
        order, loaded, engine, backend, detector.companions, detector.notices, truth=truth,
        wheels=lambda: backend.wheels, detector=detector.kind,
    )  # fmt: skip


def _detecting(order: Order, loaded: LoadedMission, *, usual: Kind) -> Detecting:
    return detecting(
        order.detector,
        usual=usual,
        profile=loaded.loaded_robot.profile,
        robot=loaded.robot,
        pipe=loaded.pipe,
        first_wheel_m=order.start_at_m,
    )


def start_values(loaded: LoadedMission) -> tuple[float, ...] | None:
    """Setpoints that hold a simulated robot where its mission says it is; None at its rest.

    Only joints of held parts are driven. A part that is bending is not in a bend yet: pushed in a
    straight pipe it would lever the held part off the wall before the first command.
    """
    configuration, robot = loaded.program.start_configuration, loaded.robot
    if configuration == robot.table.initial:
        return None
    profile = loaded.loaded_robot.profile
    held = {robot.parts[part] for part in robot.held[configuration]}
    free = {joint.name for joint in profile.body.joints if joint.part not in held}
    values = at_rest_in(robot, configuration).values
    return tuple(
        0.0 if slot.joint in free else value
        for slot, value in zip(profile.slots, values, strict=True)
    )


def _serial(order: Order, loaded: LoadedMission, say: _Say) -> Prepared:
    if not order.port:
        raise UsageError("--backend serial needs a port: --port /dev/ttyACM0, or a pyserial URL")
    if order.defects:
        raise UsageError("a real robot has the defects that it has: --defect is for --backend sim")
    if order.firings or order.course:
        raise UsageError("triggers can be fired in a trace only: use --backend trace")
    from pirate_sm.backends.pico.assembly import STAY_S, read_plan, serial_backend
    from pirate_sm.runtime.companions import Holder, Messenger

    notices: tuple[str, ...] = ()
    if order.calibration:
        loaded, notices = _calibrated(loaded)
    profile = loaded.loaded_robot.profile
    plan = read_plan(loaded.loaded_robot.folder, profile, loaded.robot)
    stay_s = STAY_S if order.guard_for_s is None else order.guard_for_s
    backend = serial_backend(plan, order.port, order.baud, stay_s)
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    detector = _detecting(order, loaded, usual="odometry")
    holder, messenger = Holder(backend.hold), Messenger(backend.remark)
    question = f"{profile.robot} on {order.port} is about to move"
    return Prepared(
        order, loaded, engine, backend, (holder, messenger, *detector.companions),
        (*notices, *detector.notices),
        detector=detector.kind, confirmation=question, follow=holder.follow,
        reckoned=_reckoned(detector), link=lambda: backend.health,
        parting=backend.parting,
    )  # fmt: skip


def _reckoned(detector: Detecting) -> Callable[[], Truth | None] | None:
    """Where odometry takes the robot to be."""
    return next((each.truth for each in detector.companions if isinstance(each, Odometry)), None)


def _calibrated(loaded: LoadedMission) -> tuple[LoadedMission, tuple[str, ...]]:
    """The mission with the joint zeros of its robot, and a line that says so; or as it was."""
    from pirate_sm.loading.calibration import newest_calibration, summary, with_zeros

    calibration = newest_calibration(loaded.loaded_robot)
    if calibration is None:
        return loaded, ()
    robot = with_zeros(loaded.robot, calibration.zeros)
    return replace(loaded, robot=robot), (summary(calibration),)


def _unknown_backend(name: str) -> NoReturn:
    raise UsageError(f"there is no backend '{name}': {_meant(name, BACKENDS)}")


def _trace(order: Order, loaded: LoadedMission, say: _Say) -> Prepared:
    from pirate_sm.backends.trace import IDEAL, TraceBackend

    if order.defects:
        raise UsageError("--defect needs a robot that moves: use --backend sim")
    if order.detector is not None or order.start_at_m is not None:
        raise UsageError("--detector needs a robot that moves: use --backend sim")
    if order.course:
        return _course(order, loaded)
    _check_firings(order.firings, loaded)
    backend = TraceBackend()
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    script = TriggerScript(loaded.program, order.firings)
    watch = LoopWatch(lambda: len(script.unused))
    return Prepared(order, loaded, engine, backend, (watch, script), (IDEAL,))


def _course(order: Order, loaded: LoadedMission) -> Prepared:
    """A trace in which what happens is laid down."""
    from pirate_sm.backends.trace import SCRIPTED, TraceBackend, Verdicts
    from pirate_sm.loading.course import played
    from pirate_sm.runtime.course import CoursePlayer, longest_s

    if order.firings:
        raise UsageError("a course of events and --fire exclude each other")
    events = played(order.course, loaded.robot)
    known = [each.report for each in events if each.happening.happens == "start" and each.report]
    verdicts = Verdicts(scripted=True)
    player = CoursePlayer(
        [each for each in events if each.happening.happens != "start"],
        loaded.program, verdicts.decide, verdicts.release,
    )  # fmt: skip
    backend = TraceBackend(verdicts, known)
    # How long commands take in a trace is nothing that a time limit could be held against.
    limit_s = loaded.program.time_limit_s + longest_s(order.course, loaded.robot, loaded.program)
    engine = Engine(loaded.robot, replace(loaded.program, time_limit_s=limit_s), nominal=True)
    return Prepared(order, loaded, engine, backend, (player,), (SCRIPTED,), attended=True)


def _check_firings(firings: tuple[Firing, ...], loaded: LoadedMission) -> None:
    waits = [each for each in loaded.program.instructions if isinstance(each, Wait)]
    phases = {wait.phase for wait in waits}
    for firing in firings:
        if firing.phase and firing.phase not in phases:
            raise UsageError(
                f"no phase '{firing.phase}' waits for anything: {_meant(firing.phase, phases)}"
            )
        here = [wait for wait in waits if firing.phase in ("", wait.phase)]
        triggers = {trigger.name for wait in here for trigger in wait.triggers} | {"within"}
        if firing.trigger not in triggers:
            raise UsageError(
                f"nothing waits for a trigger '{firing.trigger}': "
                f"{_meant(firing.trigger, triggers)}"
            )


def _meant(word: str, known: Mapping[str, object] | set[str]) -> str:
    close = nearest(word, known)
    return f"did you mean '{close}'?" if close else f"expected {one_of(sorted(known))}"


_BACKENDS: Mapping[str, Callable[[Order, LoadedMission, _Say], Prepared]] = {
    "serial": _serial,
    "sim": _simulator,
    "trace": _trace,
}
