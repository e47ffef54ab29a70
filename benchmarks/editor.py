"""How long an editor waits for the language server, and what 10,000 random edits do to it.

    python -m benchmarks.editor [--edits 10000] [--seed 0] [--repeats 5] [--missions mitre_bend ...]

The server runs as a process of its own, as an editor starts it. Printed are the time from a
keystroke to the findings for each shipped mission, beside the goal, how long each request takes,
and the server's memory during random edits of shipped files. The exit code is 1 where the server
ends, does not answer for five minutes, shows other findings of a file than before it was edited, or
needs ever more memory.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from threading import Timer
from typing import Any, NamedTuple

from benchmarks.editor_client import Client

ROOT = Path(__file__).resolve().parents[1]
GOAL_MS = 150
EDITS_OF_ONE_FILE = 20
LONGEST_S = 300.0
MOST_GROWTH = 1.2
"""How much more memory the second half of the edits may need than the first."""

TYPED = (
    "\n",
    " ",
    ":",
    "{",
    "}",
    "[",
    "]",
    "-",
    "'",
    "🤖",
    "\u2028",
    "go: ",
    "$",
    "&a",
    "*a",
    "\t",
)
QUESTIONS = {
    "documentSymbol": "documentSymbolProvider",
    "foldingRange": "foldingRangeProvider",
    "completion": "completionProvider",
    "definition": "definitionProvider",
    "references": "referencesProvider",
    "rename": "renameProvider",
    "codeAction": "codeActionProvider",
    "codeLens": "codeLensProvider",
    "hover": "hoverProvider",
    "inlayHint": "inlayHintProvider",
    "semanticTokens/full": "semanticTokensProvider",
}
"""What is asked about a file, and what a server calls it that can answer."""


def edited(text: str, draw: random.Random) -> str:
    """Return a text with something typed, deleted, doubled or turned round."""
    start = draw.randrange(len(text) + 1)
    end = min(len(text), start + draw.randrange(12))
    part = text[start:end]
    new = draw.choice((draw.choice(TYPED) + part, "", part * 2, part + part[::-1]))
    return text[:start] + new + text[end:]


def ask(client: Client, path: Path, question: str, line: int, character: int, new: str) -> Any:
    """Ask about a place; an error as the answer is an error here."""
    at = {"line": line, "character": character}
    more: dict[str, Any] = {"position": at, "newName": new}
    if question == "references":
        more["context"] = {"includeDeclaration": True}
    if question in ("codeAction", "inlayHint"):
        span = {"start": at, "end": {"line": line + 5, "character": 0}}
        more = {"range": span, "context": {"diagnostics": []}}
    return client.about(question, path, **more)


def type_at_random(
    client: Client,
    names: list[str],
    edits: int,
    draw: random.Random,
    can: set[str],
    settled: Callable[[Path], None],
) -> None:
    """Edit files in turn, wait for some findings, ask some questions.

    Args:
        client: The editor.
        names: The files, from the root of the source tree.
        edits: How many.
        draw: Decides.
        can: The questions that the server answers.
        settled: Called when a file is as before, and its findings are shown.
    """
    while edits > 0:
        path = ROOT / draw.choice(names)
        text = path.read_text("utf-8")
        client.write(path, text)
        for _ in range(min(edits, EDITS_OF_ONE_FILE)):
            text = edited(text, draw)
            version = client.put(path, text)
            chance = draw.randrange(4)
            if chance == 0:
                client.settle(path, version)
            elif chance == 1:
                question, line = draw.choice(sorted(can)), draw.randrange(text.count("\n") + 2)
                new = draw.choice(["other", "2 x", ""])
                ask(client, path, question, line, draw.randrange(40), new)
        edits -= EDITS_OF_ONE_FILE
        client.write(path, path.read_text("utf-8"))
        settled(path)
        client.close(path)


# --- the server as a process ----------------------------------------------------------------------


class Taken(NamedTuple):
    """How long the findings of a text took, on the wall and on the server's processor."""

    wall_s: float
    processor_s: float


