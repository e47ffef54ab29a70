"""Known defects of real robots, which a profile configures and a run switches on by name.

A defect changes the motors and sensors, the counts of a frame, or the messages. It acts alike in
the simulator and behind the emulated bay. The kinds are here; a profile's `simulation.defects`
gives them names, targets and numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, TypeAlias

import numpy as np

from pirate_sm.core.errors import Hint, UsageError
from pirate_sm.core.expressions import NumberType, Vocabulary, compile_expression
from pirate_sm.core.models import Defect, Profile
from pirate_sm.core.options import DEFECT_KEYS, keys_of_defect
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import (
    ANGLE,
    Dimension,
    Quantity,
    QuantityError,
    format_quantity,
    parse_quantity,
    read_quantity,
)
from pirate_sm.simulation.acting_defect import ActingDefect, Counts, Incident, Loss, Sudden
from pirate_sm.simulation.electronics import Electronics, scale_of

AtWork: TypeAlias = tuple[Defect, np.random.Generator]
"""A defect and its own random numbers."""

_WANDER_EVERY_S = 0.5
_WANDER_DUTY = 0.3


class Lasting(Sudden):
    """A defect that changes the robot for good; at the start of a run before anything moves."""

    def begin(self) -> None:
        """Strike now if it is there from the start."""
        if self.due_s <= 0.0:
            self.due_s = math.inf
            self.strike(0.0)


class DeadWheel(Lasting):
    """A wheel that its motor does not turn, that drags, and whose sensors stand still."""

    def strike(self, now: float) -> None:
        """Make the wheels drag and their channels stand still."""
        chain = self.robot.chain
        for name in self.defect.wheels:
            wheel = chain.wheel_index[name]
            drag = self.defect.friction or chain.wheels[wheel].dead_drag_nm
            self.robot.physics.disable_wheel(wheel, drag)
            self.robot.mute_wheel(wheel)


class StiffJoint(Lasting):
    """A joint with added dry friction."""

    def strike(self, now: float) -> None:
        """Add the friction to the joint."""
        if self.defect.joint is not None:
            wheel = self.robot.chain.joint_index[self.defect.joint]
            self.robot.physics.stiffen_joint(wheel, self.defect.friction)


class StuckSensor(ActingDefect):
    """Channels that show a fixed count, or without one the last count."""

    def begin(self) -> None:
        """Find the rows of the channels."""
        rows, defect = self.robot.rows, self.defect
        self._rows: dict[int, float] = {rows[name]: math.nan for name in defect.signals}
        self._rows |= {rows[name]: value for name, value in defect.raw.items()}
        self._held: dict[int, float] = {}

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Replace the counts of the stuck channels."""
        mine = [row for row in self._rows if first <= row < first + len(counts)]
        if not mine:
            return counts
        if not self.active(now):
            self._held.clear()
            return counts
        for row in mine:
            shown = self._rows[row]
            if math.isnan(shown):
                shown = self._held.setdefault(row, counts[row - first])
            counts[row - first] = shown
        return counts

    def glides_until_s(self, now: float) -> float:
        """Return when it begins or ends, once its first frame has been seen."""
        if now < self._until:
            seen = all(row in self._held for row, shown in self._rows.items() if math.isnan(shown))
        else:
            seen = not self._held
        return self._phase_until_s(now) if seen else -math.inf

    def forced(self, now: float) -> Mapping[int, float]:
        """Return the counts of the stuck channels while the defect is active."""
        return self._rows | self._held if now < self._until else {}


class ZeroJump(Sudden):
    """Channels whose zero shifts by some counts."""

    def strike(self, now: float) -> None:
        """Shift the zeros."""
        for signal, counts in self.defect.raw.items():
            self.robot.shift(signal, counts)


class Spell(ActingDefect):
    """A defect that, while it is active, looks at each frame or each message."""

    def glides_until_s(self, now: float) -> float:
        """Return when it begins; before ``now`` while it is active."""
        return -math.inf if now < self._until else self._phase_until_s(now)


