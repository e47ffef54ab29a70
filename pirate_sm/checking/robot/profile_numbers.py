"""Rules about the numbers of a profile: they must not contradict each other."""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, degrees, inf, pi

from pirate_sm.checking.actuation_in_force import too_slow, too_strong
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import Path
from pirate_sm.core.loading import FOLDING_ROOM_RAD
from pirate_sm.core.models import Target, done_criteria
from pirate_sm.core.robot import CriterionSpec, needs_of_signals

_DENSEST_KG_M3 = 22_600.0
"""Density of osmium, the densest material there is."""


def never_done(view: RobotView) -> Iterator[Finding]:
    """Yield commands whose criterion can never be true, under some control at least."""
    for number, name in enumerate(view.loaded.table.commands):
        spec = view.loaded.normal.commands[number]
        at: Path = ("commands", name, "done")
        borne = "at_least" if spec.done.settled else "torque"
        fast = "share" if getattr(view.profile.commands[name].done, "share", None) else "above"
        for key, why in (
            ("for", _too_long(spec.done, spec.timeout_s)),
            ("kind", view.unheard(needs_of_signals(spec.done, len(view.profile.slots)))),
            (borne, too_strong(view.in_force, spec.done, view.led(number))),
            (fast, too_slow(view.in_force, spec.done, view.led(number))),
        ):
            if why:
                message = f"{name} can never be done: {why}"
                yield view.at((*at, key), "robot.never_done", message)
                break
        else:
            yield from _never_done_under_controls(view, number, name, spec.done)


def turning_at_rest(view: RobotView) -> Iterator[Finding]:
    """Yield setpoints that keep a command from being done, which waits for wheels at rest."""
    table = view.loaded.table
    for number, name in enumerate(table.commands):
        done, led = view.profile.commands[name].done, view.led(number)
        if not isinstance(done, done_criteria.Stopped) or not led:
            continue
        for each in view.written:
            states = {table.configurations[at.configuration][each.region] for at in led}
            turns = view.in_force.most_rad_s(led[0], each.write.slot) > done.below
            wheel = view.profile.slots[each.write.slot].wheel
            if wheel and states == {each.state} and turns and not each.control:
                message = f"{each.state} turns '{wheel}', and {name}, which leads to it, is done"
                message += f" when wheels turn by less than {done.below:g} rad/s"
                yield view.at(each.path, "robot.never_done", message, fix="write `0 %`")


def _never_done_under_controls(
    view: RobotView, number: int, name: str, done: CriterionSpec
) -> Iterator[Finding]:
    """Yield controls under which a command can never be done; once for those that extend one."""
    reported: set[str | None] = set()
    for control, (own, settings) in enumerate(view.profile.controls.items(), start=1):
        led = view.led(number, control)
        why = too_strong(view.in_force, done, led) or too_slow(view.in_force, done, led)
        if why and settings.extends not in reported:
            message = f"{name} can never be done: {why}"
            yield view.at(("controls", own), "robot.never_done", message, key=True)
        if why:
            reported.add(own)


def _too_long(done: CriterionSpec, timeout_s: float) -> str:
    if done.for_s < timeout_s:
        return ""
    return f"for {done.for_s:g} s is not shorter than its timeout of {timeout_s:g} s"


def hidden_motors(view: RobotView) -> Iterator[Finding]:
    """Yield torques and speeds instead of shares of what motors do whose numbers are known."""
    commands, seen = view.profile.commands, view.profile.seen
    states = ((r, name, how) for r, given in seen.states.items() for name, how in given.items())
    found: list[tuple[Path, object]] = [
        *((("commands", name, "done"), each.done) for name, each in commands.items()),
        *((("seen", "parts", name), how) for name, how in seen.parts.items()),
        *((("seen", "states", region, name), how) for region, name, how in states),
    ]
    motors = [(slot, view.profile.motors[slot.motor]) for slot in view.profile.slots]
    known = {
        "torque": all(motor.stall_torque for slot, motor in motors if slot.joint),
        "above": all(motor.no_load_speed for slot, motor in motors if slot.wheel),
    }
    for path, how in found:
        key = "torque" if isinstance(how, done_criteria.Load) else "above"
        if (
            isinstance(how, done_criteria.Load | done_criteria.Turning)
            and getattr(how, key) is not None
            and known[key]
        ):
            message = f"a motor of this robot may differ: say it as a `share`, not by `{key}`"
            yield view.at((*path, key), "robot.hidden_motor", message)


