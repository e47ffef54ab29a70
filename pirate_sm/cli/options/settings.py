"""Options of `pirate config` and `pirate completion`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, typed


@dataclass(frozen=True, kw_only=True)
class ConfigOptions:
    """Show the settings in force and where each comes from.

    The command line comes before the environment, that before pirate.toml of a project, that
    before the person's own file.

    Exit codes: 0 shown, 2 a file has faults.
    """

    what: Literal["show", "path"] = argument(
        None, None, "The settings, or where their files are.", default="show"
    )
    format: Literal["text", "json"] = typed(
        "For people, or for programs.", "--format", default="text"
    )
    debug: bool = common.debug()


@dataclass(frozen=True, kw_only=True)
class CompletionOptions:
    """Print a script with which a shell completes command lines.

    bash: write it to ~/.pirate_sm.bash, and `source ~/.pirate_sm.bash` into ~/.bashrc.

    zsh: write it to ~/.pirate_sm.zsh, and `source ~/.pirate_sm.zsh` into ~/.zshrc.

    fish: write it to ~/.config/fish/conf.d/pirate_sm.fish.
    """

    shell: Literal["bash", "zsh", "fish"] = argument(None, None, "For which shell.")
    debug: bool = common.debug()
