"""The bend by what a synthetic camera sees: how often it succeeds, and how exact the words are.

    python -m benchmarks.camera_bends [--seeds 10] [--defect-seeds 5] [--workers 2]

A picture is drawn ten times a second from the truth of the simulator, through the lens, with noise,
blur and JPEG, searched, and reported 100 ms late. Tags are tried in five lights, forward and
backward, level and tilted by 28 deg, with the shifted starts and the friction of `make seeds`;
one marker in one light. A word is late by how far its wheel is beyond the word's point when it is
first reported on the way through a bend, by the truth.

Then every defect of a bend joint, by tags: no run may succeed with a wheel more than 15 mm short.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.campaign import run_all
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.core.models import Profile
from pirate_sm.lab.campaign.watched_run import SHORT_M, Outcome
from pirate_sm.running.wiring import Order

LIGHTS = {
    "neutral": "{}",
    "dim": "{gain: 0.3}",
    "warm": "{lamp: warm}",
    "cold": "{lamp: cold, uneven: 0.5}",
    "lamps": "{glare: true, uneven: 0.4}",
}
TILTED_BACKWARD = "mitre_90_backward_tilted"
TILTED = "tilt: 28 deg\nuphill: 180 deg\n"
BENDS = (
    ("mitre_bend", "mitre_90"),
    ("mitre_bend", "mitre_90_tilted"),
    ("mitre_bend_backward", "mitre_90_backward"),
    ("mitre_bend_backward", TILTED_BACKWARD),
)
EARLY_M, LATE_M = -0.015, 0.015
BAR = 0.99


@dataclass(frozen=True)
class Row:
    """Runs of one camera.

    Attributes:
        name: What is printed.
        orders: The runs.
    """

    name: str
    orders: tuple[Order, ...]


def main() -> int:
    """Print each row; return 1 if a bar is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--defect-seeds", type=int, default=5)
    parser.add_argument("--workers", type=int)
    wishes = parser.parse_args()
    with TemporaryDirectory() as folder:
        cameras = {light: _camera(Path(folder), light) for light in LIGHTS}
        bends = [(mission, _pipe(Path(folder), pipe)) for mission, pipe in BENDS]
        good = _show_rows(_rows(cameras, bends, range(wishes.seeds)), wishes.workers)
        defects = _defects(cameras["neutral"], range(wishes.defect_seeds))
        good &= _show_defects(defects, wishes.workers)
    return 0 if good else 1


def _camera(folder: Path, light: str) -> str:
    """Write the synthetic camera with tags in this light; return its path."""
    text = library.find_camera("synthetic").read_text("utf-8")
    text = text.replace("camera: synthetic\n", f"camera: {light}\n")
    lit = text.replace("{light: {glare: true}}", f"{{light: {LIGHTS[light]}}}")
    assert lit != text
    path = folder / f"{light}.yaml"
    path.write_text(lit, "utf-8")
    return str(path)


def _pipe(folder: Path, name: str) -> str:
    """Return a shipped pipe's name, or the path of a pipe tilted so that the robot goes up."""
    if name != TILTED_BACKWARD:
        return name
    level = name.removesuffix("_tilted")
    text = library.find_pipe(level).read_text("utf-8")
    path = folder / f"{name}.yaml"
    path.write_text(text.replace(f"pipe: {level}\n", f"pipe: {name}\n{TILTED}"), "utf-8")
    return str(path)


def _rows(
    cameras: dict[str, str], bends: Sequence[tuple[str, str]], seeds: Sequence[int]
) -> Iterator[Row]:
    for light, path in cameras.items():
        yield Row(f"tags, {light}", tuple(_orders(f"vision:{path}", bends, seeds)))
    yield Row("one marker", tuple(_orders("vision:synthetic_marker", bends, seeds)))


def _orders(
    detector: str, bends: Sequence[tuple[str, str]], seeds: Sequence[int]
) -> Iterator[Order]:
    usual = Order(
        "", detector=detector, start_jitter_m=0.020, friction_jitter=0.20, diameter_jitter_m=0.002
    )
    for mission, pipe in bends:
        for seed in seeds:
            yield replace(usual, mission=mission, pipe=pipe, seed=seed)


def _show_rows(rows: Iterator[Row], workers: int | None) -> bool:
    print(f"{'':16} passed        words late by, least/median/most")
    good = True
    for row in rows:
        outcomes = run_all(row.orders, workers=workers)
        passed = [each for each in outcomes if each.outcome == "succeeded" and not is_false(each)]
        late = sorted(late for each in outcomes for late in _first_words(each))
        tags = row.name.startswith("tags")
        least, middle, most = (1000 * each for each in (late[0], late[len(late) // 2], late[-1]))
        print(
            f"{row.name:16} {len(passed):3} of {len(outcomes):3}"
            f"    {least:+.1f}/{middle:+.1f}/{most:+.1f} mm",
            flush=True,
        )
        for each in outcomes:
            if each not in passed:
                print(f"    seed {each.seed}: {each.outcome}: {each.message}")
        if tags:
            good &= len(passed) >= BAR * len(outcomes)
            good &= late[0] >= EARLY_M and late[-1] <= LATE_M
    return good


def _first_words(outcome: Outcome) -> list[float]:
    """Return how late each word was when it was reported first."""
    return list(dict(reversed(outcome.late_m)).values())


def _defects(camera: str, seeds: Sequence[int]) -> tuple[Order, ...]:
    profile = load_robot(library.find_robot("pirate_ii")).profile
    return tuple(
        Order(mission, pipe=pipe, seed=seed, defects=(defect,), detector=f"vision:{camera}")
        for defect in joint_defects(profile)
        for mission, pipe in BENDS[::2]
        for seed in seeds
    )


def joint_defects(profile: Profile) -> list[str]:
    """Return the names of the defects of bend joints or of their sensors."""
    joints = {joint.name for joint in profile.body.joints}
    return [
        name
        for name, defect in profile.simulation.defects.items()
        if joints & {*defect.signals, *defect.raw, defect.joint}
    ]


def is_false(outcome: Outcome) -> bool:
    """Return whether a run succeeded though its wheel was short of the last word's place."""
    return outcome.outcome == "succeeded" and not outcome.short_m <= SHORT_M


def _show_defects(orders: Sequence[Order], workers: int | None) -> bool:
    outcomes = run_all(orders, workers=workers)
    for defect in dict.fromkeys(order.defects[0] for order in orders):
        mine = [o for w, o in zip(orders, outcomes, strict=True) if w.defects == (defect,)]
        passed = [each for each in mine if each.outcome == "succeeded"]
        false = [each.seed for each in passed if is_false(each)]
        print(f"{defect:24} {len(passed):3} of {len(mine):3} succeeded, falsely: {false or 'none'}")
    return not any(map(is_false, outcomes))


if __name__ == "__main__":
    sys.exit(main())
