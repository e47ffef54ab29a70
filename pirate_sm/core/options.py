"""The options of a run, each declared once.

From these declarations follow the options of `pirate run` and of the console with what a shell
completes, the checks of the Python API's arguments, what campaigns may say and how they repeat a
run, and what a report says of a recording. A recording keeps each option under its Python name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field, fields, replace
from math import inf, isfinite
from os import PathLike
from typing import (
    Any,
    Final,
    Literal,
    NamedTuple,
    TypeAlias,
    TypedDict,
    get_args,
    get_origin,
    get_type_hints,
)

from pirate_sm.core.units import (
    DIMENSIONLESS,
    LENGTH,
    TIME,
    TORQUE,
    Dimension,
    format_quantity,
    read_quantity,
)

Fidelity: TypeAlias = Literal["usual", "fast"]
"""``fast`` computes half the iterations and is coarser, with an error that has been measured."""

USUAL: Fidelity = "usual"

OF_PIPE: Final = "pipe."
"""Begins the names of the numbers of a run that are the pipe's, not the robot's."""


class Options(TypedDict, total=False):
    """Options that ``run``, ``session`` and ``sweep`` share; all may be left out.

    Attributes:
        robot: Name or path of a robot, instead of the mission's own.
        pipe: Name or path of a pipe, instead of the mission's own.
        set: Values of parameters by name, as a mission writes them: ``{"give_up": "30 s"}``.
        start_phase: The phase to begin with, instead of the mission's own.
        states: State names by region that the robot is in, instead of ``starts_in``.
        defects: Known defects of the simulated robot, each as text,
            ``"stiff_joint:friction=0.5Nm,after=2s"``, or as a mapping,
            ``{"defect": "stiff_joint", "after": "2 s"}``.
        twin: File with numbers of the simulated robot, from ``pirate fit --robot``.
        numbers: Numbers of the simulated robot, by their keys in such a file:
            ``{"motors.bend.stall_torque": "0.8 Nm"}``; or of its pipe, which the mission does not
            know: ``{"pipe.friction": 0.4}``, likewise ``diameter``, ``tilt``, ``roll``, ``start``.
        fitted: Such a file with numbers of the motors, by which any robot is judged.
        forecast: File with times of earlier runs, from ``pirate forecast``; the log says where this
            run is slower.
        start_jitter_m: How far a simulated robot may start from its place; likewise
            ``diameter_jitter_m`` of the pipe, and ``friction_jitter`` as a share.
        fidelity: How finely the backend ``sim`` computes: ``"usual"``, or ``"fast"``, with half the
            iterations, which is coarser.
        detector: Name of a detector, instead of the backend's usual one.
        also: A second detector, whose words are logged and do nothing.
        ruler: Whether a simulated ruler measures the robot's speed from outside, for slip.
        view: Whether MuJoCo's own viewer shows the run; the backend ``physics`` alone has one.
        start_at_m: Where odometry takes the first wheel to begin, instead of the pipe's own.
        port: Where a real robot is, a device or a URL of pyserial; ``baud`` instead of its rate.
    """

    robot: str | PathLike[str] | None
    pipe: str | PathLike[str] | None
    set: Mapping[str, object] | None
    start_phase: str | None
    states: Mapping[str, str] | None
    defects: Iterable[str | Mapping[str, object]]
    twin: str | PathLike[str] | None
    numbers: Mapping[str, object] | None
    fitted: str | PathLike[str] | None
    forecast: str | PathLike[str] | None
    start_jitter_m: float
    diameter_jitter_m: float
    friction_jitter: float
    fidelity: Fidelity
    detector: str | None
    also: str | None
    ruler: bool
    view: bool
    start_at_m: float | None
    port: str | None
    baud: int | None


class Only(NamedTuple):
    """The backends that have an option, the one to suggest first, and what the others lack."""

    backends: tuple[str, ...]
    lacks: str


OTHERS = "others"
"""Backends of other packages, which may have what ours lack."""

_SIMULATORS = ("sim", "physics")
_OF_SIMULATED = Only((*_SIMULATORS, "bay", OTHERS), "has no simulated robot")
_OF_MOVING = Only((*_SIMULATORS, "bay", "serial", OTHERS), "has no robot that moves")
_OF_PORT = Only(("serial", OTHERS), "has no port: the real robot would not move")


@dataclass(frozen=True)
class RunOption:
    """An option of a run, as people give it.

    Attributes:
        help: What it means.
        flag: How a command line writes it; empty: its name without its unit. ``settings`` alone
            also has another name in Python, ``set``.
        form: The form of its value in help texts; empty for what needs none.
        completes: What a shell offers, a function of ``pirate_sm.cli.completion``.
        unit: Of a number that is written with its unit.
        least: The least value of a number.
        below: A number with a unit must be less.
        key: Its name in ``--jitter KEY=VALUE`` and in the ``jitter`` of campaigns if it says how
            far a simulated run may differ from its files; empty for all others.
        usual: What a command takes where it is not given; None: the same as elsewhere.
        only: The backends that have it; None: all.
        in_campaigns: Whether a campaign may say it: one value, or many, of which each makes cells.
        name: Its name in Python, in recordings and in an order of a run.
        type: Type of its value.
        default: Its value where it is not given.
    """

    help: str
    _: KW_ONLY
    flag: str = ""
    form: str = ""
    completes: str = ""
    unit: Dimension | None = None
    least: int | None = None
    below: float | None = None
    key: str = ""
    usual: Any = None
    only: Only | None = None
    in_campaigns: Literal["", "one", "many"] = ""
    name: str = ""
    type: Any = None
    default: Any = None

    @property
    def word(self) -> str:
        """Its name in campaigns and in most flags: without its unit."""
        if self.key:
            return "jitter"
        return self.name if self.unit is None else self.name.rpartition("_")[0]

    @property
    def many(self) -> Any:
        """``Mapping`` or ``tuple`` if it can be given several times; otherwise None."""
        kinds = (get_origin(each) for each in (self.type, *get_args(self.type)))
        return next((kind for kind in kinds if kind in (Mapping, tuple)), None)

    @property
    def on_command_line(self) -> Any:
        """What a command takes where it is not given, as it is written."""
        if self.many or self.key:
            return None
        return self.default if self.usual is None else self.usual

    def texts(self, value: Any) -> Iterator[str]:
        """Yield the texts that give a value on a command line, one for each time it is given."""
        if isinstance(value, Mapping):
            yield from (f"{name}={each}" for name, each in value.items())
        elif isinstance(value, tuple):
            yield from value
        else:
            text = str(value) if self.unit is None else written(value, self.unit).replace(" ", "")
            yield f"{self.key}={text}" if self.key else text


def written(value: float, unit: Dimension) -> str:
    """Return a length, a time or a share as people write it: ``20 mm``; it is read exactly."""
    factor, sign = {LENGTH: (1000, "mm"), TIME: (1000, "ms"), DIMENSIONLESS: (100, "%")}[unit]
    text = f"{value * factor:.12g} {sign}"
    exact = not isfinite(value) or read_quantity(text, unit) == value
    return text if exact else format_quantity(value, unit)


def _option(default: Any, help_text: str, form: str = "", completes: str = "", **more: Any) -> Any:
    given: dict[str, Any] = {"default_factory": dict} if default == {} else {"default": default}
    option = RunOption(help_text, form=form, completes=completes, default=default, **more)
    return field(**given, metadata={"option": option})


def _jitter(key: str, unit: Dimension, example: str, help_text: str, **more: Any) -> Any:
    more |= {"key": key, "unit": unit, "least": 0, "only": _OF_SIMULATED, "in_campaigns": "one"}
    return _option(0.0, help_text, example, **more)


@dataclass(frozen=True)
class GivenOptions:
    """The mission of a run and all its options that people give.

    Attributes:
        mission: Name of a shipped mission, or the path of a file.
    """

    mission: str
    backend: str = _option(
        "sim",
        "sim: the kinematic simulator; physics: MuJoCo; bay: the serial link to an emulated "
        "robot; trace: nothing moves; serial: the real robot; others: pirate list backends.",
        "NAME",
        "backends",
        in_campaigns="many",
    )
    robot: str | None = _option(
        None, "Robot to use instead of the mission's.", "NAME", "robots", in_campaigns="many"
    )
    pipe: str | None = _option(
        None, "Pipe to use instead of the mission's.", "NAME", "pipes", in_campaigns="many"
    )
    settings: Mapping[str, str] = _option(
        {}, "A parameter's value. Repeatable.", "NAME=VALUE", "parameters", flag="--set"
    )
    states: Mapping[str, str] | None = _option(
        None, "The robot is in this state, instead of starts_in.", "REGION=STATE", "states",
        flag="--state",
    )  # fmt: skip
    seed: int = _option(0, "Seed of all random numbers.", least=0)
    defects: tuple[str, ...] = _option(
        (), "Switch on a known defect, such as NAME:friction=0.5Nm,after=2s. Repeatable.",
        "NAME[:KEY=VALUE,…]", "defects", flag="--defect", only=_OF_SIMULATED, in_campaigns="many",
    )  # fmt: skip
    fidelity: Fidelity = _option(
        USUAL,
        "Of sim; fast computes half the iterations and is coarser.",
        only=Only(("sim",), "cannot be made fast"),
        in_campaigns="one",
    )
    view: bool = _option(
        False, "Show the backend physics in MuJoCo's own viewer.",
        only=Only(("physics",), "has no viewer"),
    )  # fmt: skip
    port: str | None = _option(
        None, "Of the real robot: /dev/ttyACM0, or a pyserial URL.", "PORT", "ports",
        only=_OF_PORT,
    )  # fmt: skip
    baud: int | None = _option(None, "Rate to use instead of the robot's.", least=1, only=_OF_PORT)
    guard_for_s: float | None = _option(
        None,
        "How long the port is guarded if the robot does not confirm that it has stopped; 10 min.",
        "DURATION",
        unit=TIME,
        only=_OF_PORT,
    )
    detector: str | None = _option(
        None, "What reports where the robot is. For sim: sim, for serial: odometry.",
        "sim|odometry|vision:CAMERA|NAME", "detectors", only=_OF_MOVING, in_campaigns="many",
    )  # fmt: skip
    also: str | None = _option(
        None, "A second detector, to compare: its words are logged and do nothing.",
        "DETECTOR", "detectors", only=_OF_MOVING,
    )  # fmt: skip
    panel: str | None = _option(
        None, "A MIDI control panel, with its stop; others: pirate panel.",
        "NAME[:DEVICE]", "panels",
    )  # fmt: skip
    ruler: bool = _option(
        False, "In sim: a ruler outside measures the robot's speed, for slip.",
        only=Only((*_SIMULATORS, OTHERS), "has no simulated ruler"),
    )  # fmt: skip
    start_at_m: float | None = _option(
        None, "Where the first wheel begins, for odometry.", "LENGTH",
        unit=LENGTH, only=_OF_MOVING,
    )  # fmt: skip
    calibration: bool = _option(True, "Use its joint zeros.")
    check: bool = _option(False, "Reject missions with errors.", usual=True)
    twin: str | None = _option(
        None, "Numbers of the simulated robot, from pirate fit --robot.", "FILE", "twins",
        only=_OF_SIMULATED, in_campaigns="one",
    )  # fmt: skip
    numbers: Mapping[str, str] = _option(
        {}, "A number of the simulated robot or pipe: pipe.friction=0.4. Repeatable.", "NAME=VALUE",
        "numbers", flag="--number", only=_OF_SIMULATED,
    )  # fmt: skip
    fitted: str | None = _option(
        None, "Numbers of its motors to judge it by, from pirate fit.", "FILE", "twins"
    )
    forecast: str | None = _option(
        None, "Earlier runs to compare it with, from pirate forecast.", "FILE", "checkable",
        only=_OF_MOVING,
    )  # fmt: skip
    start_phase: str | None = _option(
        None, "Begin with this phase.", "PHASE", "phases", flag="--from"
    )
    start_jitter_m: float = _jitter("start", LENGTH, "20mm", "Of the robot's place along the pipe.")
    friction_jitter: float = _jitter(
        "friction", DIMENSIONLESS, "20%", "Of all friction coefficients, as a share.", below=1.0
    )
    diameter_jitter_m: float = _jitter("diameter", LENGTH, "2mm", "Of all inner diameters.")

    @property
    def jitter(self) -> Mapping[str, float]:
        """How far a simulated run may differ from its files, by what differs."""
        return {each.name.replace("_jitter", ""): getattr(self, each.name) for each in JITTER}

    def command(self) -> list[str]:
        """Return the words of a command line that give these options, without its defaults."""
        words = [self.mission]
        for each in OPTIONS.values():
            value = getattr(self, each.name)
            if value == (each.default if each.many or each.key else each.on_command_line):
                continue
            if isinstance(value, bool):
                words.append(each.flag if value else each.flag.replace("--", "--no-", 1))
            else:
                words += [word for text in each.texts(value) for word in (each.flag, text)]
        return words


def _named(option: RunOption, name: str, kind: Any) -> RunOption:
    found = replace(option, name=name, type=kind)
    return found if option.flag else replace(found, flag=f"--{found.word.replace('_', '-')}")


_TYPES = get_type_hints(GivenOptions)
OPTIONS: Mapping[str, RunOption] = {
    each.name: _named(each.metadata["option"], each.name, _TYPES[each.name])
    for each in fields(GivenOptions)
    if "option" in each.metadata
}
"""All options by their names in Python, in the order of help texts."""

DIFFERS = "How far a simulated run may differ"
JITTER = tuple(each for each in OPTIONS.values() if each.key)
"""Those that say how far a simulated run may differ from its files."""


class DefectKey(NamedTuple):
    """A number that a defect takes.

    Attributes:
        meaning: What it is, in words.
        dimension: Its dimension; None: that of the affected signals.
        most: Its largest value. Numbers with a dimension of their own are at least 0.
    """

    meaning: str
    dimension: Dimension | None = None
    most: float = inf


DEFECT_KEYS: Final[Mapping[str, DefectKey]] = {
    "after": DefectKey("when it begins, from the start of the run", TIME),
    "every": DefectKey("mean time between two occurrences", TIME),
    "lasting": DefectKey("how long one occurrence lasts", TIME),
    "friction": DefectKey("dry friction of a stiff joint, drag of a dead wheel", TORQUE),
    "share": DefectKey("share of lost messages", DIMENSIONLESS, 0.5),
    "by": DefectKey("how far the zero jumps"),
    "shows": DefectKey("what the sensor shows"),
}
"""The numbers of defects.

