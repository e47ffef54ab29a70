"""Options of `pirate panel`."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.cli.completion import named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument


@dataclass(frozen=True, kw_only=True)
class PanelOptions:
    """Show what each control of a panel sends, until Ctrl-C. Nothing moves.

    Without a name: which panels and which MIDI devices there are.

    Exit codes: 0 shown, 2 invalid files or arguments, 3 the panel was lost.
    """

    name: str | None = argument(
        "[NAME[:DEVICE]|DEVICE]",
        named_files.panels,
        "A panel's name, or a file; a MIDI device alone shows bare numbers.",
        default=None,
    )
    debug: bool = common.debug()
