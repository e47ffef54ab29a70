"""`pirate-run` in a copy of the process of the tests, which has everything loaded already.

A new process loads it for a second. How a command starts is tested in one: `test_start.py`.
"""

from __future__ import annotations

import os
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any, NoReturn

from pirate_sm.cli.commands import run  # noqa: F401 - loaded here, no copy has to
from pirate_sm.cli.entry import run_main


class ForkedRun(subprocess.Popen[str]):
    """Runs `pirate-run` with arguments that are text; in all else a process as any other."""

    def _execute_child(self, args: Sequence[str], *how: Any) -> None:
        prepare, cwd, env, pipes, new_session = how[1], *how[4:6], how[9:15], how[20]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # from Python 3.12 on: this process has threads
            self.pid = os.fork()
        if self.pid == 0:
            if new_session:
                os.setsid()
            _run(args, (pipes[0], pipes[3], pipes[5]), prepare, cwd, env)
        self._child_created = True
        self._close_pipe_fds(*pipes)


def _run(
    arguments: Sequence[str],
    ends: Sequence[int],
    prepare: Callable[[], None],
    folder: str,
    environment: Mapping[str, str],
) -> NoReturn:
    """Be the process that runs the mission; nothing of the tests' process stays open in it."""
    code: object = 1
    try:
        for number, end in enumerate(ends):
            os.dup2(end, number)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))
        prepare()
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.stdin, sys.stdout = os.fdopen(0, closefd=False), os.fdopen(1, "w", closefd=False)
        sys.stderr = os.fdopen(2, "w", closefd=False, errors="backslashreplace")
        sys.argv = ["-c", *arguments]
        run_main()
    except SystemExit as ended:
        code = ended.code
    except BaseException:
        traceback.print_exc()
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(Exception):  # this copy must not go on as tests
                stream.flush()
        os._exit(code if isinstance(code, int) else code is not None)
