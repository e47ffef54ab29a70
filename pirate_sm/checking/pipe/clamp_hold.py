"""A rule about forces: the friction of clamped parts bears the weight of the robot."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.usual_course import CoursePoint
from pirate_sm.geometry.route import Piece
from pirate_sm.loading.problems import Path
from pirate_sm.model.pipe import Pipe


def clamps_bear_the_weight(view: PipeView) -> Iterator[Finding]:
    """Report clamped parts whose friction does not bear the robot's weight."""
    worst: tuple[float, CoursePoint, Piece] | None = None
    every = True
    for situation in view.course.situations:
        for piece in _stands_in(view, situation) if _held(view, situation) else ():
            pull = view.fit.pull_n(piece)[0]
            share = _grip_n(view, situation) / pull if pull > 0 else 1.0
            every = every and share < 1
            if share < 1 and (worst is None or share < worst[0]):
                worst = share, situation, piece
    if worst is not None:
        _, situation, piece = worst
        yield _weak(view, situation, piece, everywhere=every)


def _weak(view: PipeView, situation: CoursePoint, piece: Piece, *, everywhere: bool) -> Finding:
    fit, configuration = view.fit, situation.configuration
    held = sorted(_held(view, situation))
    torques = [f"{fit.torque_nm(part, configuration):.3g} Nm" for part in held]
    names = " and ".join(f"'{fit.robot.parts[part]}'" for part in held)
    press = sum(fit.press_n(part, configuration) for part in held)
    pull, rests = fit.pull_n(piece)
    message = (
        f"{names}, clamped with {' and '.join(torques)}, press the walls with {press:.3g} N:"
        f" with a friction of {fit.friction:g} that holds {_grip_n(view, situation):.3g} N, and"
        f" the weight pulls {pull:.3g} N along the pipe"
    )
    # The weight on the walls adds friction: if even that is too little, it is certain.
    certain = fit.friction * (press + rests) < pull
    severity = Severity.ERROR if certain else Severity.WARNING
    place = view.place_of_step(situation.place)
    if everywhere or not place.line:
        mission = view.loaded.documents[0]
        inline: Path = ("pipe", "tilt") if isinstance(view.loaded.mission.pipe, Pipe) else ()
        place = mission.place_of(inline or ("pipe",))
    document = view.document(place.file)
    return at(document, place, "geometry.clamp_torque", message, severity=severity)


def _held(view: PipeView, situation: CoursePoint) -> frozenset[int]:
    return view.fit.robot.held[situation.configuration]


def _grip_n(view: PipeView, situation: CoursePoint) -> float:
    """Return the largest friction force of all clamped parts, N."""
    configuration = situation.configuration
    return view.fit.friction * sum(
        view.fit.press_n(part, configuration) for part in _held(view, situation)
    )


def _stands_in(view: PipeView, situation: CoursePoint) -> list[Piece]:
    """Return the pieces in which the robot can be: the first, and the one behind a passed bend."""
    behind = view.piece_behind(situation.bent[0]) if situation.bent else None
    return [view.first_piece] if behind is None else [view.first_piece, behind]
