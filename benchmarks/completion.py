"""How long a shell waits for the values that fit on a command line.

    python -m benchmarks.completion [--repeats 9]

The installed command is asked as the scripts of `pirate completion` ask it, each line as a process
of its own, all lines in turn. Printed are the least and the median time on the wall, and the least
processor time, which other work on the machine changes less.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from statistics import median

from benchmarks.used import Used, used_by
from pirate_sm.cli.completion import ASKING
from pirate_sm.cli.completion.answer import LINE

REPEATS = 9

LINES = (
    "pirate ",
    "pirate run --",
    "pirate run ",
    "pirate run --robot ",
    "pirate run --pipe ",
    "pirate run --backend ",
    "pirate run mitre_bend --from ",
    "pirate run mitre_bend --set ",
    "pirate run mitre_bend --state ",
    "pirate run --robot pirate_ii_imu --defect ",
    "pirate graph ",
    "pirate check ",
    "pirate explain ",
)


def main() -> int:
    """Measure and print everything; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=REPEATS)
    wishes = parser.parse_args()
    command = str(Path(sys.executable).with_name("pirate"))
    asked = {line: {**os.environ, ASKING: "zsh", LINE: line} for line in LINES}
    used: dict[str, list[Used]] = {"Python alone": [], **{line: [] for line in LINES}}
    for _ in range(wishes.repeats):  # in turn, so that other work on the machine falls on all alike
        used["Python alone"].append(used_by(sys.executable, "-c", ""))
        for line, environment in asked.items():
            used[line].append(used_by(command, environment=environment))
    print(f"{'':44} {'least':>7} {'median':>7} {'processor':>10}")
    for line, each in used.items():
        least_s, middle_s = min(one.wall_s for one in each), median(one.wall_s for one in each)
        processor_s = min(one.processor_s for one in each)
        times = f"{least_s * 1e3:4.0f} ms {middle_s * 1e3:4.0f} ms {processor_s * 1e3:7.0f} ms"
        print(f"{line:44} {times}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
