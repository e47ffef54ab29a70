"""Cycles of a chain in a planar pipe in one compiled call."""

from __future__ import annotations

from pirate_sm.simulation.arrays import Floats, Ints, Words
from pirate_sm.simulation.gliding.columns import T_CYCLES
from pirate_sm.simulation.gliding.cycle import goes_on, may_begin, may_pass, passes_on
from pirate_sm.simulation.gliding.standing import stand
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.kernel import advance


@compiled
def glide(
    state: Floats,
    command: Floats,
    wheel_rows: Floats,
    walls: Floats,
    legs: Floats,
    world: Floats,
    quantities: Floats,
    memory: Floats,
    marks: Ints,
    steps: int,
    rolls: Floats,
    arcs: Floats,
    around: Floats,
    turns: Ints,
    sources: Floats,
    counts: Floats,
    rng: Words,
    forced: Floats,
    boards: Ints,
    channels: Floats,
    derived: Floats,
    wheels: Floats,
    own: Floats,
    sensors: Floats,
    robot: Floats,
    slots: Floats,
    conditions: Ints,
    code: Floats,
    origin: Floats,
    duties: Floats,
    watch: Floats,
    clock: Floats,
    signals: Floats,
    fresh: Floats,
    stack: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
    held: Ints,
    surveyed: Floats,
    times_s: Floats,
    reporters: Ints,
    reports: Floats,
    met: Ints,
    ticks: Floats,
    looker: Floats,
    points: Floats,
    bends: Floats,
    seen: Floats,
    looks: Floats,
    values: Floats,
    trail: Floats,
) -> None:
    """Let cycles pass until a frame is not quiet, or time is up.

    The first ten arguments are those of :func:`~pirate_sm.simulation.xpbd.kernel.advance`; the
    others are in :mod:`~pirate_sm.simulation.gliding.groups` and `gliding/columns.py`.
    """
    electronics = sources, counts, rng, forced
    rows = boards, channels, derived, wheels, own, sensors, robot
    task = slots, conditions, code, origin, duties, watch
    posture = chain, parts, body, held, surveyed
    sees = looker, points, bends, seen, looks, values
    taken = times_s, reporters, reports, ticks, met
    centres = state[: 2 * arcs.shape[0]]
    stand(centres, rolls, clock[T_CYCLES], trail)
    while may_begin(arcs, around, rows, task, clock, signals, posture, sees, taken):
        advance(state, command, wheel_rows, walls, legs, world, quantities, memory, marks, steps)
        stand(centres, rolls, clock[T_CYCLES], trail)
        place = quantities, rolls, arcs, around
        scratch = fresh, stack
        if not goes_on(
            place, turns, electronics, rows, task, clock, signals, scratch, posture, taken
        ):
            break


@compiled
def pass_cycles(
    state: Floats,
    command: Floats,
    wheel_rows: Floats,
    walls: Floats,
    legs: Floats,
    world: Floats,
    quantities: Floats,
    memory: Floats,
    marks: Ints,
    steps: int,
    rolls: Floats,
    arcs: Floats,
    around: Floats,
    turns: Ints,
    sources: Floats,
    counts: Floats,
    rng: Words,
    span: Floats,
) -> None:
    """Let cycles pass with the duties in force, until the surroundings act or all have passed.

    The arguments are those of :func:`glide`; `span` is in `gliding/columns.py`.
    """
    place = quantities, rolls, arcs, around
    while may_pass(span, around):
        advance(state, command, wheel_rows, walls, legs, world, quantities, memory, marks, steps)
        if not passes_on(place, turns, sources, counts, rng, span):
            break
