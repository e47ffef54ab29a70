"""The facts about a connected robot, as tables on a terminal or as plain lines."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from statistics import median
from typing import NamedTuple

from rich.columns import Columns
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from pirate_sm.robot.diagnosis.facts import BoardFact, Facts, TopicFact

_REFRESH_S = 0.25
_STYLES = {"no-go": "bold red", "suspicious": "yellow", "note": "dim"}
_MD5_SHOWN = 8
_TOPIC = ("topic", "device", "id", "type", "md5", "per s")
_BOARD = ("board", "module", "frames", "per s", "expected", "longest gap")
_SENSOR = ("board", "sensor", "raw", "value", "least", "most", "remark")


class Section(NamedTuple):
    """A table; numbers are right-aligned."""

    title: str
    headers: tuple[str, ...]
    right: frozenset[int]
    rows: Sequence[tuple[str, ...]]


def sections(facts: Facts) -> list[Section]:
    """Return the tables for people: topics, boards, sensors."""
    sensors = [row for board in facts.boards for row in _sensors(board)]
    return [
        Section("topics", _TOPIC, frozenset({2, 5}), list(map(_topic, facts.topics))),
        Section("boards", _BOARD, frozenset({0, 2, 3, 4, 5}), list(map(_board, facts.boards))),
        Section("sensors", _SENSOR, frozenset({0, 2, 3, 4, 5}), sensors),
    ]


def _topic(it: TopicFact) -> tuple[str, ...]:
    number = "" if it.id is None else str(it.id)
    return it.name, it.direction, number, it.type, _md5(it), f"{it.per_s:.1f}"


def _board(it: BoardFact) -> tuple[str, ...]:
    rates = (f"{it.per_s:.1f}", f"{it.expected_per_s:.1f}")
    return str(it.id), it.module, str(it.frames), *rates, f"{it.longest_gap_s * 1e3:.0f} ms"


def _md5(topic: TopicFact) -> str:
    if topic.id is None:
        return "not offered"
    if not topic.our_type:
        return f"{topic.md5[:_MD5_SHOWN]}, not used"
    if topic.md5 == topic.our_md5:
        return f"{topic.md5[:_MD5_SHOWN]} = ours"
    return f"{topic.md5[:_MD5_SHOWN]}, ours is {topic.our_md5[:_MD5_SHOWN]}"


def _sensors(board: BoardFact) -> Iterator[tuple[str, ...]]:
    for channel in board.channels:
        numbers = (channel.raw, channel.least, channel.most)
        raw, least, most = ("" if each is None else f"{each:z.6g}" for each in numbers)
        remark = channel.trouble[0].partition(":")[0] if channel.trouble else ""
        name = channel.signal or f"({channel.name})"
        yield str(board.id), name, raw, channel.shown, least, most, remark


def link_lines(facts: Facts) -> list[str]:
    """Return lines with the statistics of the link."""
    link = facts.link
    lines = [
        f"answered {link.answer_s:.1f} s after the port was opened; {facts.baud} baud",
        f"{link.bytes} bytes in {facts.listened_s:.1f} s, {link.dropped} of no frame, "
        f"{link.unreadable} messages unreadable, {link.strange} strange",
        f"{link.time_requests} requests for the time answered",
        f"this computer stood still for {link.stood_still_s * 1000:.0f} ms at most",
    ]
    if link.asked_ms:
        lines.append(f"round trip of a question: {_trips(link.asked_ms)}")
    if link.echoed_ms:
        lines.append(
            f"round trip of an array: {_trips(link.echoed_ms)}; "
            f"{link.repeats} repeated, {link.damaged} damaged echoes"
        )
    lines += [f"the firmware says: {text}" for _, text in facts.words]
    return lines


def _trips(times_ms: Sequence[float]) -> str:
    return (
        f"median {median(times_ms):.0f} ms, {min(times_ms):.0f} to {max(times_ms):.0f} ms "
        f"({len(times_ms)})"
    )


def verdict(facts: Facts) -> str:
    """Return go or no-go, in one line."""
    if facts.go:
        doubts = sum(finding.level == "suspicious" for finding in facts.findings)
        if doubts:
            return f"GO, with {doubts} thing{'s' if doubts > 1 else ''} to look at first"
        return "GO"
    return "NO-GO: do not start a mission"


def plain_text(facts: Facts) -> str:
    """Return everything as lines of text."""
    lines = [f"{facts.robot} on {facts.port}", ""]
    for section in sections(facts):
        rows = [section.headers, *section.rows]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines.append(f"{section.title}:")
        for row in rows:
            cells = [
                cell.rjust(width) if at in section.right else cell.ljust(width)
                for at, (cell, width) in enumerate(zip(row, widths, strict=True))
            ]
            lines.append(f"  {'  '.join(cells)}".rstrip())
        lines.append("")
    lines += ["link:", *(f"  {line}" for line in link_lines(facts)), ""]
    lines += [f"{finding.level}: {finding.message}" for finding in facts.findings]
    lines.append(verdict(facts))
    return "\n".join(lines) + "\n"


class LiveTables(Live):
    """Tables that are redrawn in place while the robot is examined."""

    def __init__(self) -> None:
        super().__init__(auto_refresh=False, transient=True)
        self._shown_s = -inf

    def show_sensors(self, facts: Facts, now_s: float) -> None:
        """Show the sensors' values, a few times a second."""
        if now_s >= self._shown_s + _REFRESH_S:
            self._shown_s = now_s
            self.update(sensors_now(facts), refresh=True)


def show_tables(facts: Facts) -> None:
    """Print the final facts, with the verdict below."""
    console = Console()
    for section in sections(facts):
        console.print(_table(section))
    for line in link_lines(facts):
        console.print(Text(line))
    console.print()
    for finding in facts.findings:
        style = _STYLES[finding.level]
        console.print(Text(f"{finding.level}: {finding.message}", style))
    console.print(Text(verdict(facts), "bold green" if facts.go else "bold red"))


def sensors_now(facts: Facts) -> Columns:
    """Return the sensors' values, a table for each board, side by side if there is room."""
    tables = []
    for board in facts.boards:
        title = f"{board.id} {board.module}, {board.per_s:.1f} per s"
        table = Table(title=title, title_justify="left", box=None, show_header=False)
        table.add_column(no_wrap=True)
        table.add_column(justify="right", min_width=7, no_wrap=True)
        table.add_column(justify="right", min_width=11, no_wrap=True)
        for channel in board.channels:
            raw = "" if channel.raw is None else f"{channel.raw:z.6g}"
            row = (channel.signal or f"({channel.name})", raw, channel.shown)
            table.add_row(*map(Text, row), style="yellow" if channel.trouble else None)
        if not board.frames:
            table.add_row(Text("silent", "bold red"))
        tables.append(table)
    return Columns(tables, padding=(0, 3))


def _table(section: Section) -> Table:
    table = Table(title=section.title, title_justify="left", box=None, pad_edge=False)
    for at, header in enumerate(section.headers):
        table.add_column(header, justify="right" if at in section.right else "left")
    for row in section.rows:
        remarkable = section.title == "sensors" and bool(row[-1])
        table.add_row(*map(Text, row), style="yellow" if remarkable else None)
    return table
