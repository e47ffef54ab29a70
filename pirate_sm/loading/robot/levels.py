"""Check what a robot needs to bring a part to an angle against the horizontal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pirate_sm.engine.robot.chart_table import ChartTable
from pirate_sm.engine.robot.command_spec import CommandSpec, SlotSpec, StageSpec
from pirate_sm.engine.robot.criteria import AlignedSpec
from pirate_sm.loading.problems import Path, Problems
from pirate_sm.loading.robot.body_chain import resolve_chain
from pirate_sm.loading.robot.signals import Signals


def levels(slot: SlotSpec, signals: Signals, path: Path) -> bool:
    """Return whether a slot can level a part; report one that cannot.

    It turns a roll joint, ahead of which an accelerometer sits.
    """
    imu = resolve_chain(signals).imu
    if slot.unit == "angle" and imu is not None and slot.angle >= 0 and imu.roll == slot.angle:
        return True
    message = (
        f"'{slot.name}' cannot level a part: that takes a slot with `unit: angle` that turns a"
        " roll joint, and on that joint's link the accelerometer of a derived signal"
        " `roll_of` or `pitch_of`"
    )
    signals.problems.add("robot.setpoint", path, message)
    return False


def check_levelled(
    table: ChartTable,
    actuation: Sequence[Mapping[str, tuple[StageSpec, ...]]],
    commands: Sequence[CommandSpec],
    problems: Problems,
) -> None:
    """Report commands that lead to a levelled state and are not done by its angle."""
    for number, spec in enumerate(commands):
        slots = {slot for slot, _ in spec.done.slots} if isinstance(spec.done, AlignedSpec) else {}
        levelled = {*_levelled(table, actuation, number)}
        if not levelled <= {*slots}:
            message = (
                f"{spec.name} levels a part, so its criterion must be `kind: aligned` with the"
                " slot that turns it"
            )
            problems.add("robot.criterion", ("commands", spec.name, "done"), message)


def _levelled(
    table: ChartTable,
    actuation: Sequence[Mapping[str, tuple[StageSpec, ...]]],
    command: int,
) -> Iterator[int]:
    """Yield the slots that are levelled in the states that the command enters."""
    for here, states in enumerate(table.configurations):
        after = table.configurations[table.follow(here, command)]
        for region, (old, new) in enumerate(zip(states, after, strict=True)):
            for stage in actuation[region][new] if new != old else ():
                yield from (write.slot for write in stage if write.how == "level")
