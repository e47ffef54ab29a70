"""Conditions of a robot and of its mission as code, each compiled once for the words it meets."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

from pirate_sm.core._engine.gliding.watch import Condition
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._expressions import Expression
from pirate_sm.core._expressions.bytecode import Code, code_of, never_true, words_in

Words = Sequence[str | None]

ANY_BOARD = -1
"""Instead of boards: every one."""


@lru_cache(maxsize=16)
def codes_of(robot: RobotSpec) -> Codes:
    """Return the codes of a robot, which all engines that run it share."""
    return Codes(robot)


class Codes:
    """Compiles the fault rules of a robot and the triggers of its missions.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        self._known: dict[tuple[int, Words], Code] = {}
        self._read: dict[int, tuple[Expression, tuple[int, ...]]] = {}
        self._rules: dict[tuple[Words, Sequence[bool]], tuple[Condition, ...]] = {}
        trees = [rule.when.tree for rule in robot.faults]
        self._tested = sorted({index for tree in trees for index in words_in(tree)})
        self._boards = [0] * len(robot.faults)
        for board in robot.boards.values():
            for rule in board.faults:
                self._boards[rule] |= 1 << board.position

    def rules(self, words: Words, holding: Sequence[bool]) -> tuple[Condition, ...]:
        """Return the fault rules as conditions, without those that cannot become true.

        Args:
            words: What the signals with words are.
            holding: Per rule whether it is true.
        """
        key = tuple([words[index] for index in self._tested]), tuple(holding)
        found = self._rules.get(key)
        if found is None:
            pairs = zip(self._robot.faults, holding, self._boards, strict=True)
            rows = [self._condition(rule.when, words, holds, of) for rule, holds, of in pairs]
            found = self._rules[key] = tuple(each for row in rows for each in row)
        return found

    def trigger(self, condition: Expression, words: Words, holds: bool) -> tuple[Condition, ...]:
        """Return the condition of a trigger; nothing if it cannot become true."""
        return self._condition(condition, words, holds, ANY_BOARD)

    def _condition(
        self, expression: Expression, words: Words, holds: bool, boards: int
    ) -> tuple[Condition, ...]:
        code = self._code(expression, words)
        return () if not holds and never_true(code) else (Condition(code, holds, boards),)

    def _code(self, expression: Expression, words: Words) -> Code:
        own = id(expression)
        if own not in self._read:  # the expression is kept with it, so that its id stays its own
            self._read[own] = expression, words_in(expression.tree)
        seen = tuple([words[index] for index in self._read[own][1]])
        code = self._known.get((own, seen))
        if code is None:
            code = self._known[own, seen] = code_of(expression.tree, words)
        return code
