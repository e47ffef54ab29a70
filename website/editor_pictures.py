"""Pictures of an editor with the language server: Neovim in a terminal without a screen.

An editor shows what the server answers. `made_of_answers` asks for the same, so that tests notice
that a picture is out of date, also where there is no Neovim.
"""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from rich.console import Console
from rich.text import Text

from benchmarks.editor_client import Client

ROOT = Path(__file__).resolve().parents[1]
SIZE = (110, 26)
_SERVER = (sys.executable, "-c", "from pirate_sm.cli.start import main; main()", "lsp")
_LONGEST_S: Final = 120.0
_FONT_FACE = re.compile(r"\s*@font-face \{.*?\}", re.DOTALL)
_FIRST = re.compile(r"^Save this as `first.yaml`:\n\n```yaml\n(.*?)^```$", re.MULTILINE | re.DOTALL)

_START = """
local line = vim.json.decode([==[%s]==])
local server = vim.lsp.start_client({
  name = "pirate", cmd = line, root_dir = vim.fn.getcwd(), on_init = function() print("ready") end,
})
vim.lsp.buf_attach_client(0, server)
vim.bo.omnifunc = "v:lua.vim.lsp.omnifunc"
vim.opt.completeopt = "menuone,noinsert"
vim.cmd([[
set number noswapfile noruler laststatus=0 background=dark
highlight LineNr ctermfg=240
highlight Identifier ctermfg=75 cterm=NONE
highlight NormalFloat ctermfg=252 ctermbg=237
highlight Pmenu ctermfg=252 ctermbg=237
highlight PmenuSel ctermfg=255 ctermbg=24
highlight SignColumn ctermbg=NONE
highlight Error ctermfg=252 ctermbg=NONE
highlight DiagnosticError ctermfg=203
highlight DiagnosticUnderlineError ctermfg=203 cterm=underline
]])
"""


class EditorShot(NamedTuple):
    """A picture of the editor, with the mission of the README.

    Attributes:
        change: What is written in it, and what instead.
        at: The words in front of the cursor.
        question: What is asked there, as in the protocol; empty for what is found.
        keys: What is typed, as tmux names keys.
        until: What is seen then.
    """

    change: tuple[str, str]
    at: str
    question: str
    keys: tuple[str, ...]
    until: str


EDITOR_SHOTS: Mapping[str, EditorShot] = MappingProxyType(
    {
        "editor_finding.svg": EditorShot(
            ("{do: [Brake], go", "{do: [Brake, DriveForward, UnclampFront], go"),
            "DriveForward, ",
            "",
            (":lua vim.diagnostic.open_float()", "Enter"),
            "fix: ",
        ),
        "editor_hover.svg": EditorShot(
            ("", ""), "[ClampFront, ", "hover", (":lua vim.lsp.buf.hover()", "Enter"), "usually"
        ),
        "editor_completion.svg": EditorShot(
            ("[Brake]", "[Brake, ]"), "[Brake, ", "completion", ("i", "C-x", "C-o"), "at most"
        ),
    }
)


def text_of(shot: EditorShot) -> str:
    """Return the mission that a picture shows."""
    found = _FIRST.search((ROOT / "README.md").read_text("utf-8"))
    if found is None:
        raise AssertionError("the README has no mission")
    return found[1].replace(*shot.change)


def _place(shot: EditorShot) -> tuple[int, int]:
    """Return the line and the column of the cursor, both from 0."""
    before = text_of(shot).partition(shot.at)[0] + shot.at
    return before.count("\n"), len(before.rpartition("\n")[2])


def made_of_answers(folder: Path) -> dict[str, str]:
    """Return for each picture a hash of what the server answers for it."""
    pipe, known = subprocess.PIPE, {}
    with subprocess.Popen(_SERVER, stdin=pipe, stdout=pipe, cwd=folder) as process:
        if process.stdin is None or process.stdout is None:
            raise AssertionError("pipes were asked for")
        client = Client(process.stdin, process.stdout)
        client.begin(folder)
        for name, shot in EDITOR_SHOTS.items():
            path = folder / f"{Path(name).stem}.yaml"
            found: Any = client.write(path, text_of(shot))
            if shot.question:
                line, character = _place(shot)
                position = {"line": line, "character": character}
                found = client.about(shot.question, path, position=position)
            said = json.dumps(found, sort_keys=True).replace(folder.as_uri(), "")
            known[name] = hashlib.sha256(said.encode()).hexdigest()[:16]
        client.end()
    return known


def take_editor_pictures(pictures: Path) -> dict[str, str]:
    """Take the pictures anew, and return of what each is made.

    Raises:
        SystemExit: There is no Neovim or no tmux.
    """
    for program in ("nvim", "tmux"):
        if shutil.which(program) is None:
            sys.exit(f"there is no {program}: apt-get install neovim tmux")
    with TemporaryDirectory() as place:
        for name, shot in EDITOR_SHOTS.items():
            folder = Path(place) / Path(name).stem
            folder.mkdir()
            (pictures / name).write_text(_picture(_screen(shot, folder)), encoding="utf-8")
        return made_of_answers(Path(place))


def _screen(shot: EditorShot, folder: Path) -> str:
    """Return what a terminal shows with the editor in it, with codes for colours."""
    (folder / "first.yaml").write_text(text_of(shot), encoding="utf-8")
    (folder / "start.lua").write_text(_START % json.dumps(_SERVER), encoding="utf-8")
    line, column = _place(shot)
    begin = f"call cursor({line + 1}, {column + 1})"
    words = ["nvim", "--clean", "first.yaml", "-S", "start.lua", "-c", begin]
    width, height = map(str, SIZE)
    tmux = ["tmux", "-L", f"pirate-{folder.name}", "-f", "/dev/null"]
    new = ["new-session", "-d", "-x", width, "-y", height, "-c", str(folder), shlex.join(words)]
    subprocess.run([*tmux, *new], check=True)
    try:
        _until(tmux, "ready" if shot.question else "■")
        for key in shot.keys:
            subprocess.run([*tmux, "send-keys", key], check=True)
        return _until(tmux, shot.until)
    finally:
        subprocess.run([*tmux, "kill-server"], check=False)


def _until(tmux: list[str], wanted: str) -> str:
    """Return the screen as soon as it shows some words."""
    end_s = time.monotonic() + _LONGEST_S
    while time.monotonic() < end_s:
        taken = subprocess.run([*tmux, "capture-pane", "-e", "-p"], capture_output=True, check=True)
        screen = taken.stdout.decode()
        if wanted in Text.from_ansi(screen).plain:
            return screen
        time.sleep(0.2)
    raise AssertionError(f"the editor does not show '{wanted}'")


def _picture(screen: str) -> str:
    """Return a screen as an SVG that needs nothing from elsewhere."""
    console = Console(record=True, width=SIZE[0], file=StringIO(), force_terminal=True)
    console.print(Text.from_ansi(screen.rstrip("\n")))
    drawn = console.export_svg(title="first.yaml", unique_id="editor")
    return _FONT_FACE.sub("", drawn).replace("Fira Code", "monospace")
