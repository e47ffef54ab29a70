"""Runs one mission in a simulator, as fast as it goes, and judges it by the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from math import nan
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias, cast

from pirate_sm.core.companion import entered
from pirate_sm.core.effects import Detected, Effect, Fault, Setpoints, StateChange
from pirate_sm.core.errors import ExitCode, UsageError
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.robot.detectors.word_timing import words_of
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, Prepared, prepare

if TYPE_CHECKING:
    from pirate_sm.core.loading import LoadedMission
    from pirate_sm.core.robot import RobotSpec
    from pirate_sm.robot.backends.protocol import Backend
    from pirate_sm.running.runtime.pump import Tap
    from pirate_sm.simulation.bay.virtual import VirtualPort
    from pirate_sm.simulation.simulated_robot import FullTruth


# Clamps that have just been taken settle for this long; then the robot is watched for this long.
_SETTLING_S, _WATCHED_S = 5.0, 2.0
WATCHED_AFTER_S = _SETTLING_S + _WATCHED_S
"""How long a run continues after its mission."""


@dataclass
class RunNotes:
    """What a run leaves behind.

    Attributes:
        word: What the detector said last.
        travel: Which way the wheels were driven last: 1 forward, -1 backward.
        held: Whether a part has held, confirmed.
        late_m: For each word that was reported, how far its wheel was beyond the word's point.
    """

    robot: RobotSpec
    beyond_m: Callable[[str, int], float]
    word: str = ""
    travel: int = 0
    held: bool = False
    states: list[tuple[str, ...]] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    late_m: list[tuple[str, float]] = field(default_factory=list)

    def _holds(self, change: StateChange) -> bool:
        """Return whether a part is clamped in these states, confirmed."""
        configuration = self.robot.table.index_of(change.states)
        if configuration is None:
            return False
        doubted = {self.robot.regions.index(region) for region in change.unconfirmed}
        held = self.robot.held[configuration]
        return any(not doubted & self.robot.part_regions[part] for part in held)

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Note states, faults and words."""
        for effect in effects:
            if isinstance(effect, StateChange):
                self.states.append(effect.states)
                self.held |= self._holds(effect)
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
    """One run and what was true at its end.

    Attributes:
        exit_code: As of `pirate run`; 4 is an internal error.
        gone: Whether the robot has left the pipe.
        arcs_m: Where each wheel ended along the pipe.
        stopped: Whether the last setpoints that were sent had every wheel at zero.
        torques: What each bend joint bears, Nm.
        held_before: Whether a clamp was confirmed at any time, by the engine.
        held_at_end: Whether a part is clamped, by the engine.
        slid_m: How far a wheel is carried in two seconds, once the robot has settled after the end;
            NaN where that was not looked at.
        short_m: How far the wheel of the detector's last word is short of the place that the word
            means, by the truth; NaN where none was said, negative where the wheel is beyond it.
        late_m: Each word that was reported, and how far its wheel was beyond the word's point then,
            by the truth; negative: the word came too early.
        deepest_m: How deep a wheel or link was in a wall, at most; NaN if unknown.
        slip_m: How much farther its wheels have rolled than it has moved, a mean; NaN if unknown.
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
    held_before: bool
    held_at_end: bool
    torques: tuple[float, ...]
    slid_m: float
    short_m: float
    late_m: tuple[tuple[str, float], ...]
    deepest_m: float = nan
    slip_m: float = nan
    took_s: float = field(default=0.0, compare=False, repr=False)
    cpu_s: float = field(default=0.0, compare=False, repr=False)


def watched_run(order: Order, loaded: LoadedMission, *, slides: bool = True) -> Outcome:
    """Run the mission to its end and return what came of it.

    Args:
        order: What to run, on a backend that knows the truth.
        loaded: Its mission, loaded.
        slides: Whether to look how far a robot slides after a mission that has succeeded; after
            others that is always looked at.

    Raises:
        UsageError: The order does not fit.
        Exception: Whatever an internal error raises.
    """
    began = perf_counter()
    return finished(prepare(order, loaded), began, slides=slides)


def finished(
    prepared: Prepared,
    began: float,
    *,
    slides: bool = True,
    tap: Tap | None = None,
    begun: Callable[[MissionRun], None] = lambda run: None,
) -> Outcome:
    """Run a prepared mission to its end and return what came of it; see :func:`watched_run`."""
    if prepared.truth is None or prepared.places is None:
        raise UsageError(f"the backend {prepared.order.backend} does not know the robot's truth")
    truth = cast("Callable[[], FullTruth]", prepared.truth)
    engine = prepared.engine
    notes = RunNotes(
        engine.robot, lambda word, travel: -_short_m(prepared, word, travel, truth().arcs_m)
    )
    run = MissionRun(
        engine,
        prepared.backend,
        observers=[notes],
        companions=(*prepared.companions, FirstChoice()),
        tap=tap,
    )
    begun(run)
    with entered(prepared.companions):
        cpu_s = process_time()
        result = run.execute()
        cpu_s = process_time() - cpu_s
    took_s = perf_counter() - began
    if result.exit_code == ExitCode.BUG and result.error is not None:
        raise result.error
    state, real, ended = run.state, truth(), result.ended
    assert state is not None
    looked_at = slides or ended.outcome != "succeeded"
    return Outcome(
        prepared.order.seed,
        ended.outcome,
        ended.message,
        result.exit_code,
        result.now_s,
        real.distance_m,
        real.arcs_m,
        real.gone,
        all(state.robot.latest[slot] == 0 for slot in engine.robot.safe_zero),
        tuple(notes.states),
        tuple(notes.faults),
        notes.held,
        bool(engine.robot.held[state.robot.configuration]),
        real.torques_nm,
        _slid_m(prepared.backend, truth, result.now_s) if looked_at else nan,
        _short_m(prepared, notes.word, notes.travel, real.arcs_m),
        tuple(notes.late_m),
        _deepest_m(prepared.backend),
        _slip_m(prepared.backend, real),
        took_s,
        cpu_s,
    )


def _deepest_m(backend: object) -> float:
    """Return how deep a wheel or link was in a wall; only the kernel in space knows."""
    robot = getattr(backend, "robot", None)
    return float(getattr(getattr(robot, "physics", None), "deepest_m", nan))


def _slip_m(backend: object, truth: FullTruth) -> float:
    """Return how much farther the wheels have rolled than the robot has moved, either way."""
    robot = getattr(backend, "robot", None)
    if robot is None:
        return nan
    turned = [abs(each) for each in robot.values("wheel")]  # on opposite walls opposite ways
    return float(sum(turned)) / len(turned) * truth.wheel_radius_m - abs(truth.distance_m)


def _short_m(prepared: Prepared, name: str, travel: int, arcs_m: Sequence[float]) -> float:
    """Return how far short of a word's place, at the nearest bend, its wheel is."""
    words = {word.name: word for word in words_of(prepared.loaded.loaded_robot.profile)}
    word = words.get(name)
    if word is None or not travel:
        return nan
    point = word.forward if travel > 0 else word.backward
    assert prepared.places is not None  # as the caller has seen
    return min(
        (
            point.passed_m - travel * (arcs_m[point.wheel] - crossing)
            for crossing, _ in prepared.places.bends
        ),
        key=abs,
        default=nan,
    )


