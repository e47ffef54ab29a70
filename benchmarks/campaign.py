"""Many runs of missions in the simulator, without a view, as fast as they go."""

from __future__ import annotations

from argparse import ArgumentParser, RawTextHelpFormatter
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache, partial
from math import nan
from multiprocessing import get_context
from os import cpu_count
from time import perf_counter, process_time
from typing import TYPE_CHECKING, TypeAlias

from pirate_sm.companion import entered
from pirate_sm.detectors.word_timing import words_of
from pirate_sm.model.effects import Detected, Effect, Fault, Setpoints, StateChange

# Clamps that have just been taken settle for this long; then the robot is watched for this long.
_SETTLING_S, _WATCHED_S = 5.0, 2.0
WATCHED_AFTER_S = _SETTLING_S + _WATCHED_S
"""How long a run goes on after its mission."""

if TYPE_CHECKING:
    from pirate_sm.backends.protocol import Backend
    from pirate_sm.engine.robot.robot_spec import RobotSpec
    from pirate_sm.loading.mission import LoadedMission
    from pirate_sm.wiring import Order, Prepared


def options_of_rows(
    about: str | None, rows: Sequence[str], seeds: int | None, counted: str
) -> ArgumentParser:
    """Return the options of a command that runs rows of many seeds.

    Args:
        about: What the command does.
        rows: The names of the rows, of which some can be chosen.
        seeds: How many seeds it runs by default.
        counted: What the number of seeds counts.
    """
    parser = ArgumentParser(description=about, formatter_class=RawTextHelpFormatter)
    parser.add_argument("--row", action="append", choices=rows)
    parser.add_argument("--seeds", type=int, default=seeds, help=counted)
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    return parser


@dataclass
class Notes:
    """What a run leaves behind.

    Attributes:
        word: What the detector said last.
        travel: Which way the wheels were driven last: 1 forward, -1 backward.
        late_m: For each word that was reported, how far its wheel was beyond the word's point.
    """

    robot: RobotSpec
    beyond_m: Callable[[str, int], float]
    word: str = ""
    travel: int = 0
    states: list[tuple[str, ...]] = field(default_factory=list)
    unconfirmed: tuple[str, ...] = ()
    faults: list[str] = field(default_factory=list)
    late_m: list[tuple[str, float]] = field(default_factory=list)

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """States and faults are noted."""
        for effect in effects:
            if isinstance(effect, StateChange):
                self.states.append(effect.states)
                self.unconfirmed = effect.unconfirmed
            elif isinstance(effect, Fault):
                self.faults.append(f"{effect.code} ({effect.handling})")
            elif isinstance(effect, Detected):
                self.word = effect.word
                if effect.word:
                    self.late_m.append((effect.word, self.beyond_m(effect.word, self.travel)))
            elif isinstance(effect, Setpoints):
                self.travel = self.robot.travel(effect.values) or self.travel


@dataclass(frozen=True)
class Outcome:
    """One run.

    Attributes:
        fell: Whether a robot that had clamped left the pipe or opened every clamp it confirmed.
        arcs_m: Where each wheel ended along the pipe.
        stopped: Whether the last setpoints that were sent had every wheel at zero.
        torques: What each bend joint bears, Nm.
        slid_m: How far a wheel is carried in two seconds, once the robot has settled after the end.
        short_m: How far the wheel of the detector's last word is short of the place that the word
            means, by the truth; NaN where none was said, negative where the wheel is beyond it.
        deepest_m: How deep a wheel or link was in a wall, at most; NaN if unknown.
        late_m: Each word that was reported, and how far its wheel was beyond the word's point then,
            by the truth; negative: the word came too early.
        took_s: How long the run has taken, without what was looked at afterwards; ``cpu_s`` is
            the time of its processor, without preparation.
    """

    seed: int
    outcome: str
    message: str
    exit_code: int
    time_s: float
    distance_m: float
    arcs_m: tuple[float, ...]
    gone: bool
    stopped: bool
    states: tuple[tuple[str, ...], ...]
    faults: tuple[str, ...]
    held_at_end: bool
    torques: tuple[float, ...]
    slid_m: float
    short_m: float
    late_m: tuple[tuple[str, float], ...]
    deepest_m: float = nan
    took_s: float = field(default=0.0, compare=False, repr=False)
    cpu_s: float = field(default=0.0, compare=False, repr=False)


MotorValue: TypeAlias = tuple[str, str, float]
"""A kind of motor, a key of it, and a value in SI in place of the profile's."""


