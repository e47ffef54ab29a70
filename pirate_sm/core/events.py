"""What can happen to a run: events, faults, words of detectors; where it is."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.events import (
    ALPHABET_VERSION,
    READABLE_ALPHABETS,
    Abort,
    Answer,
    Breakpoints,
    CommandFailed,
    DetectorWord,
    EnvironmentReport,
    Event,
    FaultReport,
    FrameBlock,
    GoTo,
    Observation,
    OperatorCommand,
    OutsideNumber,
    Pause,
    Request,
    Resume,
    SensorFrame,
    SignalReport,
    Skip,
    Step,
    SubmitResult,
    SubmitStatus,
    Tick,
)
from pirate_sm.core._model.faults import BUILT_IN_FAULTS, BuiltInFault
from pirate_sm.core._model.whereabouts import (
    InSpace,
    Look,
    SeenMark,
    Sighting,
    Stood,
    Trail,
    Truth,
    Whereabouts,
    WordWatch,
)
