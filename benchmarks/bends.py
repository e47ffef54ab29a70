"""The bend in real time over pseudo-terminals, and nothing goes wrong on purpose.

    python -m benchmarks.bends [--rounds 100] [--at-once 10]

Runner, guardian and emulated bay are processes of their own, as in `benchmarks.kills`. No run may
end in a fault, for none was injected, and the wheels must stand at the end, by the bay's truth. A
computer that is busy with something else stops these processes for a while, which is a fault of
its own (`runner.stalled`): run it on one that is otherwise quiet.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.rounds import Port, guardians, start_bay, start_runner, wait_until
from benchmarks.witness import driven_now

FAULTS = {3, 4}
"""Exit codes of a fault of the backend or the link, and of one in the program; those of the robot
end with the outcome ``fault`` instead."""

PATIENCE_S = 180.0


class Bend(NamedTuple):
    """What came of one run.

    Attributes:
        wrong: What must not be, in words; empty where all is well.
    """

    number: int
    code: int
    message: str
    wrong: str


def main() -> int:
    """Print a line for each run and a sum; return 1 when one ended in a fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--at-once", type=int, default=10)
    wishes = parser.parse_args()
    load = os.getloadavg()[0]
    bends: list[Bend] = []
    with TemporaryDirectory() as folder, ThreadPoolExecutor(wishes.at_once) as pool:
        ports = [Port(Path(folder) / f"bay{number}") for number in range(wishes.rounds)]
        for bend in pool.map(run, range(wishes.rounds), ports):
            bends.append(bend)
            wrong = f"  WRONG {bend.wrong}" if bend.wrong else ""
            print(f"{bend.number:3} exit {bend.code:3}  {bend.message}{wrong}", flush=True)
    codes = Counter(bend.code for bend in bends)
    bad = sum(bool(bend.wrong) for bend in bends)
    listed = ", ".join(f"exit {code}: {count}" for code, count in sorted(codes.items()))
    print(f"{len(bends)} bends, load {load:.1f} before: {listed}; {bad} went wrong")
    return 1 if bad else 0


def run(number: int, port: Port) -> Bend:
    """Run the mission once and judge it."""
    bay = start_bay(port)
    try:
        runner = start_runner(port)
        wait_until(lambda: runner.poll() is not None, PATIENCE_S)
        if runner.poll() is None:
            runner.kill()
        code = runner.wait()
        wait_until(lambda: not guardians(port), PATIENCE_S)
        end = _end(port)
        in_fault = end.get("outcome") == "fault" or code in FAULTS or code < 0
        wrong = "it ended in a fault" if in_fault else ""
        if driven_now(port.link):
            wrong = "wheels are driven"
        message = str(end.get("message") or port.err.read_text().strip())
        return Bend(number, code, message, wrong)
    finally:
        bay.kill()
        bay.communicate()


def _end(port: Port) -> dict[str, object]:
    """What the runner wrote last; empty where it wrote nothing."""
    lines = [line for line in port.out.read_text().splitlines() if line.endswith("}")]
    return dict(json.loads(lines[-1])) if lines else {}


if __name__ == "__main__":
    sys.exit(main())
