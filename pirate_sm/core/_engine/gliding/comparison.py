"""What frames must leave as it is while declared states are compared with sensors.

That is what :func:`~pirate_sm.core._engine.robot.evidence.verdict` says of each mark. Where a
sensor may contradict a state every frame goes through the engine, which says what is seen. So what
contradicts need not be exact here, but must be true whenever it is there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import lru_cache
from math import inf, isnan

from pirate_sm.core._engine.gliding.quiet_frames import ANY_BOARD, Condition
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import HeldSpec, SeenSpec
from pirate_sm.core._engine.robot.declared_states import Look, Watched, lapsed_in
from pirate_sm.core._engine.robot.evidence import others_that_hold, spec_of
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import Mark, RobotState, states_of
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._expressions import tree
from pirate_sm.core._expressions.compiler import Code, code_of


def compared(
    robot: RobotSpec, state: EngineState, diameter_m: float | None
) -> list[Condition] | None:
    """Return under which conditions the comparisons under way stay as they are.

    Args:
        robot: The robot.
        state: The engine's state.
        diameter_m: Inner diameter of the pipe; None where it is unknown.

    Returns:
        The conditions; None where every frame must go through the engine.
    """
    look, lapsed = state.look, state.lapsed
    unseen = () if lapsed is None else tuple(each.mark for each in lapsed.marks)
    if unseen != lapsed_in(state.robot.marks) or look is not state.looking:
        return None
    if look is not None and look.before is not None:
        return None
    if lapsed is not None and any(not isnan(each.agrees_s) for each in lapsed.marks):
        return None  # no deadline says when that has lasted for long enough
    found: list[Condition] = []
    for some in filter(None, (look, lapsed)):
        for each in some.marks:
            agrees, *others = _undecided(robot, state.robot, some, each, diameter_m)
            found += (agrees, *others) if some is look else (agrees,)
            if each.told:
                return None
    return found


def _undecided(
    robot: RobotSpec, body: RobotState, look: Look, each: Watched, diameter_m: float | None
) -> Iterator[Condition]:
    """Yield that a mark shows itself as before, and that nothing contradicts it."""
    agrees, firmly, against = codes_of(
        robot, body.configuration, each.mark, look.setpoints, diameter_m
    )
    holds, spec = not isnan(each.agrees_s), spec_of(robot, states_of(robot, body), each.mark)
    yield Condition(agrees, holds, ANY_BOARD)
    yield Condition(against, False, ANY_BOARD)
    if holds and isinstance(spec, HeldSpec):
        yield Condition(firmly, each.for_s == spec.for_s, ANY_BOARD)


@lru_cache(maxsize=1024)
def codes_of(
    robot: RobotSpec,
    configuration: int,
    mark: Mark,
    setpoints: Numbers,
    diameter_m: float | None,
) -> tuple[Code, Code, Code]:
    """Return the codes of what shows a mark, of a firm grip, and of what may contradict it."""
    spec = spec_of(robot, robot.table.configurations[configuration], mark)
    agrees: tree.Node = tree.TruthValue(False)
    firmly: tree.Node = tree.TruthValue(True)
    against: list[tree.Node] = []
    if isinstance(spec, HeldSpec):
        others = others_that_hold(robot, configuration, spec)
        agrees, firmly, off = _held(spec, setpoints, others, diameter_m)
        against.append(off)
    elif spec is not None:
        if spec.needs is not None:
            agrees = tree.And(tuple(need.condition for need in spec.needs))
        against += [tree.Not(sign.bound.condition) for sign in spec.signs]
    if mark.kind == "region" and not robot.held[configuration]:
        against += [
            _may_grip(part, spec)
            for which, part in enumerate(robot.sight.parts)
            if part is not None and mark.which in robot.part_regions[which]
        ]
    return code_of(agrees), code_of(firmly), code_of(tree.Or(tuple(against)))


def _held(
    spec: HeldSpec, setpoints: Numbers, others: list[int], diameter_m: float | None
) -> tuple[tree.Node, tree.Node, tree.Node]:
    """Return that a part holds, that it bears all that it should, and that it may not hold."""
    borne: list[tree.Node] = []
    for joint in spec.joints:
        torque, way = _signal(joint.torque), setpoints[joint.slot]
        borne.append(torque if way > 0 else tree.Negate(torque) if way < 0 else _size(torque))
    pairs = list(zip(borne, spec.joints, strict=True))
    firmly = _all(tree.Compare(">=", nm, tree.Number(joint.needed_nm)) for nm, joint in pairs)
    weakly = _all(tree.Compare(">=", nm, tree.Number(joint.least_nm)) for nm, joint in pairs)
    slack = _all(tree.Compare("<", nm, tree.Number(spec.slack)) for nm in borne)
    shown, opened = _signal(spec.diameter), _reaches(spec.apex, spec.open_rad)
    known = [tree.Number(diameter_m)] if diameter_m is not None else [*map(_signal, others)]
    off = [tree.Arithmetic("/", _size(tree.Arithmetic("-", shown, it)), it) for it in known]
    near = _all(tree.Compare("<=", each, tree.Number(spec.span)) for each in off)
    far = tuple(tree.Compare(">", each, tree.Number(spec.span_off)) for each in off)
    loaded = tree.Or((firmly, weakly)) if spec.settled_s < inf else firmly
    agrees = _all((loaded, _still(spec), tree.Known(shown), tree.Not(opened), near))
    return agrees, firmly, tree.Or((opened, *far, slack))


def _may_grip(spec: HeldSpec, declared: SeenSpec | HeldSpec | None) -> tree.Node:
    """Return that a part may hold which is not declared to."""
    clamps = _all(_reaches(joint.torque, joint.needed_nm) for joint in spec.joints)
    presses = tree.Or(tuple(_reaches(joint.torque, spec.slack) for joint in spec.joints))
    needs = declared.needs if isinstance(declared, SeenSpec) else None
    at_rest = tuple(
        tree.And((tree.Known(_signal(spec.apex)), bound.condition))
        for need in needs or ()
        for bound in need.lacking
        if bound.signal == spec.apex
    )
    grips = tree.And((presses, tree.Not(tree.Or(at_rest))))
    return tree.And((_still(spec), tree.Or((clamps, grips))))


def _still(spec: HeldSpec) -> tree.Node:
    limit = tree.Number(spec.still)
    return _all(tree.Compare("<", _size(_signal(it.rate)), limit) for it in spec.joints)


def _reaches(signal: int, limit: float) -> tree.Node:
    """Return that the magnitude of a signal is known and at least this."""
    size = _size(_signal(signal))
    return tree.And((tree.Known(size), tree.Compare(">=", size, tree.Number(limit))))


def _signal(index: int) -> tree.Node:
    return tree.Signal("", "number", index)


def _size(node: tree.Node) -> tree.Node:
    return tree.Call("abs", (node,))


def _all(parts: Iterable[tree.Node]) -> tree.Node:
    return tree.And(tuple(parts))
