"""`pirate camera`: prints sheets, measures a lens and a pose, and shows what a camera sees."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from glob import glob
from math import degrees, inf
from pathlib import Path

from pirate_sm.cli.options.declaring import read_board
from pirate_sm.cli.options.devices import (
    CalibrateCameraOptions,
    LookOptions,
    PrintOptions,
    SurveyOptions,
)
from pirate_sm.cli.output.files import refuse_losses, write_and_name, write_bytes, write_file
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import Sighting
from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.core.visible import visible
from pirate_sm.robot.camera import (
    Camera,
    DeviceSource,
    ImagesSource,
    RobotTags,
    SyntheticSource,
    UrlSource,
)
from pirate_sm.robot.camera_file import lens_line, load_camera, pose_line, with_lens, with_pose
from pirate_sm.robot.vision.calibration import (
    KnownPlace,
    calibrate,
    known_points,
    known_tags,
    survey,
)
from pirate_sm.robot.vision.captures import Capture, ImageCapture, first_frame, open_capture
from pirate_sm.robot.vision.opencv import Floats, Frame, cv2
from pirate_sm.robot.vision.projection import LensModel
from pirate_sm.robot.vision.seeing import annotated, eye_of
from pirate_sm.robot.vision.synthetic import ShownScene, SyntheticPictures, scene_in_pipe
from pirate_sm.robot.vision.targets import (
    Chessboard,
    board_sheet,
    find_board,
    grayed,
    is_another,
    is_sharp,
    tag_sheets,
)

_WARM_UP = 15
"""Pictures after which a camera has found its exposure."""


def find_camera(name: str) -> tuple[Camera, Path]:
    """Return the camera of this name or path, and its file; its pose may still be wrong.

    Raises:
        LoadError: The file has faults.
        UsageError: There is none.
    """
    path = library.find_camera(name, Path.cwd())
    return load_camera(path, posed=False)[0], path


def refuse_shipped(path: Path) -> None:
    """Raise UsageError for a file that belongs to this package."""
    if path.resolve() in {each.resolve() for each in library.cameras()}:
        raise UsageError(
            f"'{path.stem}' is a shipped camera: copy {path} into cameras/ as your own, or add"
            " --no-write"
        )


@contextmanager
def opened(camera: Camera, path: Path, images: str | None) -> Iterator[tuple[Capture, Frame]]:
    """Yield the opened pictures of a camera, or those in files, and the first of them.

    Raises:
        UsageError: They cannot be opened, or have another size than the camera's file says.
    """
    source, folder = camera.source, path.parent
    if images is not None:
        source, folder = ImagesSource(images=images, size=source.size), Path.cwd()
    capture = open_capture(source, folder)
    try:
        frame = first_frame(capture, source)
        if isinstance(source, DeviceSource):
            for _ in range(_WARM_UP):
                read = capture.read()
                frame = frame if read is None else read
        yield capture, frame
    finally:
        capture.close()


def one_picture(
    camera: Camera, path: Path, images: str | None, robot: str | None, pipe: str
) -> Frame:
    """Return a picture; a synthetic camera sees the robot at its start in a pipe.

    Raises:
        LoadError: The robot or the pipe has faults.
        UsageError: There is no picture.
    """
    if isinstance(camera.source, SyntheticSource) and images is None:
        pictures = SyntheticPictures(camera, eye_of(camera).view, camera.source.synthetic)
        return pictures.picture(_at_start(robot, pipe), 0)
    with opened(camera, path, images) as (_, frame):
        return frame


def _at_start(robot: str | None, pipe: str) -> ShownScene:
    """Return a straight robot at the start in a pipe."""
    body = load_robot(library.find_robot(robot, Path.cwd())).profile.body
    found, _ = load_pipe(library.find_pipe(pipe, Path.cwd()))
    route = found.route()
    lengths = [link.length for link in body.links]
    front_m = found.start_of(sum(lengths))
    wheels = [(front_m - sum(lengths[:number]), 0.0) for number in range(len(lengths) + 1)]
    return scene_in_pipe(wheels, body, route)


def print_sheets(options: PrintOptions) -> int:
    """Write the sheets and print their names; return the exit code.

    Raises:
        LoadError: The camera's file has faults.
        UsageError: A file cannot be written, or would overwrite somebody's work.
    """
    camera, _ = find_camera(options.camera)
    board = Chessboard(*read_board(options.board, options.square))
    sheets = {
        options.output / f"{camera.camera}_{name}.svg": sheet
        for name, sheet in _sheets(camera, board)
    }
    refuse_losses(sheets, overwrite=options.overwrite)
    try:
        options.output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"'{options.output}' cannot be made: {error.strerror}") from None
    for place, sheet in sheets.items():
        write_and_name(place, sheet)
    return 0


def _sheets(camera: Camera, board: Chessboard) -> Iterator[tuple[str, str]]:
    yield "board", board_sheet(board)
    setup, robot = camera.setup, camera.robot
    if setup.tags is not None and setup.size is not None:
        tags = [
            (number, ", ".join(f"{1000 * each:g}" for each in place) + " mm")
            for number, place in setup.at.items()
        ]
        for page, sheet in enumerate(tag_sheets(setup.tags, setup.size, tags), start=1):
            yield f"setup_{page}", sheet
    if isinstance(robot, RobotTags):
        for page, sheet in enumerate(
            tag_sheets(robot.tags, robot.size, list(robot.on.items())), start=1
        ):
            yield f"robot_{page}", sheet


UNKNOWN = UNSEEN = 1


def calibrate_camera(options: CalibrateCameraOptions) -> int:
    """Collect boards, print the lens and write it into the camera's file; return the exit code.

    Raises:
        LoadError: The camera's file has faults.
        UsageError: There are no pictures, or the file cannot be written.
    """
    camera, path = find_camera(options.camera)
    if options.write:
        refuse_shipped(path)
    if isinstance(camera.source, SyntheticSource) and options.images is None:
        raise UsageError("a synthetic camera has no lens to measure: give pictures with --images")
    board = Chessboard(*read_board(options.board, options.square))
    found = _collect(camera, path, board, options)
    model = options.model or (camera.lens.model if camera.lens else "fisheye")
    result = calibrate(found, board, camera.source.size, model)
    if isinstance(result, str):
        print(visible(f"nothing is measured: {result}"))
        return UNKNOWN
    used = len(found) - len(result.left_out)
    print(f"{used} boards, off by {result.rms_px:.2f} px (rms)")
    for name, off_px in result.left_out.items():
        print(visible(f"{name} is left out: its corners are off by {off_px:.1f} px"))
    print(lens_line(result.lens))
    if options.write:
        write_file(path, with_lens(path, result.lens))
        print(visible(f"written into {path}; the camera must be surveyed with this lens"))
    return 0


def _collect(
    camera: Camera, path: Path, board: Chessboard, options: CalibrateCameraOptions
) -> dict[str, Floats]:
    """Return the corners of boards at different places, by name, as many as are wanted or found."""
    width = camera.source.size[0]
    is_live = options.images is None and isinstance(camera.source, DeviceSource | UrlSource)
    until_s = time.monotonic() + options.seconds if is_live else inf
    boards: dict[str, Floats] = {}
    with (
        opened(camera, path, options.images) as (capture, first),
        progress("looking for boards: hold it into all parts, tilted to each side") as watch,
    ):
        frame: Frame | None = first
        names = iter(capture.names if isinstance(capture, ImageCapture) else ())
        while frame is not None and len(boards) < options.boards and time.monotonic() < until_s:
            name = next(names, f"board {len(boards) + 1}")
            gray = grayed(frame)
            corners = find_board(gray, board)
            if (
                corners is not None
                and is_another(corners, list(boards.values()), width)
                and is_sharp(gray, corners, board)
            ):
                boards[name] = corners
                watch(len(boards) / options.boards)
            frame = capture.read()
    return boards


def survey_camera(options: SurveyOptions) -> int:
    """Print where the camera hangs and write it into its file; return the exit code.

    Raises:
        LoadError: The camera's file has faults.
        UsageError: Its lens is unknown, there is no picture, it shows a tag twice, or the file
            cannot be written.
    """
    camera, path = find_camera(options.camera)
    if options.write:
        refuse_shipped(path)
    if camera.lens is None:
        raise UsageError("the lens is unknown: measure it first with `pirate camera calibrate`")
    if camera.setup.tags is None and not camera.setup.points:
        raise UsageError("the setup has neither tags nor points: put them into the camera's file")
    found = survey(LensModel(camera.lens), _known(camera, path, options.images))
    if isinstance(found, str):
        print(visible(f"nothing is written: {found}"))
        return UNKNOWN
    for name, off_px in found.each_px.items():
        print(f"  {name:<10} off by {off_px:.1f} px")
    print(f"{len(found.each_px)} known places, off by {found.rms_px:.2f} px (rms)")
    print(pose_line(found.pose))
    if options.write:
        write_file(path, with_pose(path, found.pose))
        print(visible(f"written into {path}"))
    return 0


def _known(camera: Camera, path: Path, images: str | None) -> dict[str, KnownPlace]:
    """Return the known places of the setup; the camera's file says where points are seen."""
    if camera.setup.tags is None:
        return known_points(camera)
    if isinstance(camera.source, SyntheticSource) and images is None:
        raise UsageError("a synthetic camera hangs where its file says: give pictures (--images)")
    with opened(camera, path, images) as (_, frame):
        return known_tags(camera, frame)


