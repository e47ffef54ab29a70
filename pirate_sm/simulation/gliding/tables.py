"""What the engine knows and watches as arrays for compiled code, and back."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from pirate_sm.core.events import Look, WordWatch
from pirate_sm.core.expressions import DEEPEST, Code, depth_of
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import (
    Condition,
    MotorRequest,
    Numbers,
    Row,
    SameDuty,
    Sensing,
    Surveyed,
    Watch,
    environment,
    nothing_known,
    signal_table,
    surveyor,
)
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.electronics import BoardChannels
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.columns import Task

# --- looks ---------------------------------------------------------------------------------------


_MOST_SEEN = 32
_MOST_LOOKS = 64


class LookTables:
    """The tables of a detector.

    Args:
        wheels: How many wheels the robot has.

    Attributes:
        arrays: The arrays, as the arguments of `looking.look` after the first.
    """

    def __init__(self, wheels: int) -> None:
        self._looker: Floats = np.zeros(col.LOOKER_ENTRIES)
        self._seen: Floats = np.zeros((_MOST_SEEN, wheels + 1))
        self._looks: Floats = np.zeros((_MOST_LOOKS, wheels + 1))
        self._work: Floats = np.zeros((4, _MOST_SEEN))
        self._points: Floats = np.zeros((0, 2))
        self._bends: Floats = np.zeros((0, 2))
        self._of: tuple[object, object] = ((), ())

    @property
    def arrays(self) -> tuple[Floats, ...]:
        """Return the arrays, in the order of the arguments of `looking.look`."""
        return (
            *(self._looker, self._points, self._bends),
            *(self._seen, self._looks, self._work),
        )

    def take(self, words: WordWatch | None, watch: Watch) -> bool:
        """Take in what a detector knows; return whether there is room for it.

        Args:
            words: What it knows; None where none is relieved.
            watch: What the engine watches, which has heard the same word or not.
        """
        self._looker[:] = 0.0
        self._looker[col.L_DUE_S] = inf
        if words is None:
            return True
        count = len(words.seen)
        if max(count, len(words.points)) >= _MOST_SEEN:
            return False
        hears = words.name == watch.word and watch.listening_s < inf
        self._looker[:] = (
            *(words.due_s, words.every_s, words.driven, words.direction, words.word),
            *(words.said_s, words.repeat_s, words.valid_for_s if hears else 0.0, count, 0),
        )
        if count:
            self._seen[:count] = words.seen
        if self._of != (words.points, words.bends):
            self._of = words.points, words.bends
            self._points = np.array(words.points, dtype=np.float64).reshape(-1, 2)
            self._bends = np.array(words.bends, dtype=np.float64).reshape(-1, 2)
        return True

    def made(self) -> tuple[list[Look], float]:
        """Return the looks that have been made, and when the next one is due."""
        count = int(self._looker[col.L_LOOKS])
        return self._looks[:count].tolist(), float(self._looker[col.L_DUE_S])


# --- the robot -----------------------------------------------------------------------------------


class RobotTables(NamedTuple):
    """The tables, in the order of the compiled functions' arguments; see `columns.py`."""

    boards: Ints
    rows: Ints
    lists: Ints
    robot: Floats


def robot_tables(robot: RobotSpec, reporting: Sequence[BoardChannels]) -> RobotTables | None:
    """Return the tables of a robot; None if the boards that report are not those it knows."""
    channels = {each.board: each for each in reporting}
    if channels.keys() != robot.boards.keys():
        return None
    specs = sorted(robot.boards.values(), key=lambda each: each.position)
    if any(channels[each.id].last - channels[each.id].first < each.length for each in specs):
        return None
    table, link = signal_table(robot), robot.link
    silent_s = min(link.stale_after_s, link.silent_after_s)
    numbers = link.period_s, silent_s, link.listen_every_s, table.layout.loss
    rows: list[Row] = []
    boards = []
    for board, own in zip(specs, table.boards, strict=True):
        begin, (first, last) = len(rows), channels[board.id][1:3]
        rows += own.whole
        boards.append((begin, begin + len(own.measured), len(rows), first, last - first))
    return RobotTables(
        np.array(boards, dtype=np.int64).reshape(-1, col.BOARD_COLUMNS),
        np.array(rows, dtype=np.int64).reshape(-1, 5),
        np.array(table.lists, dtype=np.int64),
        np.array(numbers, dtype=np.float64),
    )


