"""Snapshots of a run that goes on, and trends of the signals that are followed."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from pirate_sm.core.engine import EngineState
from pirate_sm.running.wiring import Prepared
from pirate_sm.views.showing.robot_anatomy import anatomy_of
from pirate_sm.views.showing.run_history import RunStory
from pirate_sm.views.showing.snapshot import MissionScene, Snapshot

TREND_EVERY_S = 0.5
TREND_LENGTH = 120


def sent_name(slot: int) -> str:
    """Return under what name the setpoints of a slot are; no signal has such a name."""
    return f"setpoint {slot}"


class Trends:
    """The last values of the signals that a robot's anatomy follows, and of its motors' setpoints.

    Attributes:
        latest: They, oldest first, NaN where unknown; replaced, never changed.
    """

    def __init__(self) -> None:
        self._due_s = -inf
        self.latest: Mapping[str, tuple[float, ...]] = {}

    def look(self, scene: MissionScene, state: EngineState, now_s: float) -> None:
        """Note another value of each, when it is time."""
        if now_s < self._due_s:
            return
        self._due_s = now_s + TREND_EVERY_S
        signals = dict(scene.engine.signals(state))
        signals |= {sent_name(slot): sent for slot, sent in enumerate(state.robot.latest)}
        self.latest = {
            name: (*self.latest.get(name, ()), value)[-TREND_LENGTH:]
            for name in (*scene.anatomy.followed, *map(sent_name, scene.anatomy.slots))
            if (value := signals.get(name)) is not None
        }


def scene_of(prepared: Prepared) -> MissionScene:
    """Return what stays the same in a run."""
    loaded = prepared.loaded
    anatomy = anatomy_of(loaded.loaded_robot.profile, loaded.robot)
    return MissionScene(loaded, prepared.engine, anatomy, prepared.order.backend)


def snapshot_of(
    scene: MissionScene,
    prepared: Prepared,
    state: EngineState | None,
    now_s: float,
    story: RunStory,
    trends: Trends,
    *,
    over: bool = False,
    before_m: float = 0.0,
) -> Snapshot:
    """Return this moment of a run, with what its backend knows of place and link."""
    truth, reckoned = None, False
    if prepared.truth is not None:
        truth = prepared.truth()
    elif prepared.reckoned is not None:
        truth, reckoned = prepared.reckoned(), True
    link = prepared.link() if prepared.link and state is not None else None
    return Snapshot(
        scene, now_s, state, story, truth, reckoned, link, trends.latest, over, before_m
    )