class Server:
    """A language server with a client; it is killed when it does not answer for five minutes."""

    def __init__(self) -> None:
        line = [sys.executable, "-c", "from pirate_sm.cli.start import main; main()", "lsp"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(line, stdin=pipe, stdout=pipe, cwd=ROOT)
        if self.process.stdin is None or self.process.stdout is None:
            raise AssertionError("pipes were asked for")
        self.client = Client(self.process.stdin, self.process.stdout)
        able = self.client.begin(ROOT)
        self.can = {question for question, name in QUESTIONS.items() if able.get(name)}

    @contextmanager
    def watched(self) -> Iterator[None]:
        """Return a context that may take five minutes."""
        timer = Timer(LONGEST_S, self.process.kill)
        timer.start()
        try:
            yield
        finally:
            timer.cancel()

    @property
    def processor_s(self) -> float:
        """Return the processor time that it has used; 0 where the system does not report it."""
        file = Path(f"/proc/{self.process.pid}/stat")
        fields = file.read_text().rpartition(")")[2].split() if file.exists() else ["0"] * 13
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    @property
    def memory_bytes(self) -> int:
        """Return the memory that it needs now; 0 where the system does not report it."""
        file = Path(f"/proc/{self.process.pid}/status")
        found = re.search(r"VmRSS:\s*(\d+) kB", file.read_text() if file.exists() else "")
        return 1024 * int(found[1]) if found else 0


def keystrokes(text: str, number: int) -> Iterator[tuple[str, str]]:
    """Yield what is typed and the text then: in a comment, a number, and a name that is wrong."""
    yield "comment", f"{text}# {number}\n"
    times = [*re.finditer(r"\b(\d+) (s|min|mm|deg)\b", text)]
    if times:
        last = times[-1]
        yield "number", f"{text[: last.end(1)]}{number + 1}{text[last.end(1) :]}"
    go = re.search(r"\bgo: (\w+)", text)
    if go:
        yield "name", f"{text[: go.end(1)]}{'x' * (number + 1)}{text[go.end(1) :]}"


def time_findings(server: Server, missions: list[str], repeats: int) -> None:
    """Print how long findings take after a keystroke, for each mission."""
    print(f"{'from a keystroke to the findings, ms; the goal is':50} {GOAL_MS:>8}")
    print(f"{'the least, and of it the processor':38} {'comment':>12} {'number':>12} {'name':>12}")
    for name in missions:
        path, taken = ROOT / "sequences" / f"{name}.yaml", defaultdict[str, list[Taken]](list)
        text = path.read_text("utf-8")
        with server.watched():
            server.client.write(path, text)
        for number in range(repeats):
            for kind, changed in keystrokes(text, number):
                with server.watched():
                    before_s, began_s = server.processor_s, time.perf_counter()
                    server.client.write(path, changed)
                    wall_s = time.perf_counter() - began_s
                    taken[kind].append(Taken(wall_s, server.processor_s - before_s))
        with server.watched():
            server.client.write(path, text)
            server.client.close(path)
        shown = (taken[kind] for kind in ("comment", "number", "name"))
        print(f"{name:38} {' '.join(map(_least, shown))}", flush=True)


def _least(taken: list[Taken]) -> str:
    if not taken:
        return f"{'-':>12}"
    wall_s = min(each.wall_s for each in taken)
    processor_s = min(each.processor_s for each in taken)
    return f"{1e3 * wall_s:6.0f}{1e3 * processor_s:6.0f}"


def time_requests(server: Server, missions: list[str], draw: random.Random, repeats: int) -> None:
    """Print how long each request takes, at places drawn at random."""
    taken_ms: dict[str, list[float]] = defaultdict(list)
    for name in missions:
        path = ROOT / "sequences" / f"{name}.yaml"
        text = path.read_text("utf-8")
        words = [*re.finditer(r"\w+", text)]
        with server.watched():
            server.client.write(path, text)
        for question in sorted(server.can):
            for _ in range(repeats):
                at = draw.choice(words).start()
                line, column = text.count("\n", 0, at), at - text.rfind("\n", 0, at) - 1
                began_s = time.perf_counter()
                with server.watched():
                    ask(server.client, path, question, line, column, "other")
                taken_ms[question].append(1e3 * (time.perf_counter() - began_s))
        server.client.close(path)
    print(f"\n{'request, ms':38} {'median':>8} {'longest':>8}")
    for question, taken in taken_ms.items():
        print(f"{question:38} {median(taken):8.1f} {max(taken):8.1f}")


def endure(server: Server, names: list[str], edits: int, draw: random.Random) -> bool:
    """Edit at random, print the memory, and return whether all was well."""
    first: dict[Path, Any] = {}
    memory: list[int] = []
    wrong: list[Path] = []

    def settled(path: Path) -> None:
        found = server.client.shown[path]
        if first.setdefault(path, found) != found:
            wrong.append(path)

    print(f"\n{'random edits':>14} {'memory, MB':>12} {'edits/s':>10}")
    part = max(EDITS_OF_ONE_FILE, edits // 10)
    for done in range(0, edits, part):
        began_s = time.perf_counter()
        for _ in range(0, part, EDITS_OF_ONE_FILE):
            with server.watched():
                type_at_random(server.client, names, EDITS_OF_ONE_FILE, draw, server.can, settled)
        memory.append(server.memory_bytes)
        speed = part / (time.perf_counter() - began_s)
        print(f"{done + part:14} {memory[-1] / 1e6:12.1f} {speed:10.1f}", flush=True)
    for path in dict.fromkeys(wrong):
        print(f"other findings than before in {path}")
    half = len(memory) // 2
    grown = half > 0 and max(memory[half:]) > MOST_GROWTH * max(memory[:half])
    if grown:
        print("it needs ever more memory")
    return not wrong and not grown


def main() -> int:
    """Measure and print everything; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    shipped = sorted(each.stem for each in (ROOT / "sequences").glob("*.yaml"))
    parser.add_argument("--edits", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--missions", nargs="*", default=shipped)
    wishes = parser.parse_args()
    draw, server = random.Random(wishes.seed), Server()
    try:
        time_findings(server, wishes.missions, wishes.repeats)
        time_requests(server, wishes.missions, draw, wishes.repeats)
        names = [
            each.relative_to(ROOT).as_posix()
            for folder in ("sequences", "panels", "cameras")
            for each in sorted((ROOT / folder).rglob("*.yaml"))
        ]
        well = endure(server, names, wishes.edits, draw)
        server.client.end()
        return int(not well or server.process.wait(LONGEST_S) != 0)
    except (EOFError, BrokenPipeError):
        print("the server has ended, or has not answered for five minutes")
        return 1
    finally:
        server.process.kill()


if __name__ == "__main__":
    sys.exit(main())