# --- signals -------------------------------------------------------------------------------------


class SignalTables:
    """The signals of one engine.

    Args:
        robot: The robot.

    Attributes:
        signals: The cells, see ``Layout`` in ``core/_engine/sensing/signal_table.py``.
    """

    def __init__(self, robot: RobotSpec) -> None:
        table = signal_table(robot)
        at = self._layout = table.layout
        self._plausibility = robot.plausibility
        self.signals: Floats = np.array(table.cells(nothing_known(robot)))
        ends = at.heard, at.shares, at.angles, at.motion, at.loss
        self._parts: list[Floats] = np.split(self.signals, ends)[:5]
        self._known: tuple[Numbers, ...] = ((),) * 5
        self._sent: Numbers = ()
        self._out: frozenset[int] = frozenset()

    def take(self, watch: Watch, asked: MotorRequest) -> None:
        """Take the signals in; what has come from here is there already.

        Args:
            watch: With the signals and the setpoints.
            asked: What the motors have been asked when the next frame comes.
        """
        sensing, at, cells = watch.sensing, self._layout, self.signals
        known = sensing.numbers, sensing.heard_s, sensing.shares, sensing.angles, sensing.motion
        for part, now, before in zip(self._parts, known, self._known, strict=True):
            if now is not before:
                part[:] = now
        self._known = known
        sent = *watch.setpoints, *watch.latest
        if sent != self._sent:
            cells[at.force : at.asked] = self._sent = sent
        if sensing.distance.out != self._out:
            self._out = sensing.distance.out
            cells[at.out : at.constants] = [
                place in self._out for place in range(at.constants - at.out)
            ]
        cells[at.loss], cells[at.driving] = sensing.loss, asked.driving
        cells[at.asked] = asked.since_s if asked.setpoints else inf

    def given(
        self, before: Sensing, positions: Sequence[int], asked: MotorRequest, checked_s: float
    ) -> Sensing:
        """Return the signals as the engine has them.

        Args:
            before: The signals that have been taken in.
            positions: The boards whose frames have been taken, one after the other.
            asked: What the motors have been asked.
            checked_s: When silent boards were looked for.
        """
        self._known = tuple([tuple(part.tolist()) for part in self._parts])
        numbers, heard_s, shares, angles, motion = self._known
        return before._replace(
            numbers=numbers,
            heard_s=heard_s,
            shares=shares,
            angles=angles,
            records=before.records_after(positions, self._plausibility),
            motion=motion,
            loss=float(self.signals[self._layout.loss]),
            asked=asked,
            checked_s=checked_s,
        )


# --- the survey ----------------------------------------------------------------------------------


