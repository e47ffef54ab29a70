"""The bend over a real pseudo-terminal, and something dies at a random moment of it.

    python -m benchmarks.kills [--rounds 200] [--seed 0] [--at-once 8] [--no-dead-man]

Runner, its guardian and the emulated bay are processes of their own, in real time. At a random
moment one of them or two are killed, asked to end, stopped for a while or for good, or the cable is
out, for longer than anybody waits too. The bay writes down its truth; once the line is back the
wheels must stand, clamped joints must stay where they came to rest when the wheels stopped, the
runner must have ended with the exit code that is documented and with one sentence, no process may
be left, and a second program must get the port.

The bay's firmware has the dead man's switch of the profile, which stops wheels when nobody else
does. `--no-dead-man` leaves it out, to judge what runner and guardian do by themselves.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import cycle, islice
from math import copysign, degrees, nan, radians
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from benchmarks.rounds import Port, connect_again, guardians, start_bay, start_runner, wait_until
from benchmarks.witness import (
    CABLE_OUT_LONG_S,
    CABLE_OUT_S,
    NO_DEAD_MAN,
    SAMPLE_EVERY_S,
    Sample,
    driven_now,
    samples_of,
)

BEGINS_AFTER_S, ENDS_BEFORE_S = 0.1, 33.0
"""Since the runner was started; the mission itself takes 32 s, the start 2.5 s."""

DRIVES_BEFORE_S = 25.0
DRIVES_FOR_S = 0.5
"""Wheels are driven for a sixth of the mission: every second moment of a kind is one of these."""

STANDS_STILL_S = 1.0
DIES_AFTER_S = 0.3
PATIENCE_S = 60.0
WATCH_ON_S = 1.0
"""Longer than the dead man's switch takes."""

SETTLES_S = 0.5
"""How long what the wheels have pushed takes to settle after they were stopped."""

MOST_RAD = radians(10)
"""No clamped joint may be pushed open by more, whatever pushes it."""

GUARDED = f"runner: stopped {STANDS_STILL_S:g} s"
"""Wheels are driven whenever this happens: at rest the guardian has nothing to do (decision 99)."""

STILL_RAD, HELD_RAD = 0.02, 0.05
"""A joint that moved less in a second of the same duty clamped; one that moved less since held."""


@dataclass
class Case:
    """One moment and what came of it.

    Attributes:
        at_s: Since the runner was started.
        driving: Whether wheels shall be driven: it waits until they are, and a little longer.
        options: For the bay.
        broken: What must not be, in words.
        stopped_s: When the last wheel had been told to stand; None: it had not been driven.
        gone_s: When the last process of the run had ended, after the runner.
    """

    kind: str
    seed: int
    at_s: float
    driving: bool
    folder: Path
    options: tuple[str, ...] = ()
    doing: str = "starting"
    code: int | None = None
    said: str = ""
    stopped_s: float | None = None
    moved_deg: float | None = None
    gone_s: float = 0.0
    broken: list[str] = field(default_factory=list)

    @property
    def port(self) -> Port:
        """Where the bay is."""
        return Port(self.folder / f"bay{self.seed}")

    @property
    def stops(self) -> bool:
        """Whether anything is left that can stop wheels."""
        return KINDS[self.kind].stops or NO_DEAD_MAN not in self.options


class Kind(NamedTuple):
    """Something that happens to a run.

    Attributes:
        codes: Exit codes that are documented for it.
        act: Does it, to the runner and the bay.
        alive: Whether the device is still there afterwards.
        stops: Whether a program is left that can stop it.
        words: Whether the runner can still say something.
        goes_on: Whether the mission is to go on as if nothing had happened.
    """

    codes: tuple[int, ...]
    act: Callable[[Case, subprocess.Popen[bytes], subprocess.Popen[str]], None]
    alive: bool = True
    stops: bool = True
    words: bool = True
    goes_on: bool = False


