"""A client of the language server in this process, and the check that it is held against."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from benchmarks.editor_client import Client, Json
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.cli.commands.fresh_check import wishes_of
from pirate_sm.cli.options.checks import CheckOptions

__all__ = ["Client", "Json", "checks_as_the_command", "served"]


def checks_as_the_command(paths: list[str]) -> CheckReport:
    return check_paths(paths, wishes_of(CheckOptions(paths=paths)))


@contextmanager
def served(check: Callable[[list[str]], CheckReport] = checks_as_the_command) -> Iterator[Client]:
    """Return a context with a client of a server that runs in a thread."""
    server = pytest.importorskip("pirate_sm.views.editor.language_server")
    here, pipes = Path.cwd(), [os.pipe(), os.pipe()]
    (server_in, client_out), (client_in, server_out) = pipes
    with (
        os.fdopen(server_in, "rb") as messages,
        os.fdopen(server_out, "wb") as answers,
        os.fdopen(client_out, "wb") as to_server,
        os.fdopen(client_in, "rb") as from_server,
    ):
        thread = threading.Thread(target=server.Editor(check).serve, args=(messages, answers))
        thread.start()
        client = Client(to_server, from_server)
        try:
            yield client
        finally:
            client.end()
            thread.join(30)
            os.chdir(here)
        assert not thread.is_alive()