def nominal_times(view: RobotView) -> Iterator[Finding]:
    """Yield commands whose nominal duration exceeds their timeout."""
    robot, index = view.loaded.normal, view.loaded.table.command_index
    for name, command in view.profile.commands.items():
        measured = robot.commands[index[name]].proof == "sensor"
        if command.nominal > command.timeout and measured:
            message = (
                f"the nominal duration of {name} is {command.nominal:g} s, longer than its timeout"
                f" of {command.timeout:g} s"
            )
            yield view.at(("commands", name, "nominal"), "robot.nominal", message)


def link_times(view: RobotView) -> Iterator[Finding]:
    """Yield times of the link that contradict each other or the period of the reports."""
    link = view.profile.link
    messages = view.profile.messages_per_round
    round_s = messages * link.cycle
    for key, limit_s, what in (
        ("stale_after", link.stale_after, "every signal is unknown"),
        ("silent_after", link.silent_after, "every board counts as silent"),
    ):
        if limit_s < round_s:
            message = (
                f"{what} {limit_s:g} s after its last message, and the next one comes"
                f" {round_s:.3g} s after it: {messages} messages of {link.cycle:g} s"
            )
            yield view.at(("link", key), "robot.link_times", message)
    if (valid_s := view.profile.detector.valid_for) < link.cycle:
        message = f"a word is valid for {valid_s:g} s, less than the cycle of {link.cycle:g} s in"
        message += " which anything new is reported"
        yield view.at(("detector", "valid_for"), "robot.link_times", message)
    if round_s <= link.silent_after < link.stale_after:
        message = (
            f"a board counts as silent after {link.silent_after:g} s, while its signals count as"
            f" known for {link.stale_after:g} s"
        )
        yield view.at(
            ("link", "silent_after"), "robot.link_times", message, severity=Severity.WARNING
        )
    if link.resend_after <= link.echo_delay:
        message = (
            f"every array is sent again after {link.resend_after:g} s, and confirmed only"
            f" {link.echo_delay:g} s after it was sent"
        )
        yield view.at(("link", "resend_after"), "robot.link_times", message)


def coarse_setpoints(view: RobotView) -> Iterator[Finding]:
    """Yield the resolution of duties if it changes those of states by more than a tenth."""
    step = view.profile.link.duty_resolution
    for each in view.written:
        value, slot = each.write.value, view.profile.slots[each.write.slot]
        sent = round(value / step) * step
        if each.write.how == "set" and slot.unit == "duty" and abs(sent - value) > abs(value) / 10:
            message = (
                f"the {value * 100:g} % of '{slot.name}' in {each.state} are sent as"
                f" {sent * 100:g} %, in steps of {step * 100:g} %"
            )
            at: Path = ("link", "duty_resolution")
            yield view.at(at, "robot.setpoint", message, severity=Severity.WARNING)
            return


def position_loops(view: RobotView) -> Iterator[Finding]:
    """Yield position loops whose least duty cycle is more than their limit."""
    for name, motor in view.profile.motors.items():
        loop = motor.position_loop
        if loop is not None and loop.least_duty > loop.limit:
            message = (
                f"the least duty cycle of {loop.least_duty * 100:g} % is more than the limit of"
                f" {loop.limit * 100:g} %"
            )
            yield view.at(
                ("motors", name, "position_loop", "least_duty"), "robot.position_loop", message
            )


