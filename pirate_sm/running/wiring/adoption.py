"""Take over a robot that is not where its mission begins, in the states that its sensors show.

Before that, and before a mission continues, every board is read for a while; only a stop is
written.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import NamedTuple

from pirate_sm.checking.gate import pass_or_raise
from pirate_sm.core.engine import Engine
from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.core.events import Event, FaultReport, SensorFrame, SubmitResult
from pirate_sm.core.generated_missions import BY_HAND
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.resuming import Reconciled, VerdictTable, adoptable, reconcile, unknowns
from pirate_sm.core.robot import known_values
from pirate_sm.robot.backends.protocol import Backend
from pirate_sm.robot.detectors.registry import speaks_of_bends
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.wiring.prepared import Prepared
from pirate_sm.running.wiring.resumed_run import COUNTING

# --- the look -------------------------------------------------------------------------------------


LOOK_S = 1.0
"""How long the boards are read: a clamp must have been seen for half a second [D]."""


class FirstLook(NamedTuple):
    """What the boards have reported.

    Attributes:
        began_s: When the look began, by the backend's mission time; ``now_s`` is its end.
        frames: The frames of the boards, with their times, s.
        faults: What was wrong with the link and the boards.
    """

    began_s: float
    now_s: float
    frames: tuple[tuple[float, SensorFrame], ...]
    faults: tuple[FaultReport, ...]

    @property
    def newest(self) -> tuple[SensorFrame, ...]:
        """The last frame of each board."""
        return tuple({frame.board: frame for _, frame in self.frames}.values())


def look(
    backend: Backend,
    first: Sequence[Event] = (),
    began_s: float = 0.0,
    check: Callable[[], None] = lambda: None,
    for_s: float = LOOK_S,
) -> FirstLook:
    """Read the boards for a while; nothing is written.

    Args:
        backend: The backend, opened.
        first: Its first events.
        began_s: Its mission time.
        check: Is called at every turn; may raise, to end the look.
        for_s: How long the boards are read.

    Raises:
        BackendError: The backend has failed.
    """
    now_s, events = began_s, first
    frames: list[tuple[float, SensorFrame]] = []
    faults: list[FaultReport] = []
    while True:
        for event in events:
            if isinstance(event, SensorFrame):
                frames.append((now_s, event))
            elif isinstance(event, FaultReport):
                faults.append(event)
        if now_s >= began_s + for_s:
            return FirstLook(began_s, now_s, tuple(frames), tuple(dict.fromkeys(faults)))
        check()
        now_s, events = backend.advance(began_s + for_s)


# --- adoption -------------------------------------------------------------------------------------


_HELD_WITHIN_S = 2.0
"""Longer than an array takes on a bad line."""


class Stands(NamedTuple):
    """The pose of a robot whose mission has not begun.

    Attributes:
        look: What its boards have reported.
        shows: What that says of every configuration, the declared one first.
        instead: The configurations that it may be adopted in; empty if it may be as declared.
    """

    look: FirstLook
    shows: Reconciled
    instead: tuple[VerdictTable, ...]

    @property
    def as_declared(self) -> Resuming:
        """With what the mission begins where it is declared to."""
        return Resuming(None, self.look.now_s, (*self.look.newest, *self.look.faults))


def look_at(prepared: Prepared, check: Callable[[], None], before: Stands | None = None) -> Stands:
    """Look at the robot, and open the backend first unless that was done; write nothing.

    Args:
        prepared: The run.
        check: Is called at every turn; may raise.
        before: An earlier look.

    Raises:
        BackendError: The robot cannot be reached.
    """
    backend, loaded = prepared.backend, prepared.loaded
    first = () if before else backend.open()
    seen = look(backend, first, before.look.now_s if before else 0.0, check)
    known, _ = prepared.engine.start()
    found = adoptable(loaded.robot, loaded.program.start_configuration)
    shows = reconcile(
        *(loaded.robot, loaded.program, known, seen.frames, seen.now_s, 0.0), found=found
    )
    return Stands(seen, shows, shows.shown_instead(loaded.robot))


def adopt(prepared: Prepared, stands: Stands, table: VerdictTable) -> tuple[Prepared, Resuming]:
    """Hold the robot as the sensors show it; return the run that begins there.

    The array that is sent stops all wheels and gives held parts the duties of their states.
    Everything stays unconfirmed until the sensors show it with that array active.

    Raises:
        BackendError: The robot has not confirmed the array.
        CheckError: The mission is refused if it begins there.
    """
    order, loaded, body = prepared.order, begun_there(prepared, table), table.hypothesis.body
    names = loaded.robot.table.configurations[body.configuration]
    values = known_values(body.values, stands.shows.numbers, loaded.robot)
    prepared.backend.submit(body.next_id, values)
    now_s, limit_s = stands.look.now_s, stands.look.now_s + _HELD_WITHIN_S
    held = False
    while not held:
        if now_s >= limit_s:
            raise BackendError("the robot has not confirmed the array that holds it")
        now_s, events = prepared.backend.advance(limit_s)
        held = SubmitResult(body.next_id, "accepted", "") in events
    adopted = replace(
        prepared,
        loaded=loaded,
        order=replace(order, states=dict(zip(loaded.robot.regions, names, strict=True))),
        engine=Engine(loaded.robot, loaded.program, nominal=False),
    )
    body = body._replace(values=values, next_id=body.next_id + 1, sent=True)
    return adopted, Resuming(None, now_s, (*stands.look.newest, *stands.look.faults), body)


def begun_there(prepared: Prepared, table: VerdictTable) -> LoadedMission:
    """Return the mission with its beginning where the robot is taken to be.

    Raises:
        CheckError: It is refused if it begins there.
    """
    order, loaded = prepared.order, prepared.loaded
    there = table.hypothesis.body.configuration
    loaded = replace(loaded, program=replace(loaded.program, start_configuration=there))
    if order.check and loaded.mission.mission != BY_HAND:
        pass_or_raise(loaded, words_of_bends=speaks_of_bends(order.detector), backend=order.backend)
    return loaded


def doubts(prepared: Prepared, stands: Stands) -> Iterator[str]:
    """Yield what must be settled before the robot is adopted without asking."""
    first, *others = stands.instead
    if others:
        yield "the sensors cannot tell apart where it stands: say it with --state (states=)"
    yield from unknowns(prepared.loaded.robot, prepared.loaded.program, first)
    if unplaced(prepared):
        counts = f"where the detector {prepared.detector} counts from"
        yield f"{counts}: say it with --start-at (start_at_m=)"


def unplaced(prepared: Prepared) -> bool:
    """Return whether the detector counts from a place that nobody has said."""
    by_hand = prepared.loaded.mission.mission == BY_HAND
    return prepared.detector in COUNTING and prepared.order.start_at_m is None and not by_hand


def adopt_alone(prepared: Prepared, stack: ExitStack) -> tuple[Prepared, Resuming]:
    """Adopt the robot as its sensors show it, and ask nobody; as declared if that is not wrong.

    Args:
        prepared: The run.
        stack: Closes the backend at its end.

    Raises:
        BackendError: The robot cannot be reached, or has not confirmed that it holds.
        CheckError: The mission is refused if it begins where the robot is.
        UsageError: What the sensors do not show must be said.
    """
    stack.callback(prepared.backend.close)
    stands = look_at(prepared, lambda: None)
    if not stands.instead:
        return prepared, stands.as_declared
    if found := tuple(doubts(prepared, stands)):
        raise UsageError(f"the robot cannot be adopted: {'; '.join(found)}")
    return adopt(prepared, stands, stands.instead[0])
