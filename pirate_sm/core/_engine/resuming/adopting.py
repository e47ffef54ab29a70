"""List where a robot may be that nobody has recorded, by what its boards show."""

from __future__ import annotations

from pirate_sm.core._engine.resuming.hypotheses import Hypothesis
from pirate_sm.core._engine.resuming.reconciling import Reconciled, VerdictTable
from pirate_sm.core._engine.robot.confirmation import declared_in
from pirate_sm.core._engine.robot.robot_spec import RobotSpec


def adoptable(robot: RobotSpec, declared: int) -> tuple[Hypothesis, ...]:
    """Return the configurations in which a robot may stand, the declared one first.

    Those that drive wheels are left out: wheels that stand show none of them.
    """
    others = (each for each in range(len(robot.table.configurations)) if not robot.driven[each])
    every = dict.fromkeys((declared, *others))
    return tuple(Hypothesis("adopted", declared_in(robot, each)) for each in every)


def shown_instead(robot: RobotSpec, shows: Reconciled) -> tuple[VerdictTable, ...]:
    """Return the configurations that the sensors show instead of the declared one.

    Of those without a contradiction the ones count of which most is confirmed. What the sensors
    cannot tell apart is taken as declared; otherwise a person must choose.

    Args:
        robot: The robot.
        shows: What was seen of the configurations of :func:`adoptable`.

    Returns:
        The configurations. None if nothing contradicts the declared one, if a wheel turns, or if
        everything is contradicted.
    """
    declared = shows.tables[0]
    if shows.turning or not declared.having("contradicted"):
        return ()
    states = robot.table.configurations
    wanted = states[declared.hypothesis.body.configuration]

    def kept(table: VerdictTable) -> int:
        names = states[table.hypothesis.body.configuration]
        return sum(name == other for name, other in zip(names, wanted, strict=True))

    possible = [
        (table.having("confirmed"), kept(table), table)
        for table in shows.tables
        if not table.having("contradicted") and not table.refusals
    ]
    return tuple(
        table
        for shown, count, table in possible
        if not any(shown < other or (shown == other and count < n) for other, n, _ in possible)
    )