def _slid_m(backend: Backend, truth: Callable[[], FullTruth], now_s: float) -> float:
    """Return how far a wheel is carried when the last setpoints stay active for a while."""
    places = []
    for for_s in (_SETTLING_S, _WATCHED_S):
        now_s = _go_on(backend, now_s, now_s + for_s)
        places.append(truth().arcs_m)
    before, after = places
    return max(abs(new - old) for old, new in zip(before, after, strict=True))


def _go_on(backend: Backend, now_s: float, end_s: float) -> float:
    """Let time pass after a run, and return the time then."""
    if backend.real_time:  # the link is closed; the emulated bay at its port continues
        port = cast("VirtualPort", vars(backend)["port"])
        port.wait(port.now() + end_s - now_s)
        return end_s
    while now_s < end_s:
        now_s, _ = backend.advance(end_s)
    return now_s


# --- verdicts ------------------------------------------------------------------------------------


GRIPPED_NM = 0.1
"""A part whose joints bear less than this does not hold."""

STAYS_M = 0.005
"""A robot that is carried farther in two seconds after its mission does not hold."""

SHORT_M = 0.015
"""So far a wheel may be short of the place that the detector's last word means."""

HUNG_S = 3600.0
"""A run that takes longer does not end by itself."""

FALSE = "said to have succeeded"

