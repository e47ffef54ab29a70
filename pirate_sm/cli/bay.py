"""`pirate bay`: an emulated bay behind a pseudo-terminal, in real time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

from pirate_sm.cli.guard import say
from pirate_sm.errors import UsageError
from pirate_sm.loading import library
from pirate_sm.loading.mission import load_mission
from pirate_sm.loading.pipe import load_pipe
from pirate_sm.loading.robot import load_robot
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile
from pirate_sm.spelling import nearest, one_of
from pirate_sm.units import DIMENSIONLESS, read_quantity
from pirate_sm.wiring.sim import COMPILING, start_values

if TYPE_CHECKING:
    from pirate_sm.bay.switches import Switches, Topic

_INSTALLED = {"llvmlite", "numba", "numpy", "rosbags"}
"""What the extras `sim` and `serial` install."""


@dataclass(frozen=True)
class BayWishes:
    """What somebody wants to be emulated, in their own words; None for what they left open."""

    mission: str | None
    robot: str | None
    pipe: str | None
    seed: int
    link: Path | None
    log: Path | None
    loss_in: str | None
    loss_out: str | None
    never_two: bool
    corruption: str | None
    delay_s: float
    jitter_s: float
    reset_at_s: Sequence[float]
    reset_every_s: float
    hang_at_s: float | None
    hang_for_s: float | None
    boot_s: float | None
    overrun: bool
    stale_every_s: float
    wrong_md5: Sequence[str]
    unconfigured_at_s: Sequence[float]
    spontaneous_at_s: Sequence[float]
    motors_started: bool
    sensors_started: bool
    old_client: bool
    dead_man: bool
    defects: Sequence[str]


class _Setting(NamedTuple):
    """A robot in a place."""

    profile: Profile
    folder: Path
    pipe: Pipe
    start_values: tuple[float, ...] | None


def run_bay(wishes: BayWishes) -> int:
    """The bay has run until it was told to end; its exit code.

    Raises:
        LoadError: Files cannot be used.
        UsageError: Something does not fit, or an optional part is not installed.
        BackendError: There is no pseudo-terminal.
    """
    try:
        from pirate_sm.backends.simulator import kernel
        from pirate_sm.bay.terminal import Terminal, Told, serve
        from pirate_sm.bay.texts import message_texts
        from pirate_sm.bay.virtual import VirtualBay
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in _INSTALLED:
            raise
        raise UsageError(
            f"the emulated bay needs {error.name}, which is not installed: "
            "pip install 'pirate-sm[sim,serial]'"
        ) from None
    switches = _switches(wishes)
    at = _setting(wishes)
    texts = message_texts(at.folder, at.profile)
    if not kernel.is_compiled():
        say(COMPILING)
    baud = at.profile.serial.baud if at.profile.serial is not None else None
    bay = VirtualBay(at.profile, at.pipe, texts, switches, wishes.seed, at.start_values)
    with ExitStack() as stack:
        told = stack.enter_context(Told())
        log = stack.enter_context(_log(wishes.log)) if wishes.log is not None else None
        terminal = stack.enter_context(Terminal(wishes.link, baud))
        print(terminal.name, flush=True)
        serve(bay, terminal, lambda: told.stop, log)
    return 0


def _log(path: Path) -> TextIO:
    try:
        return path.open("w", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"'{path}' cannot be written: {error.strerror}") from None


def _switches(wishes: BayWishes) -> Switches:
    from pirate_sm.bay.switches import RING, Switches

    return Switches(
        loss_in=_share(wishes.loss_in),
        loss_out=_share(wishes.loss_out),
        never_two=wishes.never_two,
        corruption=_share(wishes.corruption),
        delay_s=wishes.delay_s,
        jitter_s=wishes.jitter_s,
        reset_at_s=tuple(wishes.reset_at_s),
        reset_every_s=wishes.reset_every_s,
        hang_at_s=_or_never(wishes.hang_at_s),
        hang_for_s=_or_never(wishes.hang_for_s),
        boot_s=wishes.boot_s,
        ring=RING if wishes.overrun else None,
        stale_every_s=wishes.stale_every_s,
        wrong_md5=_topics(wishes.wrong_md5),
        unconfigured_at_s=tuple(wishes.unconfigured_at_s),
        spontaneous_at_s=tuple(wishes.spontaneous_at_s),
        motors_started=wishes.motors_started,
        sensors_started=wishes.sensors_started,
        old_client=wishes.old_client,
        dead_man=wishes.dead_man,
        defects=tuple(wishes.defects),
    )


def _share(text: str | None) -> float:
    """The share that text such as ``20%`` or ``0.2`` means."""
    return 0.0 if text is None else read_quantity(text, DIMENSIONLESS)


def _or_never(time_s: float | None) -> float:
    return math.inf if time_s is None else time_s


def _topics(names: Sequence[str]) -> tuple[Topic, ...]:
    from pirate_sm.bay.switches import TOPICS

    for name in names:
        if name not in TOPICS:
            close = nearest(name, TOPICS)
            hint = f"did you mean '{close}'?" if close else f"expected {one_of(TOPICS)}"
            raise UsageError(f"there is no topic '{name}': {hint}")
    return tuple(topic for topic in TOPICS if topic in names)


def _setting(wishes: BayWishes) -> _Setting:
    """What the mission says, and the first robot and pipe shipped where nobody says anything."""
    if wishes.mission is not None:
        return _setting_of(wishes.mission, wishes)
    folder = library.find_robot(wishes.robot, Path.cwd()) if wishes.robot else library.robots()[0]
    return _Setting(load_robot(folder).profile, folder, _pipe(wishes.pipe), None)


def _setting_of(name: str, wishes: BayWishes) -> _Setting:
    path = library.find_mission(name)
    mission = load_mission(path, robot=wishes.robot, pipe=wishes.pipe)
    if wishes.robot is not None:
        folder = library.find_robot(wishes.robot)
    else:
        folder = library.find_robot(mission.mission.robot, path.resolve().parent)
    pipe = mission.pipe or _pipe(wishes.pipe)
    return _Setting(mission.loaded_robot.profile, folder, pipe, start_values(mission))


def _pipe(name: str | None) -> Pipe:
    file = library.find_pipe(name, Path.cwd()) if name else library.pipes()[0]
    return load_pipe(file)[0]
