"""A recorded video of a run gives the words that the live source gave."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from late import late

import pirate_sm
from pirate_sm.robot.vision import sightings
from pirate_sm.robot.vision.opencv import cv2

av = late("av")

SMALL = Path(__file__).resolve().parents[1] / "cameras" / "small.yaml"
RATE_HZ = 5
Frames = Sequence[np.ndarray[Any, Any]]


def words(run: pirate_sm.Run) -> list[tuple[str, float]]:
    """Return each word with the time at which it was reported first."""
    first: dict[str, float] = {}
    said = run.table("detector")
    for at_s, word in zip(said["time_s"], said["word"], strict=True):
        if word:
            first.setdefault(word, at_s)
    return list(first.items())


@pytest.fixture(scope="module")
def watched() -> tuple[pirate_sm.Run, Frames]:
    """Return a run that a synthetic camera has watched, and all its pictures."""
    frames: list[np.ndarray[Any, Any]] = []
    patch = pytest.MonkeyPatch()
    see = sightings.Gaze.see

    def keep(gaze: Any, frame: Any, captured_s: float) -> Any:
        frames.append(frame)
        return see(gaze, frame, captured_s)

    patch.setattr(sightings.Gaze, "see", keep)
    run = pirate_sm.run("mitre_bend", detector=f"vision:{SMALL}", seed=4)
    patch.undo()
    return run, frames


def as_mjpg(path: Path, frames: Frames) -> None:
    height, width, _ = frames[0].shape
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), RATE_HZ, (width, height))
    for frame in frames:
        video.write(frame)
    video.release()


def as_h264(path: Path, frames: Frames) -> None:
    height, width, _ = frames[0].shape
    with av.open(str(path), "w") as file:
        stream = file.add_stream("libx264", rate=RATE_HZ, options={"crf": "20"})
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for frame in frames:
            file.mux(stream.encode(av.VideoFrame.from_ndarray(frame, format="bgr24")))
        file.mux(stream.encode())


@pytest.mark.thorough  # it draws and searches the pictures of a whole bend twice
@pytest.mark.parametrize(
    ("name", "encode"),
    [
        pytest.param("seen.avi", as_mjpg, id="mjpg"),
        pytest.param("seen.mp4", as_h264, id="h264"),
    ],
)
def test_a_video_gives_the_same_words(
    watched: tuple[pirate_sm.Run, Frames],
    tmp_path: Path,
    name: str,
    encode: Callable[[Path, Frames], None],
) -> None:
    live, frames = watched
    encode(tmp_path / name, [*frames, *frames[-1:] * (3 * RATE_HZ)])
    text = SMALL.read_text("utf-8")
    file = text.replace("source: {synthetic: {}, ", f"source: {{file: {name}, ")
    assert file != text
    (tmp_path / "small.yaml").write_text(file, "utf-8")

    again = pirate_sm.run("mitre_bend", detector=f"vision:{tmp_path / 'small.yaml'}", seed=4)

    assert again.outcome == live.outcome == "succeeded", again.message
    assert [word for word, _ in words(again)] == [word for word, _ in words(live)]
    for (_, one_s), (_, other_s) in zip(words(again), words(live), strict=True):
        assert one_s == pytest.approx(other_s, abs=1 / RATE_HZ)
