"""What a backend or a detector of another package needs (``docs/extending.md``)."""

from __future__ import annotations

from pirate_sm.core.companion import Companion
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import DetectorWord, Event, FaultReport, SensorFrame, SubmitResult
from pirate_sm.core.registry import Plugin
from pirate_sm.robot.backends.protocol import Backend, Completion
from pirate_sm.robot.detectors.registry import Asked, Detecting, MakeDetector, Places
from pirate_sm.running.runtime.scripted_events import TriggerScript
from pirate_sm.running.wiring import Order
from pirate_sm.running.wiring.prepared import Equipment, MakeBackend, Say

__all__ = [
    "Asked",
    "Backend",
    "Companion",
    "Completion",
    "Detecting",
    "DetectorWord",
    "Effect",
    "EngineState",
    "Equipment",
    "Event",
    "FaultReport",
    "MakeBackend",
    "MakeDetector",
    "Order",
    "Places",
    "Plugin",
    "Say",
    "SensorFrame",
    "SubmitResult",
    "TriggerScript",
]
