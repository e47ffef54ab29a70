"""Pages that are made of the program itself, so that they cannot differ from it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

import pirate_sm
from pirate_sm import learning
from pirate_sm.cli import start
from pirate_sm.core import library
from pirate_sm.core.errors import ExitCode
from pirate_sm.core.events import BuiltInFault
from pirate_sm.core.loading import load_robot
from pirate_sm.running.runtime.ending import BY_SIGNAL
from pirate_sm.views.drawing.robot_page import Drawing, robot_page
from pirate_sm.views.drawing.svg.svg_writer import svg
from website import notebook

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"

SCHEMAS = ("mission", "pipe", "profile", "chart", "campaign", "camera", "panel")
"""The kinds of files whose keys have a page."""

MERMAID = re.compile(r"^```mermaid\n.*?^```$", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"^# (?:\d+\. )?(.*)$", re.MULTILINE)

EXIT_CODES = {
    ExitCode.SUCCEEDED: "The mission has succeeded, or the command has done what it was asked for.",
    ExitCode.FAILED: "The mission has failed, by its own end or by a fault of the robot; "
    "`pirate check` has found errors; two runs that were compared differ.",
    pirate_sm.UsageError.exit_code: "Files or arguments are refused. Nothing has moved.",
    ExitCode.BACKEND: "The backend, the link to the robot or a detector of another package has "
    "failed.",
    ExitCode.BUG: "An internal error. `--debug` shows the traceback.",
    ExitCode.RECORDING_LOST: "The mission has succeeded, but the recording that was asked for is "
    "incomplete (a full disk).",
    ExitCode.OUTPUT_LOST: "Nobody reads the output any more (a closed pipe, a full disk).",
}


def pages() -> Iterator[tuple[str, str]]:
    """Yield the name and the text of each page and each picture."""
    yield "reference/command_line.md", _command_line()
    yield "reference/faults.md", _faults()
    for kind in SCHEMAS:
        yield f"reference/keys/{kind}.md", _keys(kind)
    yield "decisions/index.md", _decisions()
    yield "api/pirate_sm.md", _api("pirate_sm", "pirate_sm.api", pirate_sm.__all__)
    yield (
        "api/learning.md",
        _api("pirate_sm.learning", "pirate_sm.learning", learning.__all__),
    )
    for file in sorted((DOCS / "notebooks").glob("*.ipynb")):
        yield f"notebooks/{file.stem}.md", notebook.page(json.loads(file.read_text("utf-8")))
    for robot in library.robots():
        for number, drawing in enumerate(_drawings(robot)):
            yield f"robots/{_drawing_name(robot.name, number)}", drawing


def with_drawings(text: str, page: str) -> str:
    """Return the text of a robot's page with pictures instead of graphs in Mermaid.

    Viewers of repositories draw Mermaid; the site would have to fetch a script for it.
    """
    numbers = count()
    return MERMAID.sub(lambda _: f"![]({_drawing_name(Path(page).stem, next(numbers))})", text)


def _drawing_name(robot: str, number: int) -> str:
    return f"{robot}_{number}.svg"


def _drawings(robot: Path) -> Iterator[str]:
    """Yield the graphs of a robot's page as pictures."""
    blocks = robot_page(load_robot(robot))
    yield from (svg(each.graph) for each in blocks if isinstance(each, Drawing))


def _command_line() -> str:
    texts = {file.stem: file.read_text("utf-8") for file in Path(start.HELP_FOLDER).iterdir()}
    lines = [
        "# Command line",
        "These are the help texts of the installed programs: `pirate COMMAND --help`.",
    ]
    for name in sorted(texts, key=lambda name: (name != "pirate-run", name)):
        lines += [f"## {name.replace('.', ' ')}", f"```text\n{texts[name].rstrip()}\n```"]
    return "\n\n".join(lines) + "\n"


def exit_codes() -> str:
    """Return the page of exit codes, which stands in the documents: they link to it."""
    signals = {stop.exit_code: f"{stop.reason[0].upper()}{stop.reason[1:]}. The robot is in its "
               "safe state." for stop in BY_SIGNAL.values()}  # fmt: skip
    rows = [f"| {code} | {text} |" for code, text in sorted((EXIT_CODES | signals).items())]
    return "\n".join(
        [
            "# Exit codes\n",
            "Every command ends with one of these, also in a shell script or a build.\n",
            "| code | meaning |",
            "|---|---|",
            *rows,
            "",
        ]
    )


