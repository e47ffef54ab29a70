"""Rules about wheels and joints: consistent directions, pressing and confirmed clamps."""

from __future__ import annotations

from collections.abc import Iterator
from math import copysign

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.robot.robot_view import RobotView, StateWrite
from pirate_sm.core.robot import TorqueBorne


def _apexes(view: RobotView) -> Iterator[tuple[int, int, int]]:
    """Yield for each part its index, the slot of its apex and the index of its apex wheel."""
    body = view.profile.body
    wheels = [wheel.name for wheel in body.wheels]
    for number, name in enumerate(view.loaded.normal.parts):
        apex = body.parts[name].apex
        joint = next(each for each in body.joints if each.name == apex)
        for slot, each in enumerate(view.profile.slots):
            if each.joint == apex:
                yield number, slot, wheels.index(joint.wheel)


def wheel_directions(view: RobotView) -> Iterator[Finding]:
    """Yield wrong directions; if there are none, states that press or drive the wrong way."""
    crossed = list(_directions(view))
    yield from crossed
    if not crossed:  # a wrong direction would cause all of these
        yield from _sides(view)
        yield from _fights(view)
        yield from _slack(view)


def _directions(view: RobotView) -> Iterator[Finding]:
    """Yield adjacent wheels of a V that do not touch opposite walls."""
    wheels = view.profile.body.wheels
    said: set[int] = set()
    for _, _, apex in _apexes(view):
        for other in (apex - 1, apex + 1):
            if wheels[other].part != wheels[apex].part or other in said:
                continue
            if wheels[other].direction == wheels[apex].direction:
                said.add(other)
                message = (
                    f"'{wheels[other].name}' and '{wheels[apex].name}', the apex beside it, touch"
                    " opposite walls: their directions cannot be equal"
                )
                yield view.at(("body", "wheels", other, "direction"), "robot.direction", message)


def mirrored_slots(view: RobotView) -> Iterator[Finding]:
    """Yield slots that keep their sign in mirrored polarity while others change it."""
    moving = [(slot, path) for slot, path in view.slots if slot.joint or slot.wheel]
    mirrored = [slot for slot, _ in moving if slot.mirrors]
    for slot, path in moving:
        if mirrored and not slot.mirrors:
            message = (
                f"'{slot.name}' keeps its sign in mirrored polarity, '{mirrored[0].name}' changes"
                " it: they work against each other there"
            )
            yield view.at(
                (*path, "mirrors" if "mirrors" in slot.model_fields_set else "name"),
                "robot.mirrors",
                message,
            )


def _holding(view: RobotView, part: int, each: StateWrite) -> bool:
    """Return whether the part is held whenever the state of this write is active."""
    robot = view.loaded.normal
    seen = [
        part in held
        for held, states in zip(robot.held, robot.table.configurations, strict=True)
        if states[each.region] == each.state
    ]
    return bool(seen) and all(seen)


def _sides(view: RobotView) -> Iterator[Finding]:
    """Yield clamps that push their apex away from the wall given by its wheel's direction.

    A negative angle turns the body on both sides of a joint towards side A, so a negative duty
    cycle pushes the apex to side B, where wheels have the direction -1.
    """
    for part, slot, apex in _apexes(view):
        direction = view.profile.body.wheels[apex].direction
        name = view.profile.body.wheels[apex].name
        reported: set[tuple[int, str]] = set()  # a control turns a motor the same way as usual
        for each in view.written:
            value, state = each.write.value, (each.region, each.state)
            if each.write.slot != slot or not each.write.turns or state in reported:
                continue
            if copysign(1, value) != direction and _holding(view, part, each):
                reported.add(state)
                side = "A" if value > 0 else "B"
                message = (
                    f"this presses '{name}' to side {side}, and its direction of {direction}"
                    " stands for the other side"
                )
                yield view.at(each.path, "robot.clamp_side", message)


def _slack(view: RobotView) -> Iterator[Finding]:
    """Yield states in which a part is to hold and no stage drives its apex.

    One stage is enough: a part may settle before it is pressed, and a worm keeps what it has wound.
    """
    for part, slot, apex in _apexes(view):
        stages: dict[tuple[int, str], list[StateWrite]] = {}
        for each in view.written:
            if each.write.slot == slot and not each.control:
                stages.setdefault((each.region, each.state), []).append(each)
        for first, *more in stages.values():
            idle = all(w.write.how != "keep" and not w.write.turns for w in (first, *more))
            name, wheel = view.loaded.normal.parts[part], view.profile.body.wheels[apex]
            if idle and first.region not in view.loaded.normal.part_regions[part]:
                held = ("body", "parts", name, "held")
                message = f"'{name}' would hold in {first.state} too, where nothing presses it to"
                message += " the wall"
                fix = f"ask for states of {view.loaded.normal.regions[first.region]}"
                yield view.at(held, "robot.clamp_side", message, fix=fix, offset=0)
                break
            if idle and _holding(view, part, first):
                message = f"'{name}' holds in {first.state}, and nothing presses it to the wall"
                sign = "positive" if wheel.direction > 0 else "negative"
                fix = f"give it a {sign} value in one of the stages, which presses '{wheel.name}'"
                yield view.at(first.path, "robot.clamp_side", message, fix=f"{fix} to its wall")


