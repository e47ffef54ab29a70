"""Rules about `seen`: every state and part has a criterion, which sensors can meet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import Path
from pirate_sm.core.robot import (
    AcceptedSpec,
    AnglesSpec,
    DrivenSpec,
    HeldSpec,
    ImpliedSpec,
    SeenSpec,
    StandingSpec,
)


def unseen_states(view: RobotView) -> Iterator[Finding]:
    """Yield states and parts for which the profile has no criterion."""
    profile, table = view.profile, view.loaded.table
    seen = profile.seen
    if "seen" not in profile.model_fields_set:
        message = "the profile does not say how sensors show the robot's states: add `seen`"
        yield view.at(("robot",), "robot.unseen", message, key=True)
        return
    for region, states in zip(table.regions, table.states, strict=True):
        missing = [state for state in states if state not in seen.states.get(region, {})]
        if missing:
            path: Path = ("seen", "states", region) if region in seen.states else ("seen",)
            message = f"`seen` has no criterion for {region}: {', '.join(missing)}"
            yield view.at(path, "robot.unseen", message, key=True)
    parts = [name for name in profile.body.parts if name not in seen.parts]
    if parts:
        message = f"`seen` has no criterion for held parts: {', '.join(parts)}"
        path = ("seen", "parts") if seen.parts else ("seen",)
        yield view.at(path, "robot.unseen", message, key=True)


def impossible_signs(view: RobotView) -> Iterator[Finding]:
    """Yield criteria that the sensors can never meet, or never for long enough."""
    robot = view.loaded.normal
    every = (*robot.sight.parts, *(spec for each in robot.sight.states for spec in each.values()))
    lasting = [
        each.for_s for each in every if isinstance(each, HeldSpec | AnglesSpec | StandingSpec)
    ]
    if lasting and min(lasting) >= robot.sight.within_s:
        message = f"nothing can be confirmed: {_too_long(view, min(lasting))}"
        yield view.at(("seen", "within"), "robot.seen_never", message)
        return
    for number, held in enumerate(robot.sight.parts):
        if held is not None:
            path: Path = ("seen", "parts", robot.parts[number])
            yield from _said(view, path, robot.parts[number], _part(view, number, held))
    for number, states in enumerate(robot.sight.states):
        region = robot.regions[number]
        for name, spec in states.items():
            about = f"{region} {name}"
            yield from _said(view, ("seen", "states", region, name), about, _state(view, spec))


def _said(
    view: RobotView, path: Path, about: str, reasons: Iterable[tuple[str, str]]
) -> Iterator[Finding]:
    """Yield a finding about the first of the reasons, each of which has a key."""
    for key, why in reasons:
        if why:
            message = f"this can never confirm '{about}': {why}"
            yield view.at((*path, key), "robot.seen_never", message)
            return


def _part(view: RobotView, part: int, spec: HeldSpec) -> Iterator[tuple[str, str]]:
    yield "for", _too_long(view, spec.for_s)
    needed = [index for joint in spec.joints for index in (joint.torque, joint.rate)]
    yield "loaded", _unheard(view, [*needed, spec.diameter, spec.apex])
    yield "torque", _too_strong(view, part, spec)
    if spec.open_rad <= 0:
        yield "end_stop", "its apex is never farther than this from its end stop"


def _state(view: RobotView, spec: SeenSpec) -> Iterator[tuple[str, str]]:
    match spec:
        case AnglesSpec(targets, _, _, for_s):
            yield "for", _too_long(view, for_s)
            yield "kind", _unheard(view, [angle for angle, _ in targets])
        case StandingSpec(speeds, _, for_s):
            yield "for", _too_long(view, for_s)
            yield "kind", "" if view.heard & set(speeds) else _unheard(view, speeds)
        case DrivenSpec() | ImpliedSpec() | AcceptedSpec():
            pass


def _too_long(view: RobotView, for_s: float) -> str:
    within_s = view.loaded.normal.sight.within_s
    if for_s < within_s:
        return ""
    return f"it must hold for {for_s:g} s, but the start check takes only {within_s:g} s"


def _unheard(view: RobotView, needed: Sequence[int]) -> str:
    missing = [index for index in needed if index >= 0 and index not in view.heard]
    names = view.loaded.normal.vocabulary.numbers
    return f"no fitted board measures {names[missing[0]]}" if missing else ""


def _too_strong(view: RobotView, part: int, spec: HeldSpec) -> str:
    """Return why no state that holds the part gives the required torque; empty if one does."""
    robot = view.loaded.normal
    holding = [number for number, held in enumerate(robot.held) if part in held]
    for joint in spec.joints:
        most = max((view.in_force.most_nm(Actuated(n), joint.slot) for n in holding), default=0.0)
        if most <= joint.needed_nm:
            return (
                f"its motor gives '{view.profile.slots[joint.slot].joint}' at most"
                f" {most:.3g} Nm there, and {joint.needed_nm:.3g} Nm are asked for"
            )
    return ""