def _faults() -> str:
    lines = [
        "# Faults of a run\n",
        "A fault is a problem that no command caused. A mission handles the ones that it names in "
        "[`on_fault`](../missions.md#faults); any other ends the run in the safe state. "
        "`pirate explain CODE` describes each in the terminal. What a *file* may have wrong is "
        "listed in [checks](../checks.md#every-code).\n",
        "## Of every robot\n",
        "| fault | found by | what is wrong | a mission may handle it |",
        "|---|---|---|---|",
    ]
    for fault in BuiltInFault:
        may = "yes" if fault.catchable else "no"
        lines.append(f"| `{fault.code}` | {fault.origin} | {fault.meaning} | {may} |")
    for folder in library.robots():
        profile = load_robot(folder).profile
        lines += [f"\n## Of the robot {profile.robot}\n"]
        lines += ["| fault | what is wrong | rule |", "|---|---|---|"]
        lines += [
            f"| `{rule.code}` | {_cell(rule.message)} | `{_cell(rule.when)}` for {rule.held:g} s |"
            for rule in profile.faults
        ]
    return "\n".join(lines) + "\n"


def _decisions() -> str:
    lines = ["# Decisions\n", "Each page says what was decided, why, and what follows.\n"]
    for file in sorted((DOCS / "decisions").glob("*.md")):
        title = NAMED.search(file.read_text("utf-8"))
        assert title, f"{file.name} has no title"
        lines.append(f"- {int(file.name[:4])}: [{title[1]}]({file.name})")
    return "\n".join(lines) + "\n"


def _api(title: str, module: str, names: list[str]) -> str:
    """Return a page with the documentation of each public name: functions, classes, errors."""
    owner = {name: getattr(pirate_sm if module == "pirate_sm.api" else learning, name)
             for name in names}  # fmt: skip

    def order(name: str) -> tuple[int, str]:
        each = owner[name]
        error = isinstance(each, type) and issubclass(each, Exception)
        return (2 if error else isinstance(each, type), name)

    parts = [f"::: {module}.{name}" for name in sorted(names, key=order)]
    return f"# {title}\n\n" + "\n\n".join(parts) + "\n"


def _keys(kind: str) -> str:
    """Return the page of a JSON Schema: a table for each kind of object, the whole file first."""
    schema = json.loads((ROOT / "schemas" / f"{kind}.schema.json").read_text("utf-8"))
    lines = [
        f"# Keys of a {schema['title'][0].lower()}{schema['title'][1:]}\n",
        f"From the JSON Schema by which editors complete such a file: `pirate schema {kind}`.\n",
    ]
    lines += _table("The file", schema)
    for name, below in sorted(schema.get("definitions", {}).items()):
        if "properties" in below:
            lines += _table(name, below)
        else:
            lines += [f"## {name}\n", f"{below.get('description', '')} {_type(below)}\n"]
    return "\n".join(lines) + "\n"


def _table(name: str, schema: Mapping[str, Any]) -> list[str]:
    needed = schema.get("required", ())
    lines = [f"## {name}\n", f"{schema.get('description', '')}\n"]
    lines += ["| key | value | meaning | default |", "|---|---|---|---|"]
    for key, about in schema["properties"].items():
        default = "needed" if key in needed else _default(about)
        lines.append(f"| `{key}` | {_type(about)} | {_cell(about.get('description', ''))} "
                     f"| {default} |")  # fmt: skip
    return [*lines, ""]


def _default(about: Mapping[str, Any]) -> str:
    if about.get("default") in (None, "", [], {}):
        return ""
    return f"`{json.dumps(about['default'], ensure_ascii=False)}`"


def _type(about: Mapping[str, Any]) -> str:
    """Return which values are allowed, for a cell of a table."""
    if "$ref" in about:
        name = about["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in about:
        return f"`{json.dumps(about['const'])}`"
    if "enum" in about:
        return ", ".join(f"`{each}`" for each in about["enum"])
    for choice in ("anyOf", "oneOf", "allOf"):
        if choice in about:
            kinds = dict.fromkeys(_type(each) for each in about[choice])
            return " or ".join(each for each in kinds if each != "null") or "null"
    named = about.get("type", "anything")
    several = [named] if isinstance(named, str) else [each for each in named if each != "null"]
    return " or ".join(_of(kind, about) for kind in several)


def _of(kind: str, about: Mapping[str, Any]) -> str:
    if kind == "array" and isinstance(about.get("items"), Mapping):
        return f"list of {_type(about['items'])}"
    below = [*about.get("patternProperties", {}).values(), about.get("additionalProperties")]
    values = [each for each in below if isinstance(each, Mapping)]
    if kind == "object" and values:
        return f"by name: {_type(values[0])}"
    return {"string": "text", "object": "keys", "array": "list"}.get(kind, kind)


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
