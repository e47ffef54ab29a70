"""A rule about the forces of clamps: clamped parts hold the robot on a slope."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from pirate_sm.checking.actuation_in_force import under
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.usual_course import CoursePoint
from pirate_sm.core.documents import Path
from pirate_sm.core.geometry import Piece, Vector, dot
from pirate_sm.core.models import Pipe


class _Hold(NamedTuple):
    """How the clamped parts hold in one piece of the pipe, with gravity in one direction.

    Attributes:
        piece: The piece of the pipe.
        torques_nm: Of each held part's apex; ``press_n`` is the sum of their normal forces.
        least_n: What friction holds at the worst place; ``most_n`` at the best one, with the grip
            raised as far as it may be and the weight resting on the walls.
        pull_n: The weight along the pipe.
        turned: Whether the pipe has turned before.
    """

    piece: Piece
    torques_nm: tuple[float, ...]
    press_n: float
    least_n: float
    most_n: float
    pull_n: float
    turned: bool

    @property
    def share(self) -> float:
        """Return which share of the weight is held; 1 where none pulls."""
        return self.least_n / self.pull_n if self.pull_n > 0 else 1.0


def clamps_bear_the_weight(view: PipeView) -> Iterator[Finding]:
    """Report clamped parts whose friction does not bear the robot's weight."""
    worst: tuple[_Hold, CoursePoint] | None = None
    every, certain = True, False
    seen: set[tuple[object, ...]] = set()
    for situation in view.course.situations:
        key = situation.actuated, situation.driven, situation.bent[:1], situation.passed
        holds = list(_holds(view, situation)) if _held(view, situation) and key not in seen else []
        seen.add(key)
        every = every and all(hold.share < 1 for hold in holds)
        for hold in holds:
            if hold.share < 1 and (worst is None or hold.share < worst[0].share):
                worst, certain = (hold, situation), all(h.most_n < h.pull_n for h in holds)
    if worst is not None:
        yield _weak(view, *worst, everywhere=every, certain=certain)


def _holds(view: PipeView, situation: CoursePoint) -> Iterator[_Hold]:
    """Yield how the robot holds wherever it can be, and however the pipe is turned then."""
    ups = view.fit.ups(view.loaded.program.time_limit_s)
    for piece in view.stands_in(situation):
        for number, up in enumerate(ups):
            yield _hold(view, situation, piece, up, turned=number > 0)


def _hold(
    view: PipeView, situation: CoursePoint, piece: Piece, up: Vector, *, turned: bool
) -> _Hold:
    fit, parts, diameter_m = view.fit, sorted(_held(view, situation)), piece.diameter_m
    slope = abs(dot(up, piece.frame.ahead))
    torques = [fit.torques_nm(part, situation.actuated, diameter_m, slope) for part in parts]
    presses, most = (
        [fit.press_n(part, torque, diameter_m) for part, torque in zip(parts, each, strict=True)]
        for each in zip(*torques, strict=True)
    )
    frictions = fit.frictions(parts, _firsts(view, situation, piece), diameter_m)
    pull, rests = fit.pull_n(piece, up)
    return _Hold(
        piece,
        tuple(torque for torque, _ in torques),
        sum(presses),
        min(_sum(presses, each) for each in frictions),
        max(_sum(most, each) + max(each) * rests for each in frictions),
        pull,
        turned,
    )


def _sum(presses: list[float], frictions: list[float]) -> float:
    return sum(press * friction for press, friction in zip(presses, frictions, strict=True))


def _firsts(view: PipeView, situation: CoursePoint, piece: Piece) -> tuple[float, float]:
    """Return between which arc lengths the first wheel of the clamped robot may be in a piece.

    Until wheels are driven it is where the robot begins; a robot that clamps there grows shorter.
    """
    fit = view.fit
    clamped_m = fit.clamped_m(piece.diameter_m)
    if situation.driven or situation.bent or piece != view.first_piece:
        low, high = piece.clear_m
        return min(low + clamped_m, high), high
    first = view.pipe.start_of(fit.stretched_m)
    begins_clamped = bool(fit.robot.held[view.course.situations[0].configuration])
    return first - (0.0 if begins_clamped else fit.stretched_m - clamped_m), first


def _weak(
    view: PipeView, hold: _Hold, situation: CoursePoint, *, everywhere: bool, certain: bool
) -> Finding:
    robot = view.fit.robot
    torques = " and ".join(f"{torque:.3g} Nm" for torque in hold.torques_nm)
    names = " and ".join(f"'{robot.parts[part]}'" for part in sorted(_held(view, situation)))
    friction = hold.least_n / hold.press_n if hold.press_n else view.fit.friction
    patched = f"{friction:.3g}" != f"{view.fit.friction:.3g}"
    message = (
        f"{names}, clamped with {torques}{under(robot, situation.control)}, press the walls with"
        f" {hold.press_n:.3g} N: with a friction of {friction:.3g}"
        f"{', part of it on a patch,' if patched else ''} that holds {hold.least_n:.3g} N, and the"
        f" weight pulls {hold.pull_n:.3g} N along the pipe"
        f"{' once it has turned' if hold.turned else ''}"
    )
    # The weight on the walls adds friction: if even that is too little, it is certain.
    severity = Severity.ERROR if certain else Severity.WARNING
    place = view.place_of_step(situation.place)
    if everywhere or not place.line:
        mission = view.loaded.documents[0]
        inline: Path = ("pipe", "tilt") if isinstance(view.loaded.mission.pipe, Pipe) else ()
        place = mission.place_of(inline or ("pipe",))
    document = view.document(place.file)
    spatial = view.pipe.section == "round"
    related = [(view.place_in_pipe(view.pipe.path_of(hold.piece)), "in this")] if spatial else []
    return at(document, place, "geometry.clamp_torque", message, severity=severity, related=related)


def _held(view: PipeView, situation: CoursePoint) -> frozenset[int]:
    return view.fit.robot.held[situation.configuration]
