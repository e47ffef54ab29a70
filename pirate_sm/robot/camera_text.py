"""Put measured values into the text of a camera file; all else stays, comments too."""

from __future__ import annotations

import re
from math import degrees
from pathlib import Path

from pirate_sm.core.camera import CameraPose, Lens
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import shown
from pirate_sm.robot.camera_file import load_camera

_LENS = re.compile(r"^lens:.*\n(?:[ \t]+.*\n)*", re.MULTILINE)
_SETUP = re.compile(r"^setup:[ \t]*(?:#.*)?\n", re.MULTILINE)
_POSE = re.compile(r"^([ ]+)pose:.*\n(?:\1[ \t]+.*\n)*", re.MULTILINE)


def lens_line(lens: Lens) -> str:
    """Return the line that gives a camera this lens."""
    f, centre = (f"[{x:.2f}, {y:.2f}]" for x, y in (lens.f, lens.centre))
    k = ", ".join(f"{each:.6g}" for each in lens.k)
    return f"lens: {{model: {lens.model}, f: {f}, centre: {centre}, k: [{k}]}}"


def pose_line(pose: CameraPose) -> str:
    """Return the line that gives a setup this pose of its camera."""
    at = ", ".join(f"{1000 * each:.1f} mm" for each in pose.at)
    turn = ", ".join(f"{degrees(each):z.3f} deg" for each in pose.turn)
    return f"pose: {{at: [{at}], turn: [{turn}]}}"


def with_lens(path: Path, lens: Lens) -> str:
    """Return the text of a camera file with this lens instead of its own.

    Raises:
        LoadError: The file is no camera.
        UsageError: It cannot be changed line by line.
    """
    text, line = _text(path), f"{lens_line(lens)}\n"
    if _LENS.search(text):
        return _LENS.sub(line, text, count=1)
    return re.sub(r"^setup:", f"{line}setup:", _block_like(text, path, line), count=1, flags=re.M)


def with_pose(path: Path, pose: CameraPose) -> str:
    """Return the text of a camera file with this pose instead of its own.

    Raises:
        LoadError: The file is no camera.
        UsageError: It cannot be changed line by line.
    """
    text, line = _text(path), f"  {pose_line(pose)}\n"
    opened = _SETUP.search(_block_like(text, path, line))
    if opened is None:
        raise _by_hand(path, line)
    before, setup = text[: opened.end()], text[opened.end() :]
    end = re.search(r"^\S", setup, re.MULTILINE)
    inside, behind = (setup[: end.start()], setup[end.start() :]) if end else (setup, "")
    if _POSE.search(inside):
        return before + _POSE.sub(rf"\g<1>{line.strip()}\n", inside, count=1) + behind
    indent = re.match(r"(?:[ \t]*#.*\n|[ \t]*\n)*([ ]+)", inside)
    return f"{before}{indent[1] if indent else '  '}{line.strip()}\n{inside}{behind}"


def _text(path: Path) -> str:
    text = load_camera(path, posed=False)[1].text
    return text if text.endswith("\n") else f"{text}\n"


def _block_like(text: str, path: Path, line: str) -> str:
    """Return a text in which each key has a line of its own.

    Raises:
        UsageError: It is written in braces.
    """
    if not re.search(r"^setup:", text, re.MULTILINE):
        raise _by_hand(path, line)
    return text


def _by_hand(path: Path, line: str) -> UsageError:
    return UsageError(f"{shown(path)} is written in braces: put in by hand {line.strip()}")
