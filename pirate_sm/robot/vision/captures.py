"""Pictures one after the other: from a camera of this computer, the network, a video or files."""

from __future__ import annotations

from glob import glob
from pathlib import Path
from typing import Any, Protocol

from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import asks_elsewhere, is_file
from pirate_sm.robot import camera as kinds
from pirate_sm.robot.vision.opencv import Frame, cv2

_OPEN_MS, _READ_MS = 4000, 2000
"""How long a camera in the network is waited for; OpenCV's own limits are 30 s."""


class Capture(Protocol):
    """An opened source of pictures."""

    def read(self) -> Frame | None:
        """Return the next picture, waiting for it; None if there is none any more.

        Raises:
            UsageError: The next file is no picture, or has another size than the camera's file
                says.
        """

    def close(self) -> None:
        """Give the camera or the file back."""


class VideoCapture:
    """A camera or a video, read by OpenCV.

    Raises:
        UsageError: It cannot be opened.
    """

    def __init__(
        self, source: kinds.DeviceSource | kinds.FileSource | kinds.UrlSource, folder: Path
    ) -> None:
        match source:
            case kinds.DeviceSource():
                what = f"the camera /dev/video{source.device}"
                self._video = _device(source)
            case kinds.FileSource():
                what = f"the video '{source.file}'"
                if not is_file(folder / source.file):
                    raise UsageError(f"{what} does not exist, or is not a regular file")
                self._video = cv2.VideoCapture(str(folder / source.file))
            case kinds.UrlSource():
                what = f"the camera at {source.url}"
                limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _OPEN_MS]
                limits += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, _READ_MS]
                self._video = cv2.VideoCapture(source.url, cv2.CAP_FFMPEG, limits)
        if not self._video.isOpened():
            raise UsageError(f"{what} cannot be opened: is it there, and may you read it?")

    def read(self) -> Frame | None:
        """Return the next picture; None at the end, or when the camera is gone."""
        good, frame = self._video.read()
        return frame if good else None

    def close(self) -> None:
        """Give the camera or the file back."""
        self._video.release()


class ImageCapture:
    """Pictures in files, in the order of their names.

    Raises:
        UsageError: There are none.
    """

    def __init__(self, source: kinds.ImagesSource, folder: Path) -> None:
        # Path.glob takes no absolute pattern.
        self.names = sorted(glob(source.images, root_dir=folder))  # noqa: PTH207
        if not self.names:
            raise UsageError(f"there are no pictures '{source.images}' in {folder}")
        self._left = iter(self.names)
        self._folder = folder
        self._size = source.size

    def read(self) -> Frame | None:
        """Return the next picture; None behind the last.

        Raises:
            UsageError: The next file is no picture, or has another size than the camera's file
                says.
        """
        name = next(self._left, None)
        if name is None:
            return None
        path = self._folder / name
        frame: Frame | None = cv2.imread(str(path)) if is_file(path) else None
        if frame is None:
            raise UsageError(f"'{name}' is not a picture that can be read")
        _check_size(frame, self._size, f"'{name}' has")
        return frame

    def close(self) -> None:
        """Do nothing: each file is closed at once."""


def open_capture(source: kinds.CameraSource, folder: Path) -> Capture:
    """Return the opened source of a camera's file.

    Args:
        source: The source.
        folder: The folder of the camera's file, to which its paths refer.

    Raises:
        UsageError: It cannot be opened, or it is drawn by the simulator.
    """
    asks_elsewhere()  # OpenCV opens files itself
    match source:
        case kinds.DeviceSource() | kinds.FileSource() | kinds.UrlSource():
            return VideoCapture(source, folder)
        case kinds.ImagesSource():
            return ImageCapture(source, folder)
        case kinds.SyntheticSource():
            raise UsageError("a synthetic camera has pictures of a simulated robot only")


def first_frame(capture: Capture, source: kinds.CameraSource) -> Frame:
    """Return the first picture of a source, which must have the size in the camera's file.

    Raises:
        UsageError: There is none, or its size differs: the lens would not be valid.
    """
    frame = capture.read()
    if frame is None:
        raise UsageError("the camera gives no picture")
    _check_size(frame, source.size, "the pictures have")
    return frame


def _check_size(frame: Frame, size: kinds.FrameSize, what: str) -> None:
    """Raise UsageError for a picture of another size, for which the lens is not valid."""
    height, width = frame.shape[:2]
    if (width, height) != size:
        wanted = "{} × {}".format(*size)
        raise UsageError(f"{what} {width} × {height} pixels, the camera's file {wanted}")


def _device(source: kinds.DeviceSource) -> Any:
    width, height = source.size
    settings = [
        (cv2.CAP_PROP_FOURCC, cv2.VideoWriter_fourcc(*source.codec)),
        (cv2.CAP_PROP_FRAME_WIDTH, width),
        (cv2.CAP_PROP_FRAME_HEIGHT, height),
        (cv2.CAP_PROP_FPS, source.rate),
        (cv2.CAP_PROP_BUFFERSIZE, 1),  # older pictures are of no use
    ]
    video = cv2.VideoCapture(source.device, cv2.CAP_V4L2)
    for key, value in settings:
        video.set(key, value)
    return video
