"""The functions whose machine code is built with the package: those that Python itself calls.

To build another function, add its line to `ENTRY_POINTS` and install the package again. What it
calls is built with it. What it takes is in its `signatures` after a run with `PIRATE_SM_JIT=1`.
This module imports the standard library alone: the build reads the table before numpy is there.
"""

from __future__ import annotations

from typing import NamedTuple


class Element(NamedTuple):
    """The elements of an array.

    Attributes:
        type: Their type, as numba calls it.
        letters: What numpy may call it, on machines of 64 bits.
    """

    type: str
    letters: str


ARRAYS = {
    "Floats": Element("float64", "d"),
    "Ints": Element("int64", "lq"),
    "Words": Element("uint64", "LQ"),
}
"""By the names of the arrays in `simulation/arrays.py`."""

SCALARS = ("float", "int", "bool")

GROUPS = {
    "Bars": "Floats1 Floats1 Floats2 Floats2 Floats2 Floats1 Floats1 Floats1 Ints1 int",
    "Electronics": "Floats2 Floats1 Words1 Floats1",
    "Looker": "Floats1 Floats2 Floats2 Floats2 Floats2 Floats2",
    "Place": "Floats1 Floats1 Floats1 Floats1",
    "Posture": "Floats2 Floats2 Ints1 Floats2",
    "RobotRows": "Ints2 Ints2 Ints1 Floats1",
    "Round": "Floats1 Floats1 Floats2 Floats2 Floats2 Floats2 Floats2 Floats1 Floats1"
    " Floats1 Ints1 int",
    "Scratch": "Floats1 Floats1",
    "Taken": "Floats1 Ints1 Floats2 Floats2 Ints1",
    "Task": "Ints2 Floats2 Floats1 Floats2 Floats1",
}
"""What each group of arguments that is passed as one tuple consists of, by the name of its type."""


class Argument(NamedTuple):
    """What an argument must be.

    Attributes:
        kind: A key of `ARRAYS` or `GROUPS`, or one of `SCALARS`.
        dimensions: Of an array; 0 for a number or a group.
        members: Of a group.
    """

    kind: str
    dimensions: int = 0
    members: tuple[Argument, ...] = ()


class EntryPoint(NamedTuple):
    """A function that Python calls by its machine code.

    Attributes:
        module: Full name of its module.
        name: Its name there.
        arguments: Its arguments in order.
        result: One of `SCALARS`, or `None`.
        long: Whether a call takes so long that other threads of Python should go on meanwhile.
    """

    module: str
    name: str
    arguments: tuple[Argument, ...]
    result: str
    long: bool = False

    @property
    def flat(self) -> tuple[Argument, ...]:
        """Its arguments, with the members of each group in its place."""
        return tuple(each for it in self.arguments for each in it.members or (it,))

    @property
    def numbers(self) -> tuple[Argument, ...]:
        """Those of them that are no arrays."""
        return tuple(each for each in self.flat if not each.dimensions)

    @property
    def symbol(self) -> str:
        """Its name in the library."""
        return f"{self.module}.{self.name}".replace(".", "_")


def entry_point(
    place: str, arguments: str, result: str = "None", *, long: bool = False
) -> EntryPoint:
    """Return an entry point from text.

    Args:
        place: `module:name`.
        arguments: The annotations of the arguments in order; an array's with the number of its
            dimensions, such as `Floats2`. Arrays are contiguous, in C order, and may be written to.
            The name of a group is a tuple.
        result: The annotation of the result.
        long: As in :class:`EntryPoint`.

    Raises:
        ValueError: An argument or the result has no machine type.
    """
    module, _, name = place.partition(":")
    if result not in (*SCALARS, "None"):
        raise ValueError(f"{place}: {result!r} cannot be returned, only {', '.join(SCALARS)}")
    return EntryPoint(module, name, _arguments(place, arguments), result, long)


def _arguments(place: str, texts: str) -> tuple[Argument, ...]:
    return tuple(_argument(place, text) for text in texts.replace(",", " ").split())


def _argument(place: str, text: str) -> Argument:
    if text in SCALARS:
        return Argument(text)
    if text in GROUPS:
        return Argument(text, members=_arguments(place, GROUPS[text]))
    kind, dimensions = text[:-1], text[-1:]
    if kind not in ARRAYS or dimensions not in "123":
        known = ", ".join((*SCALARS, *(f"{name}1, {name}2" for name in ARRAYS)))
        raise ValueError(f"{place}: {text!r} is no machine type; there are {known} ...")
    return Argument(kind, int(dimensions))


_GLIDING = (
    "Floats1 Place Ints2 Electronics RobotRows Task Floats1 Floats1 Scratch Posture Looker Taken "
    "Floats2"
)
_PASSING = "Place Ints2 Floats2 Floats1 Words1 Floats1"
"""What gliding takes besides the chain, and what cycles take besides to pass."""

ENTRY_POINTS = (
    entry_point("pirate_sm.simulation.kinematic.kernel:advance", GROUPS["Bars"]),
    entry_point("pirate_sm.simulation.kinematic.kernel:glide", f"Bars {_GLIDING}", long=True),
    entry_point("pirate_sm.simulation.kinematic.kernel:pass_cycles", f"Bars {_PASSING}", long=True),
    entry_point("pirate_sm.simulation.kinematic.space.kernel:advance", GROUPS["Round"]),
    entry_point(
        "pirate_sm.simulation.kinematic.space.kernel:glide", f"Round {_GLIDING}", long=True
    ),
    entry_point(
        "pirate_sm.simulation.kinematic.space.kernel:pass_cycles", f"Round {_PASSING}", long=True
    ),
    entry_point(
        "pirate_sm.simulation.digitizing:digitize", "Floats2 int int Floats1 Floats1 Words1"
    ),
    entry_point(
        "pirate_sm.lab.experiments.reduced_kernel:simulate",
        "Floats2 Floats1 Floats2 Floats2 Floats2 bool int Floats2 Floats2",
    ),
)

BY_PLACE = {(each.module, each.name): each for each in ENTRY_POINTS}