class SurveyTables:
    """The tables of a robot and of its survey.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        chain, parts, imu = robot.body.rows
        self._body = (
            np.array(chain, dtype=np.float64).reshape(-1, 3),
            np.array(parts, dtype=np.float64).reshape(-1, 6),
            np.array(imu, dtype=np.int64),
        )
        self._memory: Floats = np.zeros((2, surveyor.MARKS + surveyor.PER_PART * len(parts)))
        self._of: Watch | None = None
        self._last: Surveyed | None = None
        self._due_s = inf

    @property
    def arrays(self) -> tuple[Floats | Ints, ...]:
        """Return the arrays, in the order of the arguments of `surveyor.survey`."""
        return *self._body, self._memory

    def take(self, watch: Watch) -> None:
        """Take in what the survey remembers; what has come from here is there already."""
        surveyed, before, own = watch.surveyed, self._of, self._memory[0]
        if before is None or surveyed is not self._last or watch.held is not before.held:
            own[:] = environment.memory_of(
                self._robot, surveyed, watch.held, watch.in_bend, watch.word
            )
            self._last = surveyed
        own[surveyor.DUE_S] = self._due_s = surveyed.due_s
        own[surveyor.IN_BEND], own[surveyor.WORD] = watch.in_bend, watch.word is not None
        self._of = watch

    def given(self) -> Surveyed:
        """Return what the survey remembers now."""
        assert self._last is not None  # it has been taken in before
        memory: list[float] = self._memory[0].tolist()
        if memory[surveyor.DUE_S] != self._due_s:
            self._last = environment.remembered(self._last, memory)
        return self._last


# --- what is watched -----------------------------------------------------------------------------


class CodePool:
    """The codes of conditions, one after the other; each is stored once.

    Attributes:
        code: `(instructions, 2)`; longer than what is used.
    """

    def __init__(self) -> None:
        self.code: Floats = np.zeros((256, 2))
        self._used = 0
        self._places: dict[Code, tuple[int, int]] = {}
        self._seen: dict[int, tuple[Code, tuple[int, int] | None]] = {}

    def place(self, code: Code) -> tuple[int, int] | None:
        """Return where the code begins and ends; None if the machine is not deep enough for it."""
        known = self._seen.get(id(code))
        if known is None:  # the code is kept with it, so that its id stays its own
            known = self._seen[id(code)] = code, self._store(code)
        return known[1]

    def _store(self, code: Code) -> tuple[int, int] | None:
        if code in self._places:
            return self._places[code]
        if depth_of(code) > DEEPEST:
            return None
        begin, end = self._used, self._used + len(code)
        while end > len(self.code):
            self.code = np.concatenate([self.code, np.zeros_like(self.code)])
        self.code[begin:end] = code
        self._used = end
        self._places[code] = begin, end
        return begin, end


class WatchTables:
    """The tables of a watch.

    Args:
        numbers: How many signals the robot has.

    Attributes:
        conditions: See `columns.py`; so for `duties` and `watch`.
        origin: Signals when the wait began.
    """

    def __init__(self, numbers: int) -> None:
        self.pool = CodePool()
        self.conditions: Ints = np.zeros((0, 4), dtype=np.int64)
        self.origin: Floats = np.full(numbers, np.nan)
        self.duties: Floats = np.zeros((0, 8))
        self.watch: Floats = np.zeros(5)
        self._rules: dict[int, tuple[tuple[Condition, ...], Ints | None]] = {}
        self._of: Watch | None = None
        self._possible = False

    @property
    def arrays(self) -> Task:
        """Return the arrays, as compiled functions take them."""
        return self.conditions, self.pool.code, self.origin, self.duties, self.watch

    def take(self, watch: Watch, until_s: float) -> bool:
        """Take a watch in; return whether the machine can keep it.

        Args:
            watch: What is watched.
            until_s: When time stops.
        """
        before = self._of
        self.watch[col.A_UNTIL_S] = until_s
        self.watch[col.A_FRAMES_S] = watch.frames_until_s - col.TOLERANCE_S
        self.watch[col.A_ALARM_S] = watch.alarm_s
        self.watch[col.A_DEADLINE_S] = watch.deadline_s
        self.watch[col.A_OUTSIDE_S] = watch.surveyed.merged_until_s
        if (
            before is None
            or watch.rules is not before.rules
            or watch.conditions != before.conditions
        ):
            self._take_conditions(watch)
        if before is None or watch.duties is not before.duties:
            self._take_duties(watch.duties)
        if watch.origin and (before is None or watch.origin is not before.origin):
            self.origin[:] = watch.origin
        self._of = watch
        return self._possible

    def _take_conditions(self, watch: Watch) -> None:
        key = id(watch.rules)
        if key not in self._rules:  # they are kept with it, so that their id stays their own
            self._rules[key] = watch.rules, self._rows(watch.rules)
        rules, others = self._rules[key][1], self._rows(watch.conditions)
        self._possible = rules is not None and others is not None
        if rules is not None and others is not None:
            self.conditions = np.concatenate([rules, others])

    def _rows(self, conditions: tuple[Condition, ...]) -> Ints | None:
        """Return conditions as rows; None if the machine is not deep enough for one."""
        places = [self.pool.place(code) for code, _, _ in conditions]
        rows = [
            (*place, holds, boards)
            for place, (_, holds, boards) in zip(places, conditions, strict=True)
            if place is not None
        ]
        if len(rows) < len(conditions):
            return None
        return np.array(rows, dtype=np.int64).reshape(-1, 4)

    def _take_duties(self, duties: Iterable[SameDuty]) -> None:
        self.duties = np.array(list(duties), dtype=np.float64).reshape(-1, 8)