class SilentBoards(Spell):
    """Boards that report nothing; their motors obey."""

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Lose the frames of the boards."""
        return None if board in self.defect.boards and self.active(now) else counts


class SilentBay(SilentBoards):
    """A bay that publishes and echoes nothing, while motors move without a command."""

    _wander = -math.inf

    def step(self, now: float) -> Incident | None:
        """Give a motor a random duty from time to time."""
        if self.active(now) and now >= self._wander:
            self._wander = now + _WANDER_EVERY_S
            duties = self.robot.physics.duties
            index = int(self.rng.integers(len(duties)))
            duties[index] = self.rng.uniform(-_WANDER_DUTY, _WANDER_DUTY)
        return None

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Lose every frame."""
        return None if self.active(now) else counts

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Lose every array and echo."""
        arrives = not self.active(now)
        return arrives, arrives


class LostMessages(Spell):
    """A share of messages is lost; of two in a row one always arrives (thesis 4-2-2)."""

    def begin(self) -> None:
        """Begin with no losses."""
        self._loss = Loss(self.defect.share, True, self.rng)

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Return the counts, or lose the frame at random."""
        return None if self.active(now) and not self._loss.arrives("frame") else counts

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Lose the array or its echo at random."""
        if not self.active(now):
            return True, True
        arrives = self._loss.arrives("array")
        return arrives, arrives and self._loss.arrives("echo")


class StaleRepeats(Spell):
    """Boards that repeat their last values for a time."""

    def begin(self) -> None:
        """Begin without remembered values."""
        self._last: dict[int, Counts] = {}

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Return the board's last counts while the defect is active."""
        if self.defect.boards and board not in self.defect.boards:
            return counts
        if self.active(now) and board in self._last:
            return list(self._last[board])
        self.took(board, counts)
        return counts

    def took(self, board: int, counts: Counts) -> None:
        """Remember the board's last counts."""
        if not self.defect.boards or board in self.defect.boards:
            self._last[board] = list(counts)


class FirmwareReset(Sudden):
    """A reset of the boards: all setpoints are zero, and counters restart from zero."""

    def strike(self, now: float) -> Incident:
        """Restart the boards."""
        self.robot.restart()
        return Incident("boards_restarted")


class ControllerReset(Sudden):
    """A reset of the link's controller; after its set-up all setpoints are zero."""

    def strike(self, now: float) -> Incident:
        """Return the restart, which takes `lasting`."""
        return Incident("controller_restarted", now + self.defect.lasting)


class ControllerHang(Sudden):
    """A controller of the link that neither receives nor sends for a time; motors go on."""

    _until = -math.inf

    def strike(self, now: float) -> Incident:
        """Begin the silence, which lasts forever without `lasting`."""
        self._until = now + (self.defect.lasting or math.inf)
        return Incident("controller_hangs", self._until)

    def frame(self, now: float, board: int, first: int, counts: Counts) -> Counts | None:
        """Lose every frame during the silence."""
        return counts if now >= self._until else None

    def glides_until_s(self, now: float) -> float:
        """Return when it strikes; during the silence frames are lost."""
        return self.due_s if now >= self._until else -math.inf

    def delivery(self, now: float) -> tuple[bool, bool]:
        """Lose every array and echo during the silence."""
        return now >= self._until, now >= self._until


class StrayMotion(Sudden):
    """A motor that moves without a command."""

    def strike(self, now: float) -> Incident:
        """Give one motor a duty."""
        self.robot.twitch(self.rng)
        return Incident("motor_moves")


KINDS: Mapping[str, Callable[[Defect, Electronics, np.random.Generator], ActingDefect]] = {
    "dead_wheel": DeadWheel,
    "stiff_joint": StiffJoint,
    "sensor_stuck": StuckSensor,
    "sensor_drop": StuckSensor,
    "sensor_spike": StuckSensor,
    "zero_jump": ZeroJump,
    "silent_bay": SilentBay,
    "silent_boards": SilentBoards,
    "lost_messages": LostMessages,
    "stale_repeats": StaleRepeats,
    "firmware_reset": FirmwareReset,
    "controller_reset": ControllerReset,
    "controller_hang": ControllerHang,
    "stray_motion": StrayMotion,
}


_ONE_EACH = Hint("; repeat --defect for each", "; each name is an item of its own")


def named(texts: Sequence[str], profile: Profile, seed: int) -> list[AtWork]:
    """Return the defects with these names and numbers, each with its own random numbers.

    A range and the number that :func:`drawn` returns for it make the same defect.

    Args:
        texts: The defects, see :mod:`pirate_sm.core.options`.
        profile: The robot's profile.
        seed: Of their random numbers, and of those with which ranges are drawn.

    Raises:
        UsageError: Some do not exist, or their numbers do not fit; the message has all of them and
            suggests the nearest.
    """
    found = (defect for defect, _ in _read(texts, profile, seed))
    return [(each, np.random.default_rng((seed, number))) for number, each in enumerate(found)]


def drawn(texts: Sequence[str], profile: Profile, seed: int) -> tuple[str, ...]:
    """Return the texts with a number for each range; arguments and errors as of `named`."""
    return tuple(text for _, text in _read(texts, profile, seed))


def _read(texts: Sequence[str], profile: Profile, seed: int) -> list[tuple[Defect, str]]:
    """Return each defect and its text with ranges drawn; arguments and errors as of `named`."""
    defects, names = profile.simulation.defects, [text.partition(":")[0] for text in texts]
    if wrong := unknown("there is no defect", names, defects):
        many = any("," in name for name in names)
        raise UsageError(wrong, hint=_ONE_EACH) if many else UsageError(wrong)
    found, faults = [], []
    for number, (name, text) in enumerate(zip(names, texts, strict=True)):
        rng = np.random.default_rng((seed, number, 1))  # others than those with which it acts
        try:
            found.append(_with_numbers(defects[name], text, profile, rng))
        except UsageError as error:
            faults.append(str(error))
    if faults:
        raise UsageError("\n".join(faults))
    return found


