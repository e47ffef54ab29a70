"""`pirate lsp`: answers an editor by the Language Server Protocol."""

from __future__ import annotations

import os
import sys

from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.cli.commands.fresh_check import wishes_of
from pirate_sm.cli.options.checks import CheckOptions, LspOptions
from pirate_sm.core.errors import ExitCode, not_installed


def serve_editor(options: LspOptions) -> int:
    """Answer until the editor ends; return the exit code.

    Raises:
        UsageError: The packages of the extra are not installed.
    """
    try:
        from pirate_sm.views.editor.language_server import Editor
    except ModuleNotFoundError:
        raise not_installed("the language server", "pygls", "lsp") from None

    def check(paths: list[str]) -> CheckReport:
        return check_paths(paths, wishes_of(CheckOptions(paths=paths, outside=options.outside)))

    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # what is printed would be no answer
    Editor(check).serve(sys.stdin.buffer, answers)
    return ExitCode.SUCCEEDED