@cache
def _loaded(
    mission: str,
    pipe: str | None,
    settings: tuple[tuple[str, str], ...],
    motors: tuple[MotorValue, ...],
) -> LoadedMission:
    from pirate_sm.wiring import Order, load

    loaded = load(Order(mission, pipe=pipe, settings=dict(settings)))
    profile = loaded.loaded_robot.profile
    for name, key, value in motors:
        motor = profile.motors[name].model_copy(update={key: value})
        profile = profile.model_copy(update={"motors": {**profile.motors, name: motor}})
    return replace(loaded, loaded_robot=replace(loaded.loaded_robot, profile=profile))


def run(order: Order, motors: tuple[MotorValue, ...] = ()) -> Outcome:
    """Run the mission to its end.

    Args:
        order: What to run.
        motors: What the simulated motors do in place of what the profile says.
    """
    from pirate_sm.runtime.first_choice import FirstChoice
    from pirate_sm.runtime.loop import MissionRun
    from pirate_sm.wiring import prepare

    began = perf_counter()
    prepared = prepare(
        order, _loaded(order.mission, order.pipe, tuple(order.settings.items()), motors)
    )
    backend = prepared.backend
    notes = Notes(
        prepared.engine.robot,
        lambda word, travel: -_short_m(prepared, word, travel, backend.truth.arcs_m),  # type: ignore[attr-defined]
    )
    run_ = MissionRun(
        prepared.engine, prepared.backend, observers=[notes],
        companions=(*prepared.companions, FirstChoice()),
    )  # fmt: skip
    with entered(prepared.companions):
        cpu_s = process_time()
        result = run_.execute()
        cpu_s = process_time() - cpu_s
    took_s = perf_counter() - began
    assert run_.state is not None
    engine, state = prepared.engine, run_.state
    real = prepared.backend.truth  # type: ignore[attr-defined]
    slid_m = _slid_m(prepared.backend, result.now_s)
    return Outcome(
        order.seed, result.ended.outcome, result.ended.message, result.exit_code, result.now_s,
        real.distance_m, real.arcs_m, real.gone,
        all(state.robot.latest[slot] == 0 for slot in engine.robot.safe_zero),
        tuple(notes.states), tuple(notes.faults),
        bool(engine.robot.held[state.robot.configuration]),
        real.torques_nm, slid_m, _short_m(prepared, notes.word, notes.travel, real.arcs_m),
        tuple(notes.late_m),
        getattr(backend.robot.physics, "deepest_m", nan),  # type: ignore[attr-defined]
        took_s, cpu_s,
    )  # fmt: skip


def _short_m(prepared: Prepared, name: str, travel: int, arcs_m: Sequence[float]) -> float:
    """How far short of a word's place, at the nearest bend, its wheel is."""
    words = {word.name: word for word in words_of(prepared.loaded.loaded_robot.profile)}
    word = words.get(name)
    if word is None or not travel:
        return nan
    point = word.forward if travel > 0 else word.backward
    return min(
        (
            point.passed_m - travel * (arcs_m[point.wheel] - crossing)
            for crossing, _ in prepared.backend.bends  # type: ignore[attr-defined]
        ),
        key=abs,
        default=nan,
    )


def _slid_m(backend: Backend, now_s: float) -> float:
    """Return how far a wheel is carried when the last setpoints stay in force for a while."""
    places = []
    for end_s in (now_s + _SETTLING_S, now_s + _SETTLING_S + _WATCHED_S):
        while now_s < end_s:
            now_s, _ = backend.advance(end_s)
        places.append(backend.truth.arcs_m)  # type: ignore[attr-defined]
    return max(abs(new - old) for old, new in zip(*places, strict=True))


def run_all(
    orders: Iterable[Order],
    *,
    workers: int | None = None,
    motors: tuple[MotorValue, ...] = (),
) -> list[Outcome]:
    """Run every mission; return the outcomes in the order of the orders.

    Args:
        orders: What to run.
        workers: How many processes share the work; one for each processor by default. The
            outcomes are the same for any number.
        motors: What the simulated motors do in place of what the profile says.
    """
    wanted = list(orders)
    one = partial(run, motors=motors)
    one(wanted[0])  # compiles the simulator once, before the others need it
    with ProcessPoolExecutor(workers or cpu_count() or 1, mp_context=get_context("spawn")) as pool:
        return list(pool.map(one, wanted, chunksize=max(1, len(wanted) // 64)))