def impossible_bodies(view: RobotView) -> Iterator[Finding]:
    """Yield lengths, angles and masses that no body can have.

    A link fits into the box that its wheels roll through. Bodies meet outside a joint's wheel
    beyond 2 atan(r/t), with the wheels' radius r and the half thickness t of the bodies.
    """
    body = view.profile.body
    radius_m, thick_m = body.wheel_radius, body.body_half_thickness
    wheel_m3 = pi * radius_m**2 * body.wheel_width
    room = [(("wheels", n, "mass"), each.mass, wheel_m3) for n, each in enumerate(body.wheels)]
    room += [
        (("links", n, "mass"), each.mass, each.length * (2 * max(radius_m, thick_m)) ** 2)
        for n, each in enumerate(body.links)
    ]
    found: list[tuple[Path, str]] = [
        (path, f"{kg:.4g} kg have a room of {m3 * 1e6:.0f} cm^3: nothing is so heavy")
        for path, kg, m3 in room
        if kg > _DENSEST_KG_M3 * m3
    ]
    folded_rad = 2 * atan2(radius_m, thick_m)
    found += [
        (
            ("joints", number, "end_stop"),
            f"{degrees(joint.end_stop):.4g} deg is not reached: links that are"
            f" {thick_m * 2e3:.4g} mm thick meet at {degrees(folded_rad):.4g} deg",
        )
        for number, joint in enumerate(body.joints)
        if joint.end_stop > folded_rad
    ]
    short = [number for number, link in enumerate(body.links) if link.length < 2 * radius_m]
    all_of_them = len(short) == len(body.links)  # so it is the radius that is wrong
    found += [
        (
            ("wheel_radius",) if all_of_them else ("links", number, "length"),
            f"wheels with a diameter of {radius_m * 2e3:.4g} mm overlap at the ends of a link of"
            f" {body.links[number].length * 1e3:.4g} mm",
        )
        for number in (short[:1] if all_of_them else short)
    ]
    found += [
        (("joints", number, "end_stop"), f"with it '{joint.part}' can clamp in no pipe")
        for number, joint in enumerate(body.joints)
        if joint.name == body.parts[joint.part].apex and joint.end_stop <= FOLDING_ROOM_RAD
    ]
    if thick_m >= radius_m:
        message = "the links touch the wall before the wheels do"
        found.append((("body_half_thickness",), message))
    for path, message in found:
        yield view.at(("body", *path), "robot.body", message)


def end_stops(view: RobotView) -> Iterator[Finding]:
    """Yield target angles that a joint cannot reach."""
    stops = {joint.name: joint.end_stop for joint in view.profile.body.joints}
    for joint, angle_rad, path in _sought(view):
        stop = stops.get(joint, inf)
        if abs(angle_rad) > stop:
            message = (
                f"{degrees(angle_rad):.4g} deg is beyond the end stop of '{joint}',"
                f" {degrees(stop):.4g} deg"
            )
            yield view.at(path, "robot.setpoint", message)


def _sought(view: RobotView) -> Iterator[tuple[str, float, Path]]:
    """Yield each target angle of states and postures: joint, angle in rad, path."""
    for each in view.written:
        if each.write.how == "seek":
            yield view.profile.slots[each.write.slot].joint or "", each.write.value, each.path
    joints = {slot.name: slot.joint or "" for slot in view.profile.slots}
    for name, cases in view.profile.postures.items():
        for number, case in enumerate(cases):
            for slot, setpoint in (case.set_ or {}).items():
                if isinstance(setpoint, Target):
                    path: Path = ("postures", name, number, "set", slot)
                    yield joints[slot], setpoint.angle_rad, path


def hidden_words(view: RobotView) -> Iterator[Finding]:
    """Yield words of the detector that never occur, because a later word always holds as well.

    The detector reports the last of the words that hold. When driving forward the first wheel is
    the farthest along the pipe, when driving backward the last wheel.
    """
    wheels = [wheel.name for wheel in view.profile.body.wheels]
    words = [(name, word) for name, word in view.profile.detector.words.items() if word.forward]
    for number, (name, own) in enumerate(words):
        for way, sign in (("forward", 1), ("backward", -1)):
            point = getattr(own, way)
            for other, definition in words[number + 1 :]:
                rival = getattr(definition, way)
                ahead = sign * (wheels.index(rival.wheel) - wheels.index(point.wheel)) <= 0
                if ahead and rival.passed <= point.passed:
                    message = (
                        f"the detector never reports '{name}' on the way {way}: wherever it"
                        f" is true, '{other}' is true, too"
                    )
                    yield view.at(("detector", "words", name, way), "robot.word_hidden", message)
                    break