def _fights(view: RobotView) -> Iterator[Finding]:
    """Yield states that drive wheels against each other."""
    wheels = {wheel.name: wheel for wheel in view.profile.body.wheels}
    driven: dict[tuple[int, str, int], list[tuple[int, StateWrite]]] = {}
    for each in view.written:
        wheel = wheels.get(view.profile.slots[each.write.slot].wheel or "")
        # A control turns the same wheels the same way.
        if wheel is not None and each.write.turns and not each.control:
            forward = 1 if each.write.value * wheel.direction > 0 else -1
            stage = (each.region, each.state, each.stage)
            driven.setdefault(stage, []).append((forward, each))
    for (_, state, _), writes in driven.items():
        most = 1 if sum(forward for forward, _ in writes) >= 0 else -1
        for forward, each in writes:
            if forward != most:
                name = view.profile.slots[each.write.slot].name
                way = "backward" if most > 0 else "forward"
                message = f"'{name}' drives {way} in {state}, the other wheels the other way"
                yield view.at(each.path, "robot.wheels_fight", message)


def safe_clamps(view: RobotView) -> Iterator[Finding]:
    """Yield slots that the safe state sets to zero although they press a held part."""
    joints = {joint.name: joint.part for joint in view.profile.body.joints}
    parts = view.loaded.normal.parts
    for number, name in enumerate(view.profile.safe_state.zero):
        slot = next(n for n, (each, _) in enumerate(view.slots) if each.name == name)
        part = joints.get(view.profile.slots[slot].joint or "")
        if part is None:
            continue
        state = _pressed_in(view, slot, parts.index(part))
        if state:
            message = f"'{name}' holds the part '{part}' in {state}: at zero it releases the wall"
            yield view.at(("safe_state", "zero", number), "robot.safe_clamp", message)


def _pressed_in(view: RobotView, slot: int, part: int) -> str:
    """Return the first state in which the slot presses the part to the wall; empty without one."""
    for each in view.written:
        pressing = each.write.slot == slot and each.write.turns
        if pressing and _holding(view, part, each):
            return f"{view.loaded.normal.regions[each.region]}.{each.state}"
    return ""


def boards_outside(view: RobotView) -> Iterator[Finding]:
    """Yield boards that drive a wheel or joint and sit in no link."""
    modules = [link.module for link in view.profile.body.links]
    for number, board in enumerate(view.profile.boards):
        driven = next((slot.drives for slot in board.slots if slot.drives), "")
        if driven and board.module not in modules:
            message = (
                f"board {board.id} drives '{driven}', and no link is the module '{board.module}'"
            )
            yield view.at(
                ("boards", number, "module"),
                "robot.reference",
                message,
                fix=f"write {' or '.join(modules)}",
                severity=Severity.WARNING,
            )


def states_alike(view: RobotView) -> Iterator[Finding]:
    """Yield states that write exactly what another one does: driven wheels, or all of a region."""
    wheels = {slot.name for slot, _ in view.slots if slot.wheel}
    for region, states in view.profile.actuation.items():
        known: dict[str, str] = {}
        alike = len(set(map(repr, states.values()))) == 1 and any(
            any(stages) for stages in states.values()
        )
        for state, stages in states.items():
            turns = any(getattr(v, "value", 0) for s in stages for k, v in s.items() if k in wheels)
            other = known.setdefault(repr(stages), state) if turns or alike else state
            if other != state:
                yield view.at(
                    ("actuation", region, state),
                    "robot.reference",
                    f"{state} writes exactly what {other} does",
                    key=True,
                    fix="correct its setpoints, or keep one of the two states",
                    severity=Severity.WARNING,
                )


def refused_openings(view: RobotView) -> Iterator[Finding]:
    """Yield commands that open clamps only where that lets go of all, and may not."""
    held = view.loaded.normal.held
    for number, name in enumerate(view.loaded.table.commands):
        opened = [held[b] for a, b in view.moves(number) if held[a] - held[b]]
        if opened and not any(opened) and not view.profile.commands[name].lets_go:
            yield view.at(
                ("commands", name),
                "robot.never_done",
                f"{name} is refused wherever it would open a clamp: none would be left",
                key=True,
                fix="write `lets_go: true`, or let it lead to a state in which another part holds",
                severity=Severity.WARNING,
            )


def unconfirmed_clamps(view: RobotView) -> Iterator[Finding]:
    """Yield commands that clamp a part and are done without a criterion for that part."""
    robot = view.loaded.normal
    own = {joint.torque: joint.part for joint in view.profile.body.joints}
    for number, command in enumerate(robot.commands):
        clamped = {
            robot.parts[part]
            for before, after in view.moves(number)
            for part in robot.held[after] - robot.held[before]
        }
        if command.proof == "echo":
            unseen, key = clamped, "kind"
        elif loads := command.done.asked(TorqueBorne):
            names = robot.vocabulary.numbers
            unseen = clamped - {own.get(names[load.torque]) for load in loads}
            key = "loaded"
        else:
            continue
        if unseen:
            message = (
                f"{command.name} makes '{min(unseen)}' hold, and counts as done although no sensor "
                "shows it"
            )
            yield view.at(("commands", command.name, "done", key), "robot.clamp_blind", message)
