"""What the engine watches, as arrays for compiled code; rewritten only where it has changed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pirate_sm.core.expressions import DEEPEST, Code, depth_of
from pirate_sm.core.sensing import Condition, SameDuty, Watch
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.groups import Task


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
        self.watch: Floats = np.zeros(4)
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
