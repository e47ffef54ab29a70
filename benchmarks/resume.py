"""Missions that are cut off at random moments and resumed, judged by the emulated bay's truth.

    python -m benchmarks.resume [--virtual 950] [--real 50] [--lies 40] [--hours 10] [--seed 0]

In virtual time, over all shipped missions: the runner dies, runner and guardian, the bay, or
everything loses power. A person agrees to what no sensor shows, and says where the robot is if
nobody knows. In real time, over a pseudo-terminal: the processes are killed, and `pirate run
--resume --accept` goes on alone. Each ends with success, with the mission's own failure or with a
reasoned refusal; that no part grips where the run left alone always has a grip is a let-go. Lies
are told in virtual time without a person: they must be refused or asked about, or do no harm.
Last the time is measured that the decision takes for a recording of that many hours.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from itertools import cycle, islice
from math import inf
from multiprocessing import get_context
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.long_recording import write_long_recording
from benchmarks.resume_rides import (
    ALIVE,
    KINDS,
    LIES,
    LOOSE_S,
    Case,
    Ride,
    alone,
    grips,
    loaded_mission,
    missions,
    ride,
)
from benchmarks.rounds import MISSION, Port, guardians, start_bay, start_runner, wait_until
from benchmarks.witness import samples_of
from pirate_sm.core.events import Tick
from pirate_sm.running.recording.format.header import header_of
from pirate_sm.running.recording.write.recorder import AHEAD_S, Recorder
from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile

PATIENCE_S = 120.0
BEGINS_S, ENDS_S = 3.0, 30.0
"""Moments of the real runs, since the runner was started: it connects in 2.5 s."""

DARK_S = (0.3, 5.0)
LIE_DARK_S = 2.0
COMMANDS, STEPS_APART_S = 200, 0.01
_PIRATE = "from pirate_sm.cli.entry import run_main; run_main()"
_REAL = ("runner", "guardian", "runner and guardian", "bay", "power")


class Real(NamedTuple):
    """A moment of a real run, and what came of it; ``wrong`` is what must not be, in words."""

    kind: str
    at_s: float
    how: str
    said: str
    wrong: str = ""


def main() -> int:
    """What came of every case is printed; 1 if a rule was broken."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--virtual", type=int, default=950)
    parser.add_argument("--real", type=int, default=50)
    parser.add_argument("--lies", type=int, default=40)
    parser.add_argument("--hours", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--at-once", type=int, default=4, help="real runs at the same time")
    wishes = parser.parse_args()
    random, good = Random(wishes.seed), True
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        cases = list(islice(_cases(random), wishes.virtual))
        good &= _tell_rides(list(_told(pool.map(_ride, cases))))
        lies = list(islice(_lies(random), wishes.lies))
        good &= _tell_lies(list(_told(pool.map(partial(_ride, operator=False), lies))))
    kinds = list(islice(cycle(_REAL), wishes.real))
    with TemporaryDirectory() as folder, ThreadPoolExecutor(wishes.at_once) as threads:
        moments = [(kind, random.uniform(BEGINS_S, ENDS_S)) for kind in kinds]
        ports = [Port(Path(folder, f"bay{number}")) for number in range(len(kinds))]
        good &= _tell_real(list(threads.map(_real, moments, ports)))
    _tell_ahead()
    if wishes.hours:
        _tell_decision(wishes.hours)
    return 0 if good else 1


# --- virtual time -----------------------------------------------------------------------------


def _cases(random: Random) -> Iterator[Case]:
    names = missions()
    for number, mission in enumerate(cycle(names)):
        kind = KINDS[number // len(names) % len(KINDS)]
        yield Case(mission, kind, random.random(), random.uniform(*DARK_S))


def _lies(random: Random) -> Iterator[Case]:
    for lie in cycle(LIES):
        yield Case(MISSION, "runner", random.uniform(0.2, 0.9), LIE_DARK_S, lie=lie)


def _ride(case: Case, operator: bool = True) -> Ride:
    try:
        return ride(case, operator)
    except Exception as error:
        return Ride(case, "error", f"{type(error).__name__}: {error}")


def _told(rides: Iterable[Ride]) -> Iterator[Ride]:
    for it in rides:
        case = it.case
        if it.how not in ("success",) or case.lie:
            print(
                f"{it.how:8} {case.mission:22} {case.lie or case.kind:20} at {case.share:6.1%} "
                f"{it.phase}: {it.why}",
                flush=True,
            )
        yield it


def _tell_rides(rides: list[Ride]) -> bool:
    if not rides:
        return True
    for kind in KINDS:
        mine = [it for it in rides if it.case.kind == kind]
        counts = Counter(it.how for it in mine)
        asked = sum(bool(it.asked) for it in mine)
        print(f"{kind:20} {len(mine):4}: {_counts(counts)}; asked in {asked}")
    alive = [it for it in rides if it.case.kind in ALIVE]
    went_on = [it for it in alive if it.how in ("success", "failure")]
    ended = sum((it.how == "success") == _succeeds(it.case) for it in went_on)
    same = sum(it.same for it in went_on)
    if went_on:
        print(
            f"of {len(went_on)} resumed with the bay alive, {ended} ended as the run left alone "
            f"({ended / len(went_on):.1%}), {same} through the same configurations"
        )
    bad = [it for it in rides if it.how in ("let go", "error")]
    print(f"{len(rides)} cut off in virtual time, {len(bad)} broke a rule\n")
    return not bad


def _succeeds(case: Case) -> bool:
    return alone(case.mission, case.seed).outcome == "succeeded"


def _tell_lies(rides: list[Ride]) -> bool:
    if not rides:
        return True
    for lie in LIES:
        mine = [it for it in rides if it.case.lie == lie]
        print(f"{lie:20} {len(mine):4}: {_counts(Counter(it.how for it in mine))}")
    bad = [it for it in rides if it.how in ("let go", "error")]
    print(f"{len(rides)} lies, {len(bad)} broke a rule\n")
    return not bad


def _counts(counts: Counter[str]) -> str:
    return ", ".join(f"{number} {how}" for how, number in counts.most_common())


# --- real time --------------------------------------------------------------------------------


def _real(moment: tuple[str, float], port: Port) -> Real:
    kind, at_s = moment
    bay = start_bay(port)
    try:
        runner = start_runner(port)
        time.sleep(at_s)
        _kill(kind, runner, bay, port)
        runner.wait(PATIENCE_S)
        if bay.poll() is not None or kind in ("bay", "power"):
            bay.kill()
            bay.wait()
            port.link.unlink(missing_ok=True)
            bay = start_bay(port)  # another robot, at the start of the pipe
        wait_until(lambda: not guardians(port), PATIENCE_S)
        done = subprocess.run(
            [
                *(sys.executable, "-c", _PIRATE, "--resume", str(port.link.with_suffix(".mcap"))),
                *("--port", str(port.link), "--accept", "--json", "--no-record"),
            ],
            capture_output=True, text=True, check=False, timeout=PATIENCE_S,
        )  # fmt: skip
        wrong = _judge(port, kind)
    finally:
        bay.kill()
        bay.communicate()
    said = [*done.stderr.strip().splitlines(), *_end_in(done.stdout)]
    how = {0: "success", 1: "failure", 2: "refused", 3: "failure"}.get(done.returncode, "error")
    if how == "error" or "Traceback" in done.stderr:
        wrong = f"exit code {done.returncode}"
    return Real(kind, at_s, how, said[-1] if said and how != "success" else "", wrong)


def _end_in(lines: str) -> Iterator[str]:
    """Yield the message of the mission's end in the runner's output, if it is there."""
    for line in lines.splitlines()[-1:]:
        end = json.loads(line)
        if end["type"] == "end":
            yield str(end["message"])


def _kill(
    kind: str, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str], port: Port
) -> None:
    if kind in ("bay", "power"):
        bay.kill()
    if kind in ("guardian", "runner and guardian", "power"):
        if kind != "guardian":
            runner.send_signal(signal.SIGSTOP)  # it shall not start another one
        for pid in guardians(port):
            os.kill(pid, signal.SIGKILL)
    if kind != "guardian":
        runner.kill()


def _judge(port: Port, kind: str) -> str:
    """Return what is wrong by the truth: that no part has gripped for a while after one did."""
    if kind in ("bay", "power"):
        return ""
    loaded, since_s, ever = loaded_mission(MISSION), inf, False
    for sample in samples_of(port.link):
        if grips(loaded, sample.torques_nm):
            since_s, ever = inf, True
        since_s = min(since_s, sample.at_s)
        if ever and sample.at_s > since_s + LOOSE_S and not grips(loaded, sample.torques_nm):
            return f"no part gripped at {sample.arcs_m[0]:.2f} m"
    return ""


def _tell_real(done: list[Real]) -> bool:
    if not done:
        return True
    for it in done:
        wrong = f"  WRONG {it.wrong}" if it.wrong else ""
        print(f"{it.how:8} {it.kind:20} at {it.at_s:4.1f} s: {it.said}{wrong}", flush=True)
    bad = sum(bool(it.wrong) for it in done)
    counts = _counts(Counter(it.how for it in done))
    print(f"{len(done)} cut off in real time: {counts}; {bad} broke a rule")
    return not bad


# --- the disk ---------------------------------------------------------------------------------


def _tell_ahead() -> None:
    """Measure how long a command waits until its step is on the disk of the temporary folder."""
    loaded = loaded_mission(MISSION)
    header = header_of(
        loaded, backend="sim", nominal=False, detector="sim", options={}, began=datetime.now(UTC)
    )
    with TemporaryDirectory() as folder:
        file = RecordingFile(DiskFile(Path(folder, "ahead.mcap")), header)
        keeper = Recorder(file, header, real_time=True)
        waited_s = []
        for number in range(COMMANDS):
            keeper.take(Tick(), number * STEPS_APART_S, ())
            began_s = time.perf_counter()
            keeper.secure()
            waited_s.append(time.perf_counter() - began_s)
        keeper.close()
    late = sum(each > AHEAD_S for each in waited_s)
    print(
        f"a command waits {median(waited_s) * 1000:.1f} ms for the disk (median of {COMMANDS}), "
        f"at most {max(waited_s) * 1000:.1f} ms; {late} were sent before it had answered"
    )


# --- the decision -----------------------------------------------------------------------------


def _tell_decision(hours: float) -> None:
    """Measure how long it takes to know the end of a long recording, in a process of its own."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "long.mcap")
        write_long_recording(path, hours)
        size_mb = path.stat().st_size / 1e6
        code = (
            "import sys, time; from pathlib import Path\n"
            "from pirate_sm.running.wiring.resume_offer import end_of_run\n"
            "end_of_run(Path(sys.argv[2]))  # what is loaded once\n"
            "began = time.perf_counter(); end = end_of_run(Path(sys.argv[1]))\n"
            "read = time.perf_counter(); end.recording.sha256\n"
            "print(end.last_s, read - began, time.perf_counter() - read)"
        )
        short = Path(folder, "short.mcap")
        write_long_recording(short, 0.01)
        done = subprocess.run(
            [sys.executable, "-c", code, str(path), str(short)],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
    last_s, took_s, hashed_s = map(float, done.stdout.split())
    print(
        f"recording of {last_s / 3600:.1f} h, {size_mb:.0f} MB: its end known after {took_s:.2f} s,"
        f" its SHA-256 after another {hashed_s:.2f} s"
    )


if __name__ == "__main__":
    sys.exit(main())