def main() -> int:
    """A line for each moment and one for each kind is printed; 1 when a rule was broken."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--at-once", type=int, default=8)
    parser.add_argument("--only", default="", help="kinds that begin like this")
    parser.add_argument(NO_DEAD_MAN, action="store_true", help="the firmware stops nothing itself")
    wishes = parser.parse_args()
    random = Random(wishes.seed)
    options = (NO_DEAD_MAN,) if wishes.no_dead_man else ()
    kinds = [kind for kind in KINDS if kind.startswith(wishes.only)]
    with TemporaryDirectory() as folder, ThreadPoolExecutor(wishes.at_once) as pool:
        cases = [
            _case(kind, seed, seed // len(kinds) % 2 == 1, random, Path(folder), options)
            for seed, kind in enumerate(islice(cycle(kinds), wishes.rounds))
        ]
        done = []
        for case in pool.map(run, cases):
            done.append(case)
            print(_line(case), flush=True)
    return _sum_up(done)


def _case(
    kind: str, seed: int, driving: bool, random: Random, folder: Path, options: tuple[str, ...]
) -> Case:
    last_s = DRIVES_BEFORE_S if driving else ENDS_BEFORE_S
    return Case(kind, seed, random.uniform(BEGINS_AFTER_S, last_s), driving, folder, options)


# --- one moment ---------------------------------------------------------------------------------


def run(case: Case) -> Case:
    """The mission has been run until the moment, and what followed has been judged."""
    kind, port = KINDS[case.kind], case.port
    bay = start_bay(port, *case.options)
    try:
        runner = start_runner(port)
        began_s = time.monotonic()
        time.sleep(case.at_s)
        if case.driving or case.kind == GUARDED:
            extra_s = case.at_s % DRIVES_FOR_S
            _await(
                lambda: runner.poll() is not None or driven_now(port.link), case, "it never drove"
            )
            time.sleep(extra_s)
        if case.kind.startswith(("guardian", "cable", "runner, guardian")):
            _await(lambda: runner.poll() is not None or bool(guardians(port)), case, "none began")
        acted_s = time.monotonic()
        case.at_s = acted_s - began_s
        if runner.poll() is not None:
            case.broken.append("the run had ended before")
        else:
            kind.act(case, runner, bay)
        code = _ended(runner, case)
        case.code = 128 - code if code < 0 else code  # as a shell shows it
        if not kind.alive:
            bay.wait()
            bay = start_bay(port, *case.options)  # a guardian waits for it
        left_s = time.monotonic()
        _await(lambda: not guardians(port), case, "a process was left")
        case.gone_s = time.monotonic() - left_s
        _await(port.link.exists, case, "the port never came back")
        time.sleep(WATCH_ON_S)
        _judge_words(case, port.out.read_text(), port.err.read_text())
        if kind.alive:
            _judge_truth(case, acted_s)
        if refused := connect_again(port):
            case.broken.append(f"no second run: {refused}")
    finally:
        bay.kill()
        bay.communicate()
    return case


def _ended(runner: subprocess.Popen[bytes], case: Case) -> int:
    try:
        return runner.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        case.broken.append("the runner did not end")
        runner.kill()
        return runner.wait()


def _await(true: Callable[[], bool], case: Case, else_: str) -> None:
    if not wait_until(true, PATIENCE_S):
        case.broken.append(else_)


def _judge_words(case: Case, out: str, err: str) -> None:
    """How the runner ended is what is documented, and what it said is one sentence."""
    kind = KINDS[case.kind]
    lines: list[dict[str, Any]] = [json.loads(line) for line in out.splitlines() if line[-1] == "}"]
    case.doing = next((x["phase"] for x in reversed(lines) if x["type"] == "phase"), case.doing)
    last = lines[-1] if lines else {}
    case.said = str(last.get("message", "")) if last.get("type") == "end" else err.strip()
    if case.code not in kind.codes:
        case.broken.append(f"exit code {case.code}, documented {kind.codes}")
    if "Traceback" in err or "\n" in case.said:
        case.broken.append(f"more than a sentence: {err}")
    if kind.words and not case.said and out:
        case.broken.append("no word about it")  # beyond its start


def _judge_truth(case: Case, acted_s: float) -> None:
    """Wheels stand, and joints that clamped stay where they are once the last wheel has stopped.

    Wheels that are driven until then move joints, too, and what they pushed settles. A joint that
    keeps its duty is not let go of: it may close further, which completes a clamp that had not
    ended, and may be pushed open by ``MOST_RAD``. Opening the port resets the bay: then every duty
    is zero until the last array is sent again. From another duty on it may move by ``HELD_RAD``.
    """
    samples = list(samples_of(case.port.link))
    before = [sample for sample in samples if sample.at_s <= acted_s]
    after = [sample for sample in samples if sample.at_s > acted_s]
    driven = [sample.at_s for sample in after if any(sample.wheels)]
    if any(before[-1].wheels) or driven:
        case.stopped_s = max([*driven, acted_s]) - acted_s + SAMPLE_EVERY_S
    if any(after[-1].wheels) == case.stops and any(before[-1].wheels):
        case.broken.append("wheels are driven" if case.stops else "somebody stopped the wheels")
    if KINDS[case.kind].goes_on and case.code == 0:
        return  # the mission has moved joints as it should
    stood = before[-1]
    if driven:
        stood = next((each for each in after if each.at_s > driven[-1] + SETTLES_S), after[-1])
    second = before[max(0, len(before) - round(1.0 / SAMPLE_EVERY_S)) :]
    clamped = {
        at: duty
        for at, duty in enumerate(before[-1].joints)
        if duty
        and all(sample.joints[at] == duty for sample in second)
        and abs(before[-1].bends_rad[at] - second[0].bends_rad[at]) < STILL_RAD
    }
    for joint, duty in clamped.items():
        changed = [each for each in after if each.joints[joint] != duty and any(each.joints)]
        until = changed[0] if changed else after[-1]
        pushed = copysign(1.0, duty) * (stood.bends_rad[joint] - until.bends_rad[joint])
        let_go = abs(after[-1].bends_rad[joint] - until.bends_rad[joint])
        case.moved_deg = max(case.moved_deg or 0.0, degrees(pushed), degrees(let_go))
        if pushed > MOST_RAD or let_go > HELD_RAD:
            duties = _course(joint, [before[-1], *after], acted_s)
            moved_deg = degrees(max(pushed, let_go))
            case.broken.append(f"clamped joint {joint} moved by {moved_deg:.0f} deg: {duties}")


def _course(joint: int, samples: list[Sample], acted_s: float) -> str:
    """Return the duties that a joint had since the event, with its angle when each began."""
    words = []
    duty = nan
    for sample in samples:
        if sample.joints[joint] != duty:
            duty = sample.joints[joint]
            angle_deg = degrees(sample.bends_rad[joint])
            words.append(f"duty {duty:g} at {sample.at_s - acted_s:.2f} s ({angle_deg:.0f} deg)")
    return ", ".join(words)


# --- what happens -------------------------------------------------------------------------------


def _signal(number: signal.Signals) -> Callable[..., None]:
    """The terminal sends it to the whole group; a stop of the group is not for the guardian."""

    def act(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
        os.killpg(runner.pid, number)

    return act


def _pause(seconds: float, *, everybody: bool) -> Callable[..., None]:
    """The runner stands still for this long, or the guardian with it, as when the machine does."""

    def act(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
        pids = [runner.pid, *(guardians(case.port) if everybody else [])]
        for number, then_s in ((signal.SIGSTOP, seconds), (signal.SIGCONT, 0.0)):
            for pid in pids:
                os.kill(pid, number)
            time.sleep(then_s)

    return act


def _guardian(number: signal.Signals) -> Callable[..., None]:
    def act(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
        for pid in guardians(case.port):
            os.kill(pid, number)

    return act


def _hung(number: signal.Signals) -> Callable[..., None]:
    """The guardian hangs, and the runner gets this signal at the same time."""

    def act(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
        for pid in guardians(case.port):
            os.kill(pid, signal.SIGSTOP)
        runner.send_signal(number)

    return act


def _vanishing(number: signal.Signals) -> Callable[..., None]:
    """The port goes away, and the runner dies before it is back."""

    def act(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
        bay.send_signal(number)
        time.sleep(DIES_AFTER_S)
        runner.kill()

    return act


def _both(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
    runner.send_signal(signal.SIGSTOP)
    for pid in guardians(case.port):
        os.kill(pid, signal.SIGKILL)
    runner.kill()


def _bay(number: signal.Signals) -> Callable[..., None]:
    def act(case: Case, runner: subprocess.Popen[bytes], bay: subprocess.Popen[str]) -> None:
        bay.send_signal(number)
        if number == signal.SIGKILL:
            case.port.link.unlink()  # what it points to may soon be another pseudo-terminal

    return act


_BY_SIGNAL = 128 + signal.SIGKILL
KINDS = {
    "runner: kill -9": Kind((_BY_SIGNAL,), _signal(signal.SIGKILL), words=False),
    "runner: SIGTERM": Kind((143,), _signal(signal.SIGTERM)),
    "runner: SIGINT": Kind((130,), _signal(signal.SIGINT)),
    "runner: SIGHUP": Kind((129,), _signal(signal.SIGHUP)),
    "runner: stopped 0.2 s": Kind((0,), _pause(0.2, everybody=False), goes_on=True),
    GUARDED: Kind((3,), _pause(STANDS_STILL_S, everybody=False)),
    "runner, guardian: stopped 0.2 s": Kind((0,), _pause(0.2, everybody=True), goes_on=True),
    "runner, guardian: stopped 1 s": Kind(
        (0, 3), _pause(STANDS_STILL_S, everybody=True), goes_on=True
    ),
    "guardian: hangs": Kind((3,), _guardian(signal.SIGSTOP)),
    "guardian: hangs, runner: SIGTERM": Kind((143,), _hung(signal.SIGTERM)),
    "guardian: kill -9": Kind((3,), _guardian(signal.SIGKILL)),
    "guardian: SIGTERM": Kind((3,), _guardian(signal.SIGTERM)),
    "bay: kill -9": Kind((3,), _bay(signal.SIGKILL), alive=False),
    f"cable out for {CABLE_OUT_S:g} s": Kind((3,), _bay(signal.SIGUSR1)),
    f"cable out for {CABLE_OUT_LONG_S:g} s": Kind((3,), _bay(signal.SIGUSR2)),
    f"cable out for {CABLE_OUT_S:g} s, runner: kill -9": Kind(
        (_BY_SIGNAL,), _vanishing(signal.SIGUSR1), words=False
    ),
    f"cable out for {CABLE_OUT_LONG_S:g} s, runner: kill -9": Kind(
        (_BY_SIGNAL,), _vanishing(signal.SIGUSR2), words=False
    ),
    "guardian and runner: kill -9": Kind((_BY_SIGNAL,), _both, stops=False, words=False),
}


# --- telling ------------------------------------------------------------------------------------


def _line(case: Case) -> str:
    stopped = "-" if case.stopped_s is None else f"{case.stopped_s * 1000:.0f}"
    moved = "-" if case.moved_deg is None else f"{case.moved_deg:.1f}"
    wrong = f"  WRONG {'; '.join(case.broken)}" if case.broken else ""
    return (
        f"{case.seed:3} {case.kind:38} {case.at_s:5.1f} s {case.doing:10} exit {case.code:4} "
        f"wheels {stopped:>5} ms, clamps {moved:>4} deg, port {case.gone_s * 1000:5.0f} ms  "
        f"{case.said}{wrong}"
    )


def _sum_up(cases: list[Case]) -> int:
    """A line for each kind."""
    print(f"\n{'':38} moments  driving  wheels stopped after, ms  joints moved at most, deg")
    for kind in dict.fromkeys(case.kind for case in cases):
        mine = [case for case in cases if case.kind == kind]
        stops = [case.stopped_s * 1000 for case in mine if case.stopped_s is not None]
        moved = [case.moved_deg for case in mine if case.moved_deg is not None]
        spread = f"{median(stops):.0f} (most {max(stops):.0f})" if stops else "-"
        if KINDS[kind].goes_on or not mine[0].stops:
            spread = "goes on" if KINDS[kind].goes_on else "never"
        most = f"{max(moved):.1f}" if moved else "-"
        print(f"{kind:38} {len(mine):7} {len(stops):8}  {spread:>24} {most:>27}")
    bad = sum(bool(case.broken) for case in cases)
    print(f"{len(cases)} rounds, {bad} broke a rule")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