def _with_numbers(
    defect: Defect, text: str, profile: Profile, rng: np.random.Generator
) -> tuple[Defect, str]:
    """Return the defect with the numbers in its text, and the text with ranges drawn."""
    name, numbers = text.partition(":")[0], numbers_of_defect(text, defect.kind)
    scales = _scales(defect, profile) if numbers else {}
    measured = [dimension for _, dimension in scales.values()] or [ANGLE]
    changed: dict[str, Any] = {}
    for key, written in numbers.items():
        try:
            number, numbers[key] = number_of_defect(key, written, measured, rng.uniform)
        except UsageError as error:
            raise UsageError(f"{name}: {key}: {error}") from None
        if DEFECT_KEYS[key].dimension is not None:
            changed[key] = number.value
            continue
        shown = {
            signal: float(round(number.value / scale))
            for signal, (scale, dimension) in scales.items()
            if dimension == number.dimension
        }
        changed["raw"] = {**defect.raw, **shown}
    pairs = ",".join(f"{key}={number}" for key, number in numbers.items())
    return defect.model_copy(update=changed), f"{name}:{pairs}" if pairs else text


def _scales(defect: Defect, profile: Profile) -> dict[str, tuple[float, Dimension]]:
    """Return what a count of each affected signal means in SI units, and its dimension."""
    scales = {}
    for channel in (channel for board in profile.boards for channel in board.channels):
        if channel.convert and channel.signal in (*defect.signals, *defect.raw):
            scale = compile_expression(profile.conversions[channel.convert].scale, Vocabulary({}))
            if isinstance(scale.type, NumberType):
                scales[channel.signal] = scale_of(scale.text), scale.type.dimension
    return scales


def put_to_work(defects: Sequence[AtWork], robot: Electronics) -> tuple[ActingDefect, ...]:
    """Make these defects act on the robot; return them."""
    effects = tuple(KINDS[defect.kind](defect, robot, rng) for defect, rng in defects)
    for effect in effects:
        effect.begin()
    return effects


def numbers_of_defect(text: str, kind: str) -> dict[str, str]:
    """Return the numbers in the text of a defect, as they are written.

    Raises:
        UsageError: One has another form, is given twice, or is not one that the kind takes.
    """
    name, _, rest = text.partition(":")
    numbers: dict[str, str] = {}
    for each in filter(None, rest.split(",")):
        key, given, value = (part.strip() for part in each.partition("="))
        if not given or key in numbers:
            fault = "given twice" if given else f"expected KEY=VALUE, got '{each}'"
            raise UsageError(f"{name}: {key}: {fault}")
        numbers[key] = value
    if wrong := unknown(f"the defect {name} takes no number", numbers, keys_of_defect(kind)):
        raise UsageError(wrong)
    return numbers


def number_of_defect(
    key: str, written: str, measured: Sequence[Dimension], draw: Callable[[float, float], float]
) -> tuple[Quantity, str]:
    """Return a number and its text; for a range one that was drawn from it, to five digits.

    Args:
        key: Its name in ``DEFECT_KEYS``.
        written: The number as it is written, ``2s`` or ``2s..20s``.
        measured: Dimensions of the affected signals, not empty.
        draw: Draws a number from a range.

    Raises:
        UsageError: It has another form or unit, or is out of bounds.
    """
    _, dimension, most = DEFECT_KEYS[key]
    low, dots, high = written.partition("..")
    expected = [dimension] if dimension else measured
    least = _read_number(low, expected)
    largest = _read_number(high, expected) if dots else least
    if dimension and not (least.value >= 0 and largest.value <= most):
        bound = f" and at most {format_quantity(most, dimension)}" if most < math.inf else ""
        raise UsageError(f"expected at least 0{bound}, got '{written}'")
    if largest.value < least.value or largest.dimension != least.dimension:
        raise UsageError(f"expected a range from the smaller to the larger value, got '{written}'")
    if not dots:
        return least, written
    unit = high.strip().lstrip("+-.0123456789eE ")
    shown = f"{draw(least.value, largest.value) / parse_quantity(f'1{unit}').value:.5g}{unit}"
    return _read_number(shown, expected), shown


def _read_number(text: str, dimensions: Sequence[Dimension]) -> Quantity:
    with suppress(QuantityError):
        quantity = parse_quantity(text)
        if quantity.dimension in dimensions:
            return quantity
    return Quantity(read_quantity(text, dimensions[0]), dimensions[0])  # says what is wrong
