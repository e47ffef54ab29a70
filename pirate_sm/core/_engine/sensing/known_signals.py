"""The known signals of a robot, their changes since a wait began, and what is remembered of them.

Slip is that of a wheel against a speed of the body that was measured over other stretches of time.
A wheel's speed is a mean between two frames, that of the body a mean over what the source outside
averages. While the robot starts or stops the two differ without any slip. What is compared are
therefore the readings that end between two frames of the wheel with the wheel's speeds in all
the time that those readings are made of: a wheel that rolls has had the body's speed among them.
Frames come up to a delay after the motion that they report.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan, nan
from statistics import fmean
from typing import NamedTuple

from pirate_sm.core._engine.records import Numbers, often_replaced
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing import plausibility
from pirate_sm.core._engine.sensing.board_spec import PlausibilitySpec, TractionSpec
from pirate_sm.core._engine.sensing.evaluator import UNMOVED
from pirate_sm.core._engine.sensing.plausibility import BoardMemory

# --- slip of wheels ---------------------------------------------------------------------------


KEPT_S = 1.0
"""Older stretches are forgotten: boards and sources outside are unknown after less [decided]."""

CHANGING_M_S = 0.010
"""Rim speeds that differ by more belong to a wheel that starts or stops; as much as wheels may
differ that agree (design: 10 mm/s)."""


class Stretch(NamedTuple):
    """A mean speed over some time; at one moment, where both times are equal."""

    since_s: float
    until_s: float
    m_s: float


class Slip(NamedTuple):
    """How fast a wheel slips.

    Attributes:
        slip_m_s: Speed of the rim less that of the body; NaN is unknown.
        body_m_s: The speed of the body that this was made with.
    """

    slip_m_s: float = nan
    body_m_s: float = nan


def lengthened(
    stretches: tuple[Stretch, ...], m_s: float, now_s: float, since_s: float = -inf
) -> tuple[Stretch, ...]:
    """Return the stretches with one more, which ends now; none after an unknown speed.

    Args:
        stretches: Oldest first.
        m_s: The mean speed.
        now_s: When it was reported.
        since_s: When it begins; by default where the last one ends.
    """
    if isnan(m_s):
        return ()
    if since_s == -inf:
        since_s = stretches[-1].until_s if stretches else now_s
    kept = tuple([each for each in stretches if each.until_s >= now_s - KEPT_S])
    return (*kept, Stretch(since_s, now_s, m_s))


def slip_between(rims: tuple[Stretch, ...], readings: tuple[Stretch, ...], delay_s: float) -> Slip:
    """Return how fast a wheel slips.

    While its speed changes slip is the least that explains the difference, and unknown where none
    is needed.

    Args:
        rims: The wheel's rim speeds from frame to frame.
        readings: The speeds of the body, oldest first.
        delay_s: By how much a frame may be later than a reading of the same moment.
    """
    heard = [each for each in readings if rims and each.until_s <= rims[-1].until_s - delay_s]
    if not heard:
        return Slip()
    newest_s = heard[-1].until_s
    frame = next((each for each in reversed(rims) if each.since_s <= newest_s), rims[0])
    used = [each for each in heard if each.until_s >= frame.since_s - delay_s] or heard[-1:]
    since_s, until_s = used[0].since_s, used[-1].until_s + delay_s
    speeds = [e.m_s for e in rims if e.until_s >= since_s and e.since_s <= until_s] or [frame.m_s]
    body_m_s, slowest, fastest = fmean([e.m_s for e in used]), min(speeds), max(speeds)
    if fastest - slowest <= CHANGING_M_S:
        return Slip(fmean(speeds) - body_m_s, body_m_s)
    if slowest <= body_m_s <= fastest:
        return Slip(nan, body_m_s)
    return Slip((slowest if body_m_s < slowest else fastest) - body_m_s, body_m_s)


class Slipping(NamedTuple):
    """What is remembered of a wheel that slips.

    Attributes:
        since_s: Since when it slips the way that it is driven; infinite while it does not.
        seen_s: When it was last seen to do so.
        force_normal: Sum of force times normal force, N^2.
        normal_squared: Sum of the squared normal force, N^2.
    """

    since_s: float = inf
    seen_s: float = -inf
    force_normal: float = 0.0
    normal_squared: float = 0.0


class Traction(NamedTuple):
    """What is remembered of the wheels' traction.

    Attributes:
        slipping: Per wheel.
        rims: Per wheel the speeds of its rim lately, from frame to frame.
        readings: The speeds of the body that were measured outside lately.
    """

    slipping: tuple[Slipping, ...] = ()
    rims: tuple[tuple[Stretch, ...], ...] = ()
    readings: tuple[Stretch, ...] = ()


def nothing_estimated(spec: TractionSpec | None) -> Traction:
    """Return what is known before the first frame."""
    if spec is None:
        return Traction()
    return Traction((Slipping(),) * len(spec.wheels), ((),) * len(spec.wheels))


# --- everything that is known -----------------------------------------------------------------


class MotorRequest(NamedTuple):
    """The array last sent to the motors.

    Attributes:
        setpoints: The array; empty before the first.
        since_s: When it was sent.
        driving: Whether a wheel is driven.
    """

    setpoints: Numbers = ()
    since_s: float = inf
    driving: bool = False


class DistanceMemory(NamedTuple):
    """What is remembered of the way that odometry counts, to judge it; see :mod:`.odometry`.

    Attributes:
        every_s: How often it is judged; ``due_s``: when next; ``at_s``: when it was last.
        running: Whether the robot drives, or has not reported the rest of its way yet.
        begun_s: Since when its wheels are driven in these directions, ``turns``: 1, 0 or -1.
        angles: Per wheel what its sensor showed then; ``joints``: what those of the joints showed.
        paces_m_s: Per wheel how fast it rolled when that was known last.
        strayed_m: Per wheel how far it is from the others lately; NaN while it does not count.
        odd_s: Per wheel since when it is limp, or turns with the others again; infinite otherwise.
        out: Places of the wheels that are not believed.
        width_m: How far the robot may be from the odometry where all wheels have just reported.
        apart_m: What most wheels have rolled less the mean of all, while these do not slip.
        late_m: How far it may have driven since its wheels reported, and how far ``apart_m`` is.
        rolled_m: How far it has driven, back and forth.
        sliding_m_s: How fast it may be sliding down a slope.
        pitch_rad: By how much the pipe climbs where that was known last.
        spanned: Whether a clamped part has spanned the pipe where the run began.
        pending_m: How far it may have slipped since it starts or ends, if what follows confirms it.
        slipped: Whether its wheels may have slipped when they were judged last.
    """

    every_s: float = 0.0
    due_s: float = inf
    at_s: float = -inf
    running: bool = False
    begun_s: float = -inf
    turns: tuple[int, ...] = ()
    angles: Numbers = ()
    joints: Numbers = ()
    paces_m_s: Numbers = ()
    strayed_m: Numbers = ()
    odd_s: Numbers = ()
    out: frozenset[int] = frozenset()
    width_m: float = 0.0
    apart_m: float = 0.0
    late_m: float = 0.0
    rolled_m: float = 0.0
    sliding_m_s: float = 0.0
    pitch_rad: float = nan
    pending_m: float = 0.0
    spanned: bool = False
    slipped: bool = False

    @property
    def bound_m(self) -> float:
        """Return how far the robot may be from the odometry."""
        return self.width_m + self.late_m


@often_replaced
class Sensing(NamedTuple):
    """Everything known from sensors.

    Attributes:
        numbers: Signals in the order of the vocabulary, SI; NaN is unknown.
        heard_s: Per board when it last reported; -inf before it ever did.
        checked_s: When staleness was last looked at.
        stale: Boards whose signals have been forgotten.
        shares: Per wheel its share of the odometry when its board last reported; 0 when the wheel
            was not driven then. A wheel that has just been stopped still brings in what it
            rolled until then.
        angles: Per wheel what its sensor last showed, however long ago: what it has rolled while
            its board could not be heard is not lost with the frames.
        records: Per board what is remembered of its sensors, to know which values to believe.
        asked: What the motors have been asked, which tells what can move.
        loss: Share of the boards' reports that is lost, lately.
        motion: Per sensor of a motion what is remembered to compare it with what was asked, one
            after the other, see :data:`pirate_sm.core._engine.sensing.evaluator.UNMOVED`.
        told: Instead of ``numbers``, what a script says that conditions see; empty without one.
            Changes of signals may follow, see :func:`with_changes`.
        traction: What is remembered of the wheels' slip and normal forces.
        outside_until_s: Per outside signal that is known its number index, and until when it
            counts.
        adrift: Number indexes of signals of which only changes are known: what they count from
            is not known any more. Conditions see them as unknown.
        connection: Counts the connections to the robot in this run. Each return of its controller
            begins the next one, and what was known before is no evidence in it.
        distance: What is remembered to judge the odometry.
    """

    numbers: Numbers
    heard_s: tuple[float, ...]
    checked_s: float = 0.0
    stale: frozenset[int] = frozenset()
    shares: tuple[float, ...] = ()
    angles: tuple[float, ...] = ()
    records: tuple[BoardMemory, ...] = ()
    asked: MotorRequest = MotorRequest()
    loss: float = 0.0
    motion: Numbers = ()
    told: Numbers = ()
    traction: Traction = Traction()
    outside_until_s: tuple[tuple[int, float], ...] = ()
    adrift: frozenset[int] = frozenset()
    connection: int = 0
    distance: DistanceMemory = DistanceMemory()

    @property
    def counted(self) -> Numbers:
        """Return the signals from which changes are counted, as :attr:`shown` otherwise."""
        return self.told[: len(self.numbers)] or self.numbers

    @property
    def shown(self) -> Numbers:
        """Return the signals that conditions of the mission see; loops use those of the boards."""
        if not self.adrift:  # asked at every frame
            return self.told[: len(self.numbers)] or self.numbers
        return tuple(nan if at in self.adrift else now for at, now in enumerate(self.counted))

    @property
    def sees_slip(self) -> bool:
        """Return whether slip may be known, by a speed from outside or by what is remembered."""
        if self.outside_until_s:
            return True
        return any(each.since_s < inf for each in self.traction.slipping)

    @property
    def doubted(self) -> frozenset[int]:
        """Return the number indexes that depend on a sensor whose last reading is implausible.

        Such a number is NaN. During the first few readings it is the last plausible value, because
        the sensor may only have spiked.
        """
        return frozenset().union(*[record.doubted for record in self.records])

    def records_after(
        self, positions: Sequence[int], spec: PlausibilitySpec
    ) -> tuple[BoardMemory, ...]:
        """Return the records after frames of these boards in which every limit was kept."""
        if all(record.seen > spec.hold_back for record in self.records):
            return self.records
        return tuple(
            record.after(positions.count(at), spec) for at, record in enumerate(self.records)
        )


def with_changes(sensing: Sensing, origin: Numbers) -> Numbers:
    """Return the signals, followed by the change of each signal since a wait began.

    Args:
        sensing: The signals now.
        origin: The signals when the wait began. A change is NaN if the signal is unknown now or
            was unknown then.
    """
    shown, counted = sensing.shown, sensing.counted
    if len(sensing.told) > len(shown):  # a script gives the changes too
        return sensing.told
    return (*shown, *(now - then for now, then in zip(counted, origin, strict=True)))


def nothing_known(robot: RobotSpec, *, blind: bool = False) -> Sensing:
    """Return unknown signals; the odometry starts at zero, or unknown if ``blind``."""
    numbers = [nan] * len(robot.vocabulary.numbers)
    if robot.odometry >= 0 and not blind:
        numbers[robot.odometry] = 0.0
    count = len(robot.wheels)
    return Sensing(
        tuple(numbers),
        (-inf,) * len(robot.boards),
        shares=(0.0,) * count,
        angles=(nan,) * count,
        records=tuple(plausibility.unseen(board.watched) for board in robot.boards.values()),
        motion=UNMOVED * sum(len(board.watched.moving) for board in robot.boards.values()),
        traction=nothing_estimated(robot.traction),
    )


def with_odometry(robot: RobotSpec, sensing: Sensing, way_m: float, *, adrift: bool) -> Sensing:
    """Return the signals with odometry that goes on from a value.

    Args:
        robot: A robot with odometry.
        sensing: The signals.
        way_m: The value.
        adrift: Whether it is not known, so that only changes count from now on.
    """
    numbers = list(sensing.numbers)
    numbers[robot.odometry] = way_m
    unknown = sensing.adrift | {robot.odometry, robot.bound} if adrift else sensing.adrift
    return sensing._replace(numbers=tuple(numbers), adrift=unknown)
