"""What frames in a recording cost as columns of JSON, and what they would as binary columns.

    python -m benchmarks.binary_frames [--minutes 10]

The frames of a recording are written and read again in both ways. Printed are the user's processor
time of each, as a share of all that a recording adds to a run as fast as it goes and of all that
its report takes, and the sizes, compressed as in the file.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from math import inf
from pathlib import Path
from statistics import median

import numpy as np
import numpy.typing as npt
from zstandard import ZstdCompressor

from benchmarks.recording import run_once, user_time_s
from pirate_sm.core.events import SensorFrame
from pirate_sm.running.recording.format.engine_topics import Topic, Topics
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.views.report.recording_report import report_of

RUNS = 3

Table = npt.NDArray[np.float64]


def spent_s(work: Callable[[], object]) -> float:
    """The user's processor time of the work, the least of a few times."""
    times = []
    for _ in range(RUNS):
        began_s = user_time_s()
        work()
        times.append(user_time_s() - began_s)
    return min(times)


def frames_of(recording: Recording) -> list[tuple[Topic, bytes]]:
    """The batches of frames in a recording."""
    layout = recording.header.layout
    boards = [Topics(layout).of_frames(board) for board, names in layout.boards.items() if names]
    topics = {topic.name: topic for topic in boards}
    return [(topics[it.topic], it.data) for it in recording.messages(*topics)]


def table_of(topic: Topic, data: bytes) -> Table:
    """The columns of a batch: step, time, channels."""
    batch = json.loads(data)
    channels = batch[topic.fields[topic.spread][0]]
    return np.array([batch["step"], batch["t_s"], *channels.values()], np.float64)


def written(topic: Topic, table: Table) -> bytes:
    """The batch as the recorder writes it."""
    steps, times_s, *channels = table.tolist()
    return topic.encode_frames(list(map(int, steps)), times_s, channels)


def read(topic: Topic, data: bytes) -> list[tuple[int, float, int, SensorFrame]]:
    """The rows of a batch as the reader makes them, from binary columns."""
    steps, times_s, *channels = np.frombuffer(data).reshape(len(topic.names) + 2, -1).tolist()
    board = topic.board or 0
    frames = [SensorFrame(board, values) for values in zip(*channels, strict=True)]
    return list(zip(map(int, steps), times_s, [0] * len(frames), frames, strict=True))


def compressed(made: list[bytes]) -> list[bytes]:
    """The batches compressed."""
    return list(map(ZstdCompressor().compress, made))


def measure(minutes: float) -> None:
    """Print what both cost."""
    with tempfile.TemporaryDirectory() as name:
        path, until_s = Path(name) / "run.mcap", minutes * 60
        run_once(None, inf, until_s)
        pairs = []
        for _ in range(RUNS):
            path.unlink(missing_ok=True)
            pairs.append([run_once(file, inf, until_s).user_s for file in (None, path)])
        plain_s, kept_s = map(median, zip(*pairs, strict=True))
        added_s = kept_s - plain_s
        recording = read_recording(path)
        reported_s = spent_s(lambda: report_of(recording))
        batches = frames_of(recording)
    tables = [table_of(topic, data) for topic, data in batches]
    packed, topics = [table.tobytes() for table in tables], [topic for topic, _ in batches]
    print(
        f"    {minutes:g} min run in {plain_s:.2f} s; a recording adds {added_s:.2f} s, "
        f"{added_s / plain_s:+.0%}, its report takes {reported_s:.2f} s"
    )
    for kind, write, take, made in (
        (
            "JSON",
            lambda: [written(*each) for each in zip(topics, tables, strict=True)],
            lambda: [list(topic.decode(data)) for topic, data in batches],
            [data for _, data in batches],
        ),
        (
            "binary",
            lambda: [table.tobytes() for table in tables],
            lambda: [read(*each) for each in zip(topics, packed, strict=True)],
            packed,
        ),
    ):
        size = sum(map(len, compressed(made)))
        pressed_s, write_s, read_s = map(spent_s, (partial(compressed, made), write, take))
        print(
            f"    {kind:7} written in {write_s:.3f} s ({write_s / added_s:.0%}), compressed in "
            f"{pressed_s:.3f} s to {size / 1e6:.2f} MB, read in {read_s:.3f} s "
            f"({read_s / reported_s:.0%})"
        )


def main() -> int:
    """Print what was measured."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=10.0, help="of the recording")
    measure(parser.parse_args().minutes)
    return 0


if __name__ == "__main__":
    sys.exit(main())
