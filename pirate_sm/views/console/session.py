"""Runs missions one after the other on one open backend, in a separate thread."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from threading import Thread

from pirate_sm.core.companion import entered
from pirate_sm.core.effects import Ended
from pirate_sm.core.events import Event, GoTo
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.runtime.ending import BUG, Result, Stop
from pirate_sm.running.runtime.loop import Clock, MissionRun, WallClock
from pirate_sm.running.runtime.pump import Resuming
from pirate_sm.running.runtime.scripted_events import FirstChoice, LoopWatch
from pirate_sm.running.wiring import Prepared, again
from pirate_sm.running.wiring.run_recorder import Kept
from pirate_sm.views.console.command_series import RUN_OVER, Giver
from pirate_sm.views.console.hand_driving import HandDriving, SaidPlace
from pirate_sm.views.console.quitting import Quitting
from pirate_sm.views.console.run_bridge import RunBridge
from pirate_sm.views.showing.live_snapshots import scene_of
from pirate_sm.views.showing.snapshot import Snapshot

BY_OPERATOR = Stop("stopped by the operator", 0)
CHANGED = Stop("another mission was chosen", 0)
LEFT = Stop("the console was left", 0)

_SHORT_S = 1.0
_MOST_SHORT = 3
"""After this many consecutive runs that a fault ended at once, the session ends."""


Keep = Callable[[Prepared], AbstractContextManager[Kept]]


def unkept(prepared: Prepared) -> AbstractContextManager[Kept]:
    """Return the run without a recording."""
    return nullcontext(Kept(prepared))


class OperatorSession:
    """The operations of the console. None of them blocks, except :meth:`join`.

    Args:
        prepared: The first mission, its engine, and the backend that stays open.
        factor: Mission seconds per second of the wall clock.
        clock: The wall clock.
        keep: Records each run.
        resuming: With what the first mission goes on whose run was cut off; its backend is open.
        then: The mission of the second run; by default the first one again.

    Attributes:
        quitting: Requests to end the session.
        giver: Gives a series of commands that the operator has confirmed.
        driving: Stops what is driven by hand.
        result: How the last run ended; None before.
    """

    def __init__(
        self,
        prepared: Prepared,
        *,
        factor: float = 1.0,
        clock: Clock | None = None,
        keep: Keep = unkept,
        resuming: Resuming | None = None,
        then: LoadedMission | None = None,
    ) -> None:
        self.quitting = Quitting(lambda: bool(self.latest.link and self.latest.link.trouble))
        self.giver = Giver()
        self.result: Result | None = None
        self.prepared = prepared
        self._factor = factor
        self._clock = clock
        self._keep = keep
        self._resuming = resuming
        self._next = (then, False) if then is not None else None
        self._short = 0
        self._thread = Thread(target=self._work, name="run", daemon=True)
        self._bridge = RunBridge(scene_of(prepared), prepared, clock or WallClock())
        self.driving = HandDriving(lambda: self._bridge.latest, factor)
        if (place_m := prepared.order.start_at_m) is not None:
            self.driving.place = SaidPlace(place_m, 0.0)

    @property
    def latest(self) -> Snapshot:
        """The newest snapshot."""
        return self._bridge.latest

    def start(self) -> None:
        """Open the backend and begin the mission, paused."""
        self._thread.start()

    def join(self, within_s: float | None = None) -> bool:
        """Wait at most this long; return whether the robot is safe and the backend closed."""
        if self._thread.ident is not None:
            self._thread.join(within_s)
        return not self._thread.is_alive()

    def give_event(self, event: Event) -> None:
        """Give the engine the event soon; end a series of commands."""
        self.giver.stop()
        self._bridge.queue(event)

    def give(self, commands: Sequence[str], then: GoTo) -> None:
        """Give the commands one after the other, each when the last is done; then hand back.

        The series ends with a request to stop the run, and does not continue in the next run.
        """
        if self.quitting.run.stop is None:
            self.giver.give(commands, then)

    def stop(self) -> None:
        """Bring the robot to its safe state now; its mission can be handed back afterwards."""
        self.quitting.run.ask(BY_OPERATOR)

    def change(self, loaded: LoadedMission) -> None:
        """End the present mission in the safe state and begin the other one, paused.

        Raises:
            UsageError: The mission is for another robot.
        """
        again(self.prepared, loaded, other=True)
        self._next = loaded, True
        self.quitting.run.ask(CHANGED)

    def quit(self, stop: Stop = LEFT) -> None:
        """End the session, with the robot in its safe state."""
        self.quitting.ask(stop)

    # --- in its own thread --------------------------------------------------------------------

    def _work(self) -> None:
        try:
            with entered(self.prepared.companions):
                self._run_all()
        except Exception as error:
            message = f"an internal error: {type(error).__name__}: {error}"
            self.result = Result(Ended("fault", message), BUG, self.latest.now_s, error)
        finally:
            self.prepared.backend.close()
            self._bridge.end(self.latest.now_s)

    def _run_all(self) -> None:
        run: MissionRun | None = None
        while True:
            with self._keep(self.prepared) as kept:
                run = self._run(kept, run)
                series = self.giver.series
                self.result = run.execute()
                self.quitting.stopped = self.quitting.stop is not None
                asked = self._bridge.asked or self.giver.series is not series
                if not asked and self.result.ended.outcome == "interrupted":
                    kept.forget()
            stopped = self.quitting.stop is not None or not run.open
            if stopped or run.state is None or self._hopeless(self.result, run):
                return
            (loaded, other), self._next = self._next or (self.prepared.loaded, False), None
            self.prepared = again(self.prepared, loaded, other=other)

    def _run(self, kept: Kept, before: MissionRun | None) -> MissionRun:
        self.giver.stop(RUN_OVER)
        prepared = kept.prepared
        attended = [FirstChoice()] if prepared.attended else []
        # An operator may act where a trace alone would repeat itself.
        companions = [each for each in prepared.companions if not isinstance(each, LoopWatch)]
        people = self._bridge, self.driving, self.giver
        run = MissionRun(
            prepared.engine,
            prepared.backend,
            observers=[self._bridge],
            watchers=[self._bridge],
            companions=[*companions, *kept.companions, *attended, *people],
            tap=kept.tap,
            requests=self.quitting.begin(),
            clock=self._clock,
            factor=self._factor,
            after=before,
            resuming=self._resuming,
            paused=True,
            keep_open=True,
        )
        self._resuming = None
        self._began_s = run.now_s
        self._bridge.begin(scene_of(prepared), prepared, run)
        kept.follow(run)
        return run

    def _hopeless(self, result: Result, run: MissionRun) -> bool:
        """Return whether several runs have ended by a fault before any request of the operator."""
        short_s = _SHORT_S + self.prepared.loaded.robot.sight.within_s  # a start may be refused
        at_once = result.now_s < self._began_s + short_s and not self._bridge.asked
        self._short = self._short + 1 if at_once and result.ended.outcome == "fault" else 0
        return self._short >= _MOST_SHORT
