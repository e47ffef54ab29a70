"""What a command uses, as a process of its own.

A new process has once been a copy of the one that started it, and the operating system counts that
among its memory. So a small process starts the command and reports its memory.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from typing import NamedTuple

_START = """
import json, os, subprocess, sys, time
began_s = time.perf_counter()
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, used = os.wait4(child.pid, 0)
child.returncode = os.waitstatus_to_exitcode(status)
wall_s = time.perf_counter() - began_s
memory = used.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
print(json.dumps([child.returncode, wall_s, used.ru_utime, used.ru_stime, memory]))
"""


class Used(NamedTuple):
    """What a command has used.

    Attributes:
        wall_s: Time on the wall.
        user_s: Processor time outside of the operating system; ``system_s`` inside.
        memory_bytes: Most memory at a time.
    """

    wall_s: float
    user_s: float
    system_s: float
    memory_bytes: int

    @property
    def processor_s(self) -> float:
        """Processor time."""
        return self.user_s + self.system_s


def used_by(*command: object, environment: Mapping[str, str] | None = None, code: int = 0) -> Used:
    """Run a command; return what it has used.

    Modules are stored when they have been compiled, as an installation does it, also where the
    environment forbids that.

    Args:
        command: Its words.
        environment: Its environment; by default that of this process.
        code: The exit code that it has to end with.

    Raises:
        RuntimeError: It has ended with another one.
    """
    around = {**(os.environ if environment is None else environment), "PYTHONDONTWRITEBYTECODE": ""}
    start = [sys.executable, "-S", "-c", _START, *map(str, command)]
    told = subprocess.run(start, env=around, check=True, stdout=subprocess.PIPE).stdout
    ended, *used = json.loads(told)
    if ended != code:
        raise RuntimeError(f"{command} ended with exit code {ended}")
    return Used(*used)
