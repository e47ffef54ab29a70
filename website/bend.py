"""The animated picture of the README: the robot in the bend, drawn from a simulated run.

`python -m website.bend` writes it; a test holds the stored picture to the simulator.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory

import pirate_sm
from pirate_sm.core.geometry import Place
from pirate_sm.core.models import Mission
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.contents import Lane, Report, RobotScene
from pirate_sm.views.report.recording_report import report_of
from pirate_sm.views.report.timeline import PHASE

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "pictures" / "bend.svg"
MISSION = "mitre_bend"

SPEED = 3.0
"""How much faster than the run the picture is."""

SAMPLE_S = 0.25
"""Time between two poses of the run; the viewer interpolates between them."""

HOLD_S = 2.0
"""How long the last pose is shown, in the time of the picture."""

MARGIN_M = 0.05
_MM = 1e3

_STYLE = """
.bore{fill:#eef3f7}.wall{fill:none;stroke:#6e7781;stroke-width:5}
.link{fill:none;stroke:#9db4cc;stroke-width:17;stroke-linecap:round;stroke-linejoin:round}
.held{stroke:#2f81f7}
.wheel{fill:#fff;stroke:#24292f;stroke-width:4}.front{fill:#f0b429}
text{fill:#57606a;font:32px system-ui,-apple-system,"Segoe UI",sans-serif}
.key{font-size:24px}
@media (prefers-color-scheme:dark){.bore{fill:#1c242e}.wall{stroke:#8b949e}
.link{stroke:#5d7794}.held{stroke:#2f81f7}.wheel{fill:#0d1117;stroke:#e6edf3}.front{fill:#d9a334}text{fill:#9aa4af}}
"""
_KEY = "Orange: the front wheel. Blue: holds itself in the pipe."


def drawn() -> str:
    """Return the picture, drawn from a run that is made now."""
    with TemporaryDirectory() as folder:
        recording = Path(folder) / "run.mcap"
        run = pirate_sm.run(MISSION, seed=0, record=recording)
        report = report_of(read_recording(recording))
    return _Film(report, run.loaded.mission, run.message).svg()


class _Film:
    """A run as an SVG that moves.

    Args:
        report: What happened.
        mission: What was run; its phases have the captions.
        end: The last caption.
    """

    def __init__(self, report: Report, mission: Mission, end: str) -> None:
        assert report.scene is not None, "the simulator knows where the robot is"
        self._report, self._mission, self._end = report, mission, end
        self._scene: RobotScene = report.scene
        steps = int(report.duration_s / SAMPLE_S) + 1
        self._times_s = [number * SAMPLE_S for number in range(steps)]
        self._poses = [_pose(self._scene, at_s) for at_s in self._times_s]
        self._lasts_s = report.duration_s / SPEED + HOLD_S
        xs, ys = zip(*(place for pose in self._poses for place in pose), strict=True)
        left, right = min(xs) - 2 * MARGIN_M, max(xs) + 2 * MARGIN_M
        low, high = min(ys) - MARGIN_M, max(ys) + MARGIN_M
        self._corner = (left, -high)
        self._size = (right - left, high - low)

    def svg(self) -> str:
        """Return the picture."""
        view = " ".join(_numbers((*self._corner, *self._size)))
        title = f"{self._mission.description}, in the simulator, {SPEED:g} times as fast"
        parts = [*self._pipe(), *self._links(), *self._wheels(), *self._captions()]
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}" role="img">'
            f"<title>{escape(title)}</title><style>{_STYLE}</style>\n"
            + "\n".join(parts)
            + "\n</svg>\n"
        )

    def _pipe(self) -> Iterator[str]:
        one, other = self._scene.walls
        yield f'<path class="bore" d="{_path((*one, *reversed(other)))}Z"/>'
        yield from (f'<path class="wall" d="{_path(wall)}"/>' for wall in self._scene.walls)

    def _links(self) -> Iterator[str]:
        """Yield the chain, and over it each part, which is seen while it holds."""
        yield self._chain("link", range(len(self._scene.wheels)))
        for lane in self._scene.parts:
            wheels = [n for n, wheel in enumerate(self._scene.wheels) if wheel.part == lane.name]
            holds = ["1" if _spanned(lane, at_s) else "0" for at_s in self._times_s]
            yield self._chain("link held", wheels, self._moving("opacity", holds, jumps=True))

    def _chain(self, kind: str, wheels: Sequence[int], more: str = "") -> str:
        ways = [_path([pose[number] for number in wheels]) for pose in self._poses]
        return f'<path class="{kind}" d="{ways[0]}">{self._moving("d", ways)}{more}</path>'

    def _wheels(self) -> Iterator[str]:
        radius = self._scene.wheel_radius_m * _MM - 2
        for number in range(len(self._scene.wheels)):
            xs, ys = zip(*(_numbers((pose[number][0], -pose[number][1])) for pose in self._poses),
                         strict=True)  # fmt: skip
            kind = "" if number else " front"
            yield (
                f'<circle class="wheel{kind}" cx="{xs[0]}" cy="{ys[0]}" r="{radius:.0f}">'
                f"{self._moving('cx', xs)}{self._moving('cy', ys)}</circle>"
            )

    def _captions(self) -> Iterator[str]:
        """Yield what each phase does, in the words of the mission, shown while it lasts."""
        x, y = (float(value) for value in _numbers((self._corner[0] + MARGIN_M, self._corner[1])))
        lane = next(lane for lane in self._report.lanes if lane.name == PHASE)
        phases = {span.start_s: span.text.partition("/")[0] for span in lane.spans}
        said = {
            at_s: self._mission.phases[name].description.partition(" (")[0] or self._end
            for at_s, name in phases.items()
        }
        texts = [said[max(begin for begin in said if begin <= max(at_s, min(said)))]
                 for at_s in self._times_s]  # fmt: skip
        for words in dict.fromkeys(texts):
            shown = ["1" if words == each else "0" for each in texts]
            yield (
                f'<text x="{x:g}" y="{y + 60:g}" opacity="{shown[0]}">{escape(words)}'
                f"{self._moving('opacity', shown, jumps=True)}</text>"
            )
        yield f'<text class="key" x="{x:g}" y="{y + 100:g}">{_KEY}</text>'

    def _moving(self, name: str, values: Sequence[str], *, jumps: bool = False) -> str:
        """Return the element by which an attribute takes these values one after the other."""
        if len(set(values)) == 1:
            return ""
        moving_s = self._report.duration_s / SPEED
        share = moving_s / self._lasts_s / (len(values) - 1)
        kept = [number for number in range(len(values)) if _matters(values, number, jumps)]
        times = [f"{number * share:.4f}" for number in kept]
        texts = [values[number] for number in kept]
        if not jumps:  # the last value stays while the picture holds
            times, texts = [*times, "1"], [*texts, texts[-1]]
        mode = ' calcMode="discrete"' if jumps else ""
        return (
            f'<animate attributeName="{name}" dur="{self._lasts_s:.2f}s" '
            f'repeatCount="indefinite"{mode} keyTimes="{";".join(times)}" '
            f'values="{";".join(texts)}"/>'
        )


def _matters(values: Sequence[str], number: int, jumps: bool) -> bool:
    """Return whether a viewer needs this value: one amid equal ones it does not."""
    if number == 0:
        return True
    changed = values[number - 1] != values[number]
    return changed or (not jumps and values[number : number + 2] != [values[number]] * 2)


def _pose(scene: RobotScene, at_s: float) -> Sequence[Place]:
    return scene.poses[max(0, bisect_right(scene.times_s, at_s) - 1)]


def _spanned(lane: Lane, at_s: float) -> bool:
    return any(span.start_s <= at_s <= span.end_s for span in lane.spans)


def _path(points: Iterable[Place]) -> str:
    return "M" + "L".join(" ".join(_numbers((x, -y))) for x, y in points)


def _numbers(values: Iterable[float]) -> list[str]:
    """Return lengths in millimetres, m before."""
    return [f"{value * _MM:.0f}" for value in values]


if __name__ == "__main__":
    PICTURE.write_text(drawn(), encoding="utf-8")
