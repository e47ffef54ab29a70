"""`pirate config`: shows the active settings and where each comes from."""

from __future__ import annotations

import json
from typing import Any

from pirate_sm.cli import settings
from pirate_sm.cli.commands.list import print_table
from pirate_sm.cli.options.files import ConfigOptions
from pirate_sm.cli.settings import SETTINGS, SettingValue
from pirate_sm.core.visible import visible

FORMAT = 1
"""Changes when a reader of the JSON would have to."""


def show_settings(options: ConfigOptions) -> int:
    """Print the settings or the paths of their files; return the exit code.

    Raises:
        LoadError: A file has faults; it lists those of both.
    """
    user, project = settings.user_file(), settings.project_file()
    paths = {"user": str(user), "project": str(project) if project else None}
    if options.what == "path":
        if options.format == "json":
            _print_json(paths)
        else:
            print("\n".join(visible(path) for path in paths.values() if path))
        return 0
    found = settings.values()
    if options.format == "json":
        listed = {name: _for_programs(each) for name, each in found.items()}
        _print_json({"settings": listed, "files": paths})
        return 0
    rows = [
        (name, _text(each), _source(each), SETTINGS[name].about) for name, each in found.items()
    ]
    print_table("settings", rows)
    return 0


def _for_programs(each: SettingValue) -> dict[str, Any]:
    return {"value": each.value or None, "source": each.source, "refused": each.refused or None}


def _print_json(content: dict[str, Any]) -> None:
    print(json.dumps({"format": FORMAT, **content}, ensure_ascii=True))


def _text(value: SettingValue) -> str:
    listed = value.value if isinstance(value.value, tuple) else (value.value,)
    return ", ".join(map(str, listed)) or "-"


def _source(value: SettingValue) -> str:
    return f"{value.source} (not used: it {value.refused})" if value.refused else value.source
