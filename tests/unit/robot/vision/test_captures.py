"""Pictures from files: what is opened, what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.camera import (
    CameraSource,
    DeviceSource,
    FileSource,
    ImagesSource,
    SyntheticSource,
    SyntheticView,
    UrlSource,
)
from pirate_sm.robot.vision.captures import Capture, first_frame, open_capture
from pirate_sm.robot.vision.opencv import cv2

SIZE = (64, 48)


def levels_of(capture: Capture) -> list[float]:
    levels = []
    while (seen := capture.read()) is not None:
        levels.append(float(seen.mean()))
    capture.close()
    return levels


def frame(level: int) -> np.ndarray:
    return np.full((48, 64, 3), level, np.uint8)


def test_pictures_come_in_the_order_of_their_names(tmp_path: Path) -> None:
    for number in (2, 0, 1):
        cv2.imwrite(str(tmp_path / f"{number}.png"), frame(10 * number))
    capture = open_capture(ImagesSource(images="*.png", size=SIZE), tmp_path)

    assert levels_of(capture) == [0, 10, 20]


@pytest.mark.parametrize(("name", "codec"), [("a.avi", "MJPG"), ("a.mp4", "mp4v")])
def test_a_video_is_read_to_its_end(tmp_path: Path, name: str, codec: str) -> None:
    written = cv2.VideoWriter(str(tmp_path / name), cv2.VideoWriter_fourcc(*codec), 30.0, SIZE)
    for level in (40, 80, 120):
        written.write(frame(level))
    written.release()
    capture = open_capture(FileSource(file=name, size=SIZE), tmp_path)

    assert levels_of(capture) == pytest.approx([40, 80, 120], abs=4)


@pytest.mark.parametrize(
    ("source", "said"),
    [
        (DeviceSource(device=987, size=SIZE), "the camera /dev/video987 cannot be opened"),
        (FileSource(file="none.avi", size=SIZE), "the video 'none.avi' does not exist"),
        (UrlSource(url="rtsp://127.0.0.1:9/x", size=SIZE), "the camera at rtsp://127.0.0.1:9/x"),
        (ImagesSource(images="*.png", size=SIZE), "there are no pictures '*.png'"),
        (SyntheticSource(synthetic=SyntheticView(), size=SIZE), "of a simulated robot only"),
    ],
    ids=["device", "file", "url", "images", "synthetic"],
)
def test_what_cannot_be_opened_is_refused_in_one_line(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], source: CameraSource, said: str
) -> None:
    with pytest.raises(UsageError) as refused:
        open_capture(source, tmp_path)

    assert said in str(refused.value)
    assert capfd.readouterr() == ("", "")


def test_pictures_of_another_size_are_refused(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), frame(0))
    source = ImagesSource(images="a.png", size=(128, 96))

    with pytest.raises(UsageError, match="64 × 48 pixels, the camera's file 128 × 96"):
        first_frame(open_capture(source, tmp_path), source)


def test_a_file_that_is_no_picture_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("no picture", encoding="utf-8")
    source = ImagesSource(images="a.png", size=SIZE)

    with pytest.raises(UsageError, match=r"'a\.png' is not a picture"):
        first_frame(open_capture(source, tmp_path), source)


def test_a_later_picture_of_another_size_is_refused_too(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), frame(0))
    cv2.imwrite(str(tmp_path / "b.png"), np.zeros((64, 48, 3), np.uint8))
    capture = open_capture(ImagesSource(images="*.png", size=SIZE), tmp_path)
    capture.read()

    with pytest.raises(UsageError, match=r"'b\.png' has 48 × 64 pixels, the camera's file 64 × 48"):
        capture.read()
