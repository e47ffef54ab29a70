"""What it costs to keep a run: speed, processor time, size.

    python -m benchmarks.recording [--repeats 5] [--minutes 10] [--real-time 20] [--bends 20]
    python -m benchmarks.recording --hours 10 [--keep long.mcap]

The same mission, up and down a straight pipe for ten minutes, with and without a recording; as
fast as it goes, and for a while in real time, where the share of one processor counts. Processor
time is that of the whole process, with the thread that writes.

Then a short mission as fast as it goes, in turn without a recording, with one, and with one that
has messages for viewers: what the recording adds to the user's processor time of the mission, from
its beginning to the closed file, and to that of the whole command.

With ``--hours`` so much mission time is recorded and then read by the commands that read
recordings, each as a process of its own: time on the wall, processor time, most memory. A file
named by ``--keep`` is made once and used again.
"""

from __future__ import annotations

import argparse
import resource
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

from benchmarks.used import Used, used_by
from pirate_sm.cli.run_recording import RecordingOptions, recorded
from pirate_sm.running.runtime.ending import Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring import Order, prepare

MISSION = Path(__file__).with_name("ten_minutes.yaml")
REPEATS = 5
REAL_TIME_S = 20.0
BEND = "mitre_bend"
BENDS = 20
"""Number of short missions of each kind."""

OVER = 1
"""Exit code of the long mission: it goes on until its time is over, which is a failure."""

PACED = 1e6
"""A speed at which nothing waits, but at which messages for viewers are recorded."""

KINDS = {"without": (False, inf), "with": (True, inf), "for viewers": (True, PACED)}
"""Whether a short mission is recorded, and at what speed it runs."""

TEN_MINUTES_S = 600.0


@dataclass
class Cost:
    """What a run took.

    Attributes:
        wall_s: On the wall.
        processor_s: On processors; ``user_s`` of it outside of the operating system.
        run_s: Mission time.
        size: Of the recording, bytes; ``beginning`` of what does not grow with time.
    """

    wall_s: float
    processor_s: float
    user_s: float
    run_s: float
    size: int
    beginning: int

    def size_of(self, run_s: float) -> float:
        """How large a recording of so much mission time is, bytes."""
        return self.beginning + (self.size - self.beginning) * run_s / self.run_s


class _Until:
    """Asks a run to stop at a mission time."""

    listening = False

    def __init__(self, at_s: float, requests: StopRequests) -> None:
        self.due_s = at_s
        self._requests = requests

    def react(self, effects: object, now_s: float) -> None:
        """Nothing."""

    def speak(self, now_s: float) -> tuple[()]:
        """The stop is asked for."""
        self.due_s = inf
        self._requests.ask(Stop("measured", 0))
        return ()


