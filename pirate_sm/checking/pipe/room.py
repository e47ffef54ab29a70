"""Rules about space: for the robot at its start, and for its clamp behind a bend."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.pipe_view import PipeView, mm


def starts_clear_of_bends(view: PipeView) -> Iterator[Finding]:
    """Report a robot that does not start within one piece of the pipe, clear of every bend."""
    if view.course.situations[0].bent:
        return  # it starts in the bend
    clamped = bool(view.fit.robot.held[view.course.situations[0].configuration])
    length = view.fit.clamped_m if clamped else view.fit.stretched_m
    first = view.pipe.start_of(view.fit.stretched_m)
    last = first - length
    how = f"the robot, {mm(length)} long there, with its first wheel at {mm(first)}"
    if last < 0 or first > view.fit.route.pieces[-1].ends_m:
        end = "beginning" if last < 0 else "end"
        yield view.finding_in_pipe(
            view.start_path, "geometry.too_close", f"{how} juts out of the {end}"
        )
        return
    for before in view.fit.route.pieces[:-1]:
        crossing = before.ends_m
        taken = before.taken_m[1]
        if last < crossing + taken and first > crossing - taken:
            where = f"the bend at {mm(crossing)}, which begins {mm(taken)} before"
            message = f"{how} stands in {where} the crossing of the axes"
            yield view.finding_in_pipe(view.start_path, "geometry.too_close", message)
            return


def holds_behind_the_bend(view: PipeView) -> Iterator[Finding]:
    """Report a piece behind the bend that is too short for the clamped robot."""
    everything = frozenset(range(len(view.fit.robot.parts)))
    round_it = [
        each
        for each in view.course.situations
        if view.fit.robot.held[each.configuration] == everything and everything <= set(each.bent)
    ]
    piece = view.piece_behind(round_it[0].bent[0]) if round_it else None
    if piece is None:
        return
    low, high = piece.clear_m
    if high - low < view.fit.clamped_m:
        room, need = mm(high - low), mm(view.fit.clamped_m)
        message = (
            f"there are {room} of straight walls here, and the clamped robot, which the mission"
            f" brings here, is {need} long"
        )
        path = ("segments", piece.segment, "straight")
        yield view.finding_in_pipe(path, "geometry.too_short", message)
