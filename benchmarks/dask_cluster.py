"""A Dask cluster of processes on this machine, which can be killed, over TCP on loopback."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from threading import Thread

_LISTENING = "Scheduler at:"


class Cluster:
    """A scheduler and its workers of one thread, each a process.

    Attributes:
        address: Where the scheduler listens.
        scheduler: Its process.
    """

    def __init__(self, stack: ExitStack) -> None:
        """Start the scheduler and wait until it listens; the stack ends it and all workers."""
        self._stack = stack
        port = str(_free_port())
        self.address = f"tcp://127.0.0.1:{port}"
        wanted = ("--host", "127.0.0.1", "--port", port, "--no-dashboard", "--no-show")
        self.scheduler = stack.enter_context(_started("scheduler", *wanted))
        assert self.scheduler.stderr is not None
        for line in self.scheduler.stderr:
            if _LISTENING in line:
                break
        _drain(self.scheduler)

    def add_worker(self) -> subprocess.Popen[str]:
        """Start a worker, which joins the scheduler by itself; return its process."""
        words = ("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        worker = self._stack.enter_context(_started(*words, "--host", "127.0.0.1"))
        _drain(worker)
        return worker


class Relay:
    """Passes connections on to a scheduler, until it cuts them.

    Attributes:
        address: Where it listens.
    """

    def __init__(self, to: str) -> None:
        host, _, port = to.removeprefix("tcp://").rpartition(":")
        self._to = host, int(port)
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self._listening.getsockname()[1]}"
        self._open: list[socket.socket] = []

    def __enter__(self) -> Relay:
        Thread(target=self._serve, daemon=True).start()
        return self

    def __exit__(self, *error: object) -> None:
        self._listening.close()
        self.cut()

    def cut(self) -> int:
        """Cut all connections; new ones are passed on. Return how many ends were cut."""
        ends, self._open = self._open, []
        cut = 0
        for each in ends:
            try:
                each.shutdown(socket.SHUT_RDWR)
            except OSError:
                continue
            cut += 1
        return cut

    def _serve(self) -> None:
        while True:
            try:
                near, _ = self._listening.accept()
                far = socket.create_connection(self._to)
            except OSError:
                return
            self._open += [near, far]
            for one, other in ((near, far), (far, near)):
                Thread(target=_pass_on, args=(one, other), daemon=True).start()


def kill(process: subprocess.Popen[str]) -> None:
    """End a process and its children at once, as a loss of power does."""
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()


@contextmanager
def _started(*words: str) -> Iterator[subprocess.Popen[str]]:
    """Yield a process of Dask's command line in a session of its own; it is killed at the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            kill(process)
        assert process.stderr is not None
        process.stderr.close()


def _drain(process: subprocess.Popen[str]) -> None:
    assert process.stderr is not None
    Thread(target=process.stderr.read, daemon=True).start()


def _free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def _pass_on(one: socket.socket, other: socket.socket) -> None:
    try:
        while data := one.recv(1 << 16):
            other.sendall(data)
        other.shutdown(socket.SHUT_RDWR)
    except OSError:
        return
