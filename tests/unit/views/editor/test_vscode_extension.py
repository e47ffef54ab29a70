"""The extension for VS Code starts the server that the other tests talk with."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from benchmarks.editor_client import Client

from .client import served
from .test_language_server import DRIVE

ROOT = Path(__file__).resolve().parents[4]
FOLDER = ROOT / "editors" / "vscode"
SCRIPT = (FOLDER / "extension.js").read_text("utf-8")
MANIFEST: Any = json.loads((FOLDER / "package.json").read_text("utf-8"))
LOCK: Any = json.loads((FOLDER / "package-lock.json").read_text("utf-8"))

# Stands for the editor: notes what the extension starts and registers.
HOST = """
const Module = require("node:module");
const [script, settings, folder] = process.argv.slice(1);
const values = JSON.parse(settings), noted = {};
class LanguageClient {
  constructor(id, name, server, options) { Object.assign(noted, { server, options }); }
  async start() { if (values.fails) throw new Error("ENOENT"); }
}
const vscode = {
  workspace: {
    workspaceFolders: [{ uri: { fsPath: folder } }],
    getConfiguration: () => ({ get: (name) => values[name] }),
    onDidChangeConfiguration: () => ({}),
  },
  window: { showErrorMessage: (said) => { noted.said = said; } },
  commands: { registerCommand: (name) => { noted.command = name; return {}; } },
};
const known = { vscode, "vscode-languageclient/node": { LanguageClient } };
const load = Module._load;
Module._load = (name, ...rest) => known[name] ?? load(name, ...rest);
const extension = require(script);
extension.activate({ subscriptions: [] }).then(() => console.log(JSON.stringify(noted)));
"""


def started(folder: Path, **settings: object) -> Any:
    """What the extension starts in a folder, as a host of extensions sees it."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("Node.js is not installed")
    properties = MANIFEST["contributes"]["configuration"]["properties"]
    usual = {name.partition(".")[2]: each["default"] for name, each in properties.items()}
    values = json.dumps({**usual, **settings})
    line = [node, "-e", HOST, str(FOLDER / "extension.js"), values, str(folder)]
    return json.loads(subprocess.run(line, capture_output=True, check=True).stdout)


def test_it_starts_the_server_in_the_folder_of_the_project(tmp_path: Path) -> None:
    noted = started(tmp_path)

    server = {"command": "pirate", "args": ["lsp"], "options": {"cwd": str(tmp_path)}}
    assert noted["server"] == server
    assert noted["options"]["documentSelector"] == [{"scheme": "file", "language": "yaml"}]
    assert noted["command"] in [each["command"] for each in MANIFEST["contributes"]["commands"]]


def test_its_settings_are_obeyed(tmp_path: Path) -> None:
    noted = started(tmp_path, path=".venv/bin/pirate", outside=True)

    assert noted["server"]["command"] == str(tmp_path / ".venv" / "bin" / "pirate")
    assert noted["server"]["args"] == ["lsp", "--outside"]


def test_the_server_gets_the_settings_that_it_obeys(tmp_path: Path) -> None:
    pytest.importorskip("pygls")
    section = started(tmp_path)["options"]["synchronize"]["configurationSection"]
    with served() as client:
        client.begin(tmp_path)
        client.put(tmp_path / "drive.yaml", DRIVE)
        whole = {"start": {"line": 0, "character": 0}, "end": {"line": 99, "character": 0}}

        def hints(*, wanted: bool) -> Any:
            settings = {"settings": {section: {"hints": wanted}}}
            client.send("workspace/didChangeConfiguration", settings)
            return client.about("inlayHint", tmp_path / "drive.yaml", range=whole)

        assert f"{section}.hints" in MANIFEST["contributes"]["configuration"]["properties"]
        assert (bool(hints(wanted=True)), hints(wanted=False)) == (True, [])


def test_a_command_that_is_not_there_is_said_with_what_helps(tmp_path: Path) -> None:
    said = started(tmp_path, fails=True)["said"]

    assert "pirate lsp cannot be started: ENOENT" in said
    assert "pip install 'pirate-sm[lsp]'" in said


def test_what_it_starts_answers_as_a_server(tmp_path: Path) -> None:
    pytest.importorskip("pygls")
    words = started(tmp_path)["server"]["args"]
    code = "from pirate_sm.cli.start import main; main()"
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", code, *words], stdin=pipe, stdout=pipe) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        client = Client(process.stdin, process.stdout)
        able = client.begin(tmp_path)
        client.end()

    assert able["codeLensProvider"]
    assert "pirate_sm.simulate" in able["executeCommandProvider"]["commands"]


def test_every_setting_that_it_reads_is_declared_and_the_other_way_round() -> None:
    declared = MANIFEST["contributes"]["configuration"]["properties"]
    read = [*re.findall(r'\.get\("(\w+)"\)', SCRIPT), "hints"]  # the server reads that one

    assert {f"pirate_sm.{name}" for name in read} == {*declared}
    assert all(each["description"] for each in declared.values())


def test_what_it_needs_is_locked_and_names_no_registry() -> None:
    wanted = {**MANIFEST["dependencies"], **MANIFEST["devDependencies"]}

    for name, version in wanted.items():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version), name
        assert LOCK["packages"][f"node_modules/{name}"]["version"] == version
    assert not any("resolved" in each for each in LOCK["packages"].values())
    assert all(each.get("integrity") for name, each in LOCK["packages"].items() if name)


def test_a_folder_that_is_not_trusted_starts_nothing() -> None:
    assert MANIFEST["capabilities"]["untrustedWorkspaces"]["supported"] is False


def test_it_is_no_part_of_the_wheel() -> None:
    project = (ROOT / "pyproject.toml").read_text("utf-8")
    (only,) = re.findall(r"only-include = \[(.*?)\]", project, re.DOTALL)

    assert "editors" not in only
