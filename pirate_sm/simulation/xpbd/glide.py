"""Cycles of a chain in a planar pipe in one compiled call."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats, Ints, Words
from pirate_sm.simulation.gliding import groups
from pirate_sm.simulation.gliding.columns import T_CYCLES
from pirate_sm.simulation.gliding.cycle import goes_on, may_begin, may_pass, passes_on
from pirate_sm.simulation.gliding.standing import note_places
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.kernel import Bars, advance


@compiled
def glide(
    chain: Bars,
    centres: Floats,
    place: groups.Place,
    turns: Ints,
    electronics: groups.Electronics,
    rows: groups.RobotRows,
    task: groups.Task,
    clock: Floats,
    signals: Floats,
    scratch: groups.Scratch,
    posture: groups.Posture,
    sees: groups.Looker,
    taken: groups.Taken,
    trail: Floats,
) -> None:
    """Let cycles pass until a frame is not quiet, or time is up.

    Args:
        chain: The arguments of :func:`~pirate_sm.simulation.xpbd.kernel.advance`.
        centres: Those of the wheels, in the state of the chain.
        place: See `groups.py`; so for the other groups.
        turns: See `columns.py`; so for `clock` and `signals`.
        electronics: The boards.
        rows: The robot.
        task: What is watched.
        clock: Changed.
        signals: Changed with each quiet frame.
        scratch: See `goes_on`.
        posture: For the survey of the pipe.
        sees: What a detector looks at.
        taken: Frames are added.
        trail: Where the robot was after each cycle.
    """
    _, rolls, arcs, around = place
    note_places(centres, rolls, clock[T_CYCLES], trail)
    while may_begin(arcs, around, rows, task, clock, signals, posture, sees, taken):
        advance(*chain)
        note_places(centres, rolls, clock[T_CYCLES], trail)
        if not goes_on(
            place, turns, electronics, rows, task, clock, signals, scratch, posture, taken
        ):
            break


@compiled
def pass_cycles(
    chain: Bars,
    place: groups.Place,
    turns: Ints,
    sources: Floats,
    counts: Floats,
    rng: Words,
    span: Floats,
) -> None:
    """Let cycles pass with the duties in force, until the surroundings act or all have passed.

    The chain is that of :func:`glide`; the others are the arguments of `passes_on`.
    """
    _, _, _, around = place
    while may_pass(span, around):
        advance(*chain)
        if not passes_on(place, turns, sources, counts, rng, span):
            break
