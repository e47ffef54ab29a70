"""Replays a long recording in several processes.

Each process replays the stretch between two checkpoints and compares the engine's state at its end
with the checkpoint there, from which the next stretch begins. If every stretch is the same, so is
the whole run.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from math import inf
from pathlib import Path
from typing import NamedTuple

from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.read.pieces import Checkpoint
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import Replayed, replay

_EACH = 16
"""Stretches per process: several, for progress and so that the processes end together."""


class _Stretch(NamedTuple):
    """The part between two checkpoints; None stands for the start and the end."""

    after: Checkpoint | None
    until: Checkpoint | None


def replay_shared(
    recording: Recording, processes: int, *, after: Checkpoint | None = None, until_s: float = inf
) -> Replayed:
    """Replay the recording as :func:`replay` does, in several processes.

    Args:
        recording: The recording.
        processes: Number of processes.
        after: The checkpoint to begin with; None: the start.
        until_s: Steps after this time are not replayed.

    Raises:
        RecordingError: The recording is damaged.
    """
    stretches = list(_stretches(recording, processes * _EACH, after, until_s))
    found: list[Replayed] = []
    with multiprocessing.get_context("spawn").Pool(processes, _heed_no_keys) as pool:
        for result in pool.imap(partial(_replay, recording.path, until_s), stretches):
            found.append(result)
            recording.watch(len(found) / len(stretches))
            if result.difference is not None:
                break
    return _together(found)


def _stretches(
    recording: Recording, most: int, after: Checkpoint | None, until_s: float
) -> Iterator[_Stretch]:
    """Yield about ``most`` consecutive stretches of similar length."""
    from_s = after.at_s if after is not None else 0.0
    each_s = (min(until_s, recording.until_s) - from_s) / most
    for checkpoint in recording.checkpoints(after):
        if checkpoint.at_s >= until_s:
            break
        if checkpoint.at_s >= from_s + each_s:
            yield _Stretch(after, checkpoint)
            after, from_s = checkpoint, checkpoint.at_s
    yield _Stretch(after, None)


def _together(found: list[Replayed]) -> Replayed:
    """Return the results of the stretches as one, up to the first difference."""
    return replace(
        found[-1],
        steps=sum(each.steps for each in found),
        effects=sum(each.effects for each in found),
        executed=any(each.executed for each in found),
        from_s=found[0].from_s,
    )


def _replay(path: Path, until_s: float, stretch: _Stretch) -> Replayed:
    """Replay one stretch, in a process of its own."""
    recording, loaded = _loaded(path)
    return replay(recording, loaded, after=stretch.after, until=stretch.until, until_s=until_s)


@cache
def _loaded(path: Path) -> tuple[Recording, LoadedMission]:
    """Return the recording and its mission, loaded once in each process."""
    recording = read_recording(path)
    with recorded_mission(recording.header) as loaded:
        return recording, loaded


def _heed_no_keys() -> None:
    """Ignore Ctrl-C, which ends the main process and with it this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