A defect is written ``stiff_joint:friction=0.9Nm,after=2s``: its name and its numbers, which replace
those of the profile. A range, ``after=2s..20s``, is drawn uniformly from the seed of the run, which
shows and records the number that was drawn. Files and Python may write a mapping:
``{defect: stiff_joint, after: 2 s}``.
"""
_SPELLS: Final = ("after", "every", "lasting")
_TAKES: Final[Mapping[str, tuple[str, ...]]] = {
    "dead_wheel": ("friction", "after"),
    "stiff_joint": ("friction", "after"),
    "sensor_stuck": ("shows", *_SPELLS),
    "sensor_drop": ("shows", *_SPELLS),
    "sensor_spike": ("shows", *_SPELLS),
    "zero_jump": ("by", "after", "every"),
    "lost_messages": ("share", *_SPELLS),
    "firmware_reset": ("after", "every"),
    "stray_motion": ("after", "every"),
}


def keys_of_defect(kind: str) -> tuple[str, ...]:
    """Return the names of the numbers that a kind of defect takes."""
    return _TAKES.get(kind, _SPELLS)


def defect_as_text(written: object) -> object:
    """Return a defect that is written as a mapping as text; anything else as it is."""
    if not (isinstance(written, Mapping) and isinstance(written.get("defect"), str)):
        return written
    pairs = [f"{key}={value}".replace(" ", "") for key, value in written.items() if key != "defect"]
    return f"{written['defect']}:{','.join(pairs)}" if pairs else written["defect"]