What: TypeAlias = Literal["passed", "failed", "false", "bug"]


class RunVerdict(NamedTuple):
    """How a run ended, by the truth.

    Attributes:
        what: ``passed``; ``failed``: the mission says so; ``false``: the mission says it has
            succeeded and the robot has not; ``bug``: this program raised an exception.
        why: Why it did not pass; empty if it did.
        held: Whether it passed, or failed with the robot held in the pipe.
        unsafe: The rules of safety that it broke; empty for none.
    """

    what: What
    why: str
    held: bool
    unsafe: str


def judge(outcome: Outcome, end: TrueEnd) -> RunVerdict:
    """Return how a run ended, by what is true of the robot.

    Args:
        outcome: The run.
        end: What must be true when its mission has succeeded.
    """
    unsafe = ", ".join(_broken(outcome))
    if outcome.outcome != "succeeded":
        held = holds(outcome)
        return RunVerdict("failed", outcome.message, held, unsafe)
    contradiction = _contradiction(outcome, end)
    if contradiction:
        return RunVerdict("false", f"{FALSE}, {contradiction}", False, unsafe)
    return RunVerdict("passed", "", True, unsafe)


def holds(outcome: Outcome) -> bool:
    """Return whether the robot is in the pipe, with a clamp that bears."""
    gripped = _torque_nm(outcome) >= GRIPPED_NM
    stays = outcome.slid_m <= STAYS_M and not outcome.gone
    return outcome.held_at_end and gripped and outcome.stopped and stays


def _torque_nm(outcome: Outcome) -> float:
    return max(map(abs, outcome.torques), default=0.0)


def _contradiction(outcome: Outcome, end: TrueEnd) -> str:
    """Return what is true and contradicts a success; empty if nothing does."""
    arcs_m = outcome.arcs_m
    if outcome.gone:
        return "and the robot has left the pipe"
    if end.beyond is not None and (short := sum(arc <= end.beyond for arc in arcs_m)):
        return f"with {short} wheels not beyond {end.beyond * 1000:g} mm"
    if end.before is not None and (far := sum(arc >= end.before for arc in arcs_m)):
        return f"with {far} wheels not before {end.before * 1000:g} mm"
    if list(arcs_m) != sorted(arcs_m, reverse=True):
        return "with a part folded back on itself"
    if end.at_word and not outcome.short_m <= SHORT_M:
        return f"with a wheel {outcome.short_m * 1000:.0f} mm short of where the last word says"
    missing = _missing(outcome.states, end.states)
    return f"and {missing} of its states did not appear in order" if missing else ""


def _missing(states: Iterable[tuple[str, ...]], wanted: Sequence[tuple[str, ...]]) -> int:
    """Return how many states are left when those of a run have been walked through once."""
    left = list(wanted)
    for state in states:
        if left and state == left[0]:
            left.pop(0)
    return len(left)


def _broken(outcome: Outcome) -> Iterable[str]:
    """Yield the rules of safety that a run broke."""
    if outcome.time_s > HUNG_S:
        yield "did not end by itself"
    if not outcome.stopped:
        yield "wheels not stopped"
    if outcome.gone:
        yield "left the pipe"
    elif outcome.held_before and not outcome.held_at_end:
        yield "let go: no part is held at the end"
    elif outcome.held_before and _torque_nm(outcome) < GRIPPED_NM:
        yield "let go: no joint bears a torque at the end"