def measure_recording(
    repeats: int = REPEATS, minutes: float = inf, real_time_s: float = REAL_TIME_S
) -> None:
    """Costs with and without a recording are printed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        until_s = minutes * 60
        run_once(None, inf, until_s)
        # In turn, so that what else goes on meanwhile meets both.
        pairs = [
            (run_once(None, inf, until_s), run_once(folder / f"{n}.mcap", inf, until_s))
            for n in range(repeats)
        ]
        plain, real = (run_once(path, 1.0, real_time_s) for path in (None, folder / "real.mcap"))
    without, kept = ([pair[each] for pair in pairs] for each in (0, 1))
    before, after = (_median(costs, lambda c: c.run_s / c.wall_s) for costs in (without, kept))
    lost = median(1 - pair[0].wall_s / pair[1].wall_s for pair in pairs)
    print(f"    full speed: {before:,.0f} × real time without, {after:,.0f} × with a recording")
    print(f"        costs {lost:.0%} of the speed (median of {repeats} pairs)")
    before, after = (_median(costs, lambda c: c.processor_s) for costs in (without, kept))
    share = f"{1 - before / after:.0%} of it is the recording's"
    print(f"        processor time {before:.2f} s without, {after:.2f} s with, {share}")
    size = _median(kept, lambda c: c.size_of(TEN_MINUTES_S))
    print(f"        ten minutes: {size / 1e6:.1f} MB")
    print(f"    real time, {real_time_s:.0f} s: {_share(plain)} without, {_share(real)} with")
    print(f"        ten minutes: {real.size_of(TEN_MINUTES_S) / 1e6:.1f} MB")


def measure_short(bends: int = BENDS) -> None:
    """What a recording adds to a short mission is printed."""
    spent = short_runs(KINDS, bends)
    users_s = {kind: [cost.user_s for cost in costs] for kind, costs in spent.items()}
    print(f"    {BEND}, as fast as it goes, user's processor time, {bends} runs of each in turn")
    base = median(users_s["without"])
    print(f"        without a recording {base * 1e3:.1f} ms")
    for kind in ("with", "for viewers"):
        pairs = zip(users_s[kind], users_s["without"], strict=True)
        added = median(one / other - 1 for one, other in pairs)
        at = f"{median(users_s[kind]) * 1e3:.1f} ms"
        print(f"        {kind:17} {at}, {added:+.0%}; {spent[kind][-1].size / 1e3:.0f} kB")


def short_runs(kinds: Mapping[str, tuple[bool, float]], runs: int) -> dict[str, list[Cost]]:
    """Return what a short mission takes each time it is run in each of these ways."""
    spent: dict[str, list[Cost]] = {kind: [] for kind in kinds}
    with tempfile.TemporaryDirectory() as name:
        for number in range(runs + 1):
            for kind, (kept, factor) in kinds.items():  # in turn: see above
                path = Path(name) / f"{kind}_{number}.mcap" if kept else None
                cost = run_once(path, factor, inf, BEND)
                if number:  # the first is slower
                    spent[kind].append(cost)
    return spent


def measure_commands(repeats: int = REPEATS) -> None:
    """What a recording adds to the whole command is printed."""
    spent: dict[str, list[float]] = {"--no-record": [], "--record": []}
    with tempfile.TemporaryDirectory() as name:
        for number in range(repeats + 1):
            for option, found in spent.items():
                file = [Path(name) / f"{number}.mcap"] if option == "--record" else []
                used = _used("run", BEND, "--speed", "max", "-q", option, *file)
                if number:
                    found.append(used.user_s)
    without, kept = (median(found) for found in spent.values())
    print(f"        the command {without:.2f} s without, {kept:.2f} s with a recording")


def _share(cost: Cost) -> str:
    return f"{cost.processor_s / cost.wall_s:.2%} of a processor"


def _median(costs: list[Cost], of: Callable[[Cost], float]) -> float:
    return median(map(of, costs))


def run_once(path: Path | None, factor: float, until_s: float, mission: str = str(MISSION)) -> Cost:
    """Run the mission up to a time, and return what it took; the recording goes to the path."""
    prepared = prepare(Order(mission))
    wishes = RecordingOptions(record=str(path) if path else None, off=path is None)
    requests = StopRequests()
    began_s, spent_s, user_s = perf_counter(), process_time(), user_time_s()
    with recorded(prepared, wishes, factor) as kept:
        run = MissionRun(
            prepared.engine, prepared.backend, tap=kept.tap, requests=requests, factor=factor,
            companions=(
                *prepared.companions, *kept.companions, FirstChoice(), _Until(until_s, requests),
            ),
        )  # fmt: skip
        kept.follow(run)
        beginning = path.stat().st_size if path else 0
        result = run.execute()
    wall_s, processor_s = perf_counter() - began_s, process_time() - spent_s
    size = path.stat().st_size if path else 0
    return Cost(wall_s, processor_s, user_time_s() - user_s, result.now_s, size, beginning)


def user_time_s() -> float:
    """Return the processor time of this process so far, s, outside of the operating system."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def measure_long(hours: float, kept: Path | None) -> None:
    """What reading a long recording costs is printed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = kept or folder / "long.mcap"
        if not path.exists():
            made = (
                "run",
                _lasting(folder, hours),
                "--no-check",
                "-q",
                "--speed",
                "max",
                "--record",
                path,
            )
            _command(*made, code=OVER)
        size = path.stat().st_size
        print(f"    {hours:g} h of mission time, {size / 1e6:.0f} MB")
        torn = folder / "torn.mcap"
        with path.open("rb") as whole, torn.open("wb") as file:
            while block := whole.read(1 << 20):
                file.write(block)
            file.truncate(size * 99 // 100)
        _command("replay", path, "--jobs", 1)
        _command("replay", path)
        _command("replay", path, "--from", f"{hours * 0.9:g} h", "--until", f"{hours * 0.91:g} h")
        _command("repair", torn)
        _command("report", path, "-o", folder / "long.html")


def record(path: Path, hours: float) -> None:
    """Record so much mission time."""
    run_once(path, inf, inf, str(_lasting(path.parent, hours)))


def _lasting(folder: Path, hours: float) -> Path:
    """Return the file of the same mission that lasts so long."""
    mission, text = folder / "long.yaml", MISSION.read_text(encoding="utf-8")
    mission.write_text(text.replace("10 min", f"{hours:g} h"), encoding="utf-8")
    return mission


def _command(*arguments: object, code: int = 0) -> None:
    """The command has been run; what it took is printed."""
    words = [str(each) for each in arguments]
    used = _used(*words, code=code)
    what = " ".join(word for word in words if "/" not in word)
    print(
        f"        {what:<46} {used.wall_s:6.1f} s, {used.processor_s:6.1f} s of processors, "
        f"{used.memory_bytes / 1e6:5.0f} MB"
    )


def _used(*arguments: object, code: int = 0) -> Used:
    """Return what the command has used.

    Raises:
        RuntimeError: It has ended with another exit code.
    """
    program = "from pirate_sm.cli.entry import main; main()"
    return used_by(sys.executable, "-c", program, *arguments, code=code)


def main() -> int:
    """Print what was measured."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=REPEATS, help="of long runs, and commands")
    parser.add_argument("--minutes", type=float, default=inf, help="of the long runs")
    parser.add_argument("--real-time", type=float, default=REAL_TIME_S, help="how long, in s")
    parser.add_argument("--bends", type=int, default=BENDS, help="short missions of each kind")
    parser.add_argument("--hours", type=float, help="length of the recording to read, in hours")
    parser.add_argument("--keep", type=Path, help="the long recording, made where it is missing")
    given = parser.parse_args()
    if given.hours:
        measure_long(given.hours, given.keep)
    else:
        measure_recording(given.repeats, given.minutes, given.real_time)
        measure_short(given.bends)
        measure_commands(given.repeats)
    return 0


if __name__ == "__main__":
    sys.exit(main())