def look(options: LookOptions) -> int:
    """Print what is found, and write the picture with it; return the exit code.

    Raises:
        LoadError: A file has faults.
        UsageError: The camera is not calibrated or surveyed, or gives no picture, or the picture
            cannot be written.
    """
    camera, path = find_camera(options.camera)
    if options.output:
        # Path.glob takes no absolute pattern.
        inputs = [path, *map(Path, glob(options.images or ""))]  # noqa: PTH207
        refuse_losses([options.output], inputs=inputs, overwrite=options.overwrite)
    eye = eye_of(camera)
    frame = one_picture(camera, path, options.images, options.robot, options.pipe)
    sighting = eye.see(frame, 0.0)
    for line in _lines(camera, sighting):
        print(visible(line))
    if options.output:
        _write(options.output, annotated(eye, frame, sighting))
        print(visible(str(options.output)))
    return 0 if sighting.marks else UNSEEN


def _lines(camera: Camera, sighting: Sighting) -> Iterator[str]:
    for mark in sighting.marks:
        x, y = (1000 * each for each in mark.place_m)
        turned = "" if mark.heading_rad is None else f", {degrees(mark.heading_rad):z6.1f} deg"
        yield f"  {mark.on:<12} x {x:7.1f} mm, y {y:7.1f} mm{turned}"
    wanted = len(camera.robot.on) if isinstance(camera.robot, RobotTags) else 1
    yield f"{len(sighting.marks)} of {wanted} marks of the robot are seen"
    if sighting.rms_px is not None:
        yield f"the setup's tags are {sighting.rms_px:.1f} px off the survey (rms)"
    yield f"spread of gray {sighting.gray_spread:.0f} of 255"


def _write(place: Path, frame: object) -> None:
    if place.suffix.lower() not in (".png", ".jpg", ".jpeg"):
        raise UsageError(f"'{place}': expected a name that ends in .png or .jpg")
    made, content = cv2.imencode(place.suffix, frame)
    if not made:
        raise UsageError(f"'{place}' cannot be written: OpenCV makes no such file of it")
    write_bytes(place, content.tobytes())
