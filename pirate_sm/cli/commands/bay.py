"""`pirate bay`: an emulated bay behind a pseudo-terminal, in real time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

from pirate_sm.cli.errors import say
from pirate_sm.cli.options.devices import BayOptions
from pirate_sm.cli.output.files import refuse_losses
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_mission, load_pipe, load_robot
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import DIMENSIONLESS, read_quantity
from pirate_sm.running.wiring.backends import COMPILING, start_values, without_messages

if TYPE_CHECKING:
    from pirate_sm.simulation.bay.bay_defects import Switches, Topic


class _Setting(NamedTuple):
    """A robot in a pipe."""

    profile: Profile
    folder: Path
    pipe: Pipe
    start_values: tuple[float, ...] | None


def run_bay(options: BayOptions) -> int:
    """Emulate the bay until a signal stops it; return the exit code.

    Raises:
        LoadError: Files cannot be used.
        UsageError: Something does not fit, or an optional part is not installed.
        BackendError: There is no pseudo-terminal.
    """
    try:
        from pirate_sm.simulation.bay.node_handle import message_texts
        from pirate_sm.simulation.bay.terminal import StopSignals, Terminal, serve
        from pirate_sm.simulation.bay.virtual import VirtualBay
        from pirate_sm.simulation.kinematic.world import is_compiled
    except ModuleNotFoundError as error:
        raise without_messages(error) from None
    if options.log is not None:
        refuse_losses([options.log], overwrite=options.overwrite)
    switches = _switches(options)
    at = _setting(options)
    texts = message_texts(at.folder, at.profile)
    if not is_compiled(at.pipe.section):
        say(COMPILING)
    baud = at.profile.serial.baud if at.profile.serial is not None else None
    bay = VirtualBay(at.profile, at.pipe, texts, switches, options.seed, at.start_values)
    with ExitStack() as stack:
        signals = stack.enter_context(StopSignals())
        log = stack.enter_context(_log(options.log)) if options.log is not None else None
        terminal = stack.enter_context(Terminal(options.link, baud))
        print(terminal.name, flush=True)
        serve(bay, terminal, lambda: signals.stop, log)
    return 0


def _log(path: Path) -> TextIO:
    try:
        # It grows while the bay runs and can be read meanwhile, so no other file takes its place.
        return path.open("w", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"'{path}' cannot be written: {error.strerror}") from None


def _switches(options: BayOptions) -> Switches:
    from pirate_sm.simulation.bay.bay_defects import RING, Switches

    return Switches(
        loss_in=_share(options.loss_in or options.loss),
        loss_out=_share(options.loss_out or options.loss),
        never_two=options.never_two,
        corruption=_share(options.corruption),
        delay_s=options.delay,
        jitter_s=options.jitter,
        reset_at_s=tuple(options.reset_at or ()),
        reset_every_s=options.reset_every,
        hang_at_s=_or_never(options.hang_at),
        hang_for_s=_or_never(options.hang_for),
        boot_s=options.boot,
        ring=RING if options.overrun else None,
        stale_every_s=options.stale_every,
        wrong_md5=_topics(options.wrong_md5 or ()),
        unconfigured_at_s=tuple(options.unconfigured_at or ()),
        spontaneous_at_s=tuple(options.spontaneous_at or ()),
        motors_started=options.motors_started,
        sensors_started=options.sensors_started,
        old_client=options.old_client,
        dead_man=options.dead_man,
        defects=tuple(options.defects or ()),
    )


def _share(text: str | None) -> float:
    """Return the share in text such as ``20%`` or ``0.2``."""
    return 0.0 if text is None else read_quantity(text, DIMENSIONLESS)


def _or_never(time_s: float | None) -> float:
    return math.inf if time_s is None else time_s


def _topics(names: Sequence[str]) -> tuple[Topic, ...]:
    from pirate_sm.simulation.bay.bay_defects import TOPICS

    if wrong := unknown("there is no topic", names, TOPICS):
        raise UsageError(wrong)
    return tuple(topic for topic in TOPICS if topic in names)


def _setting(options: BayOptions) -> _Setting:
    """Return the robot and pipe of the options, by default the first shipped ones."""
    if options.mission is not None:
        return _setting_of(options.mission, options)
    folder = library.find_robot(options.robot, Path.cwd())
    return _Setting(load_robot(folder).profile, folder, _pipe(options.pipe), None)


def _setting_of(name: str, options: BayOptions) -> _Setting:
    path = library.find_mission(name)
    mission = load_mission(path, robot=options.robot, pipe=options.pipe)
    if options.robot is not None:
        folder = library.find_robot(options.robot, Path.cwd())
    else:
        folder = library.find_robot(mission.mission.robot, path.resolve().parent)
    pipe = mission.pipe or _pipe(options.pipe)
    return _Setting(mission.loaded_robot.profile, folder, pipe, start_values(mission))


def _pipe(name: str | None) -> Pipe:
    file = library.find_pipe(name, Path.cwd()) if name else library.pipes()[0]
    return load_pipe(file)[0]
