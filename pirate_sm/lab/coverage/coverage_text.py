"""The coverage of missions as text, as a page, as JSON, and as lcov for editors and CI."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from html import escape
from typing import Any

from pirate_sm.lab.coverage.evidence import EVIDENCE, Evidence
from pirate_sm.lab.coverage.file_coverage import (
    BranchShare,
    Coverage,
    CoveredBranch,
    FileCoverage,
    TakenBy,
)
from pirate_sm.views.report.figure_page import FigureSection, figure_page

FORMAT = 1
"""Version of the JSON, incremented when its readers must change."""

TAKEN, MISSING = ">", "!"
"""What marks a line whose branches were all taken, and one that has another."""


def share_text(share: BranchShare) -> str:
    """Return a share in words; it is rounded down, so that only all branches are 100 %."""
    return f"{share.taken} of {share.of} branches, {int(share.percent)} %"


def as_text(coverage: Coverage, least: Evidence, *, with_lines: bool) -> Iterator[str]:
    """Yield the lines of the report.

    Args:
        coverage: The coverage.
        least: The weakest evidence that counts.
        with_lines: Whether the lines of files with branches are shown, with what is missing.
    """
    for file in coverage.files.values() if with_lines else ():
        if file.branches:
            yield f"{file.name}: {share_text(coverage.share(least, [file]))}"
            yield from _annotated(file, least)
            yield ""
    yield from _rules(coverage)
    yield from _table(coverage, least)
    runs = ", ".join(
        f"{coverage.runs[each]} {_RUNS[each]}" for each in EVIDENCE if each in coverage.runs
    )
    yield ""
    yield f"counted: {runs or 'nothing'}; a branch is taken if it was {_LEAST[least]}"


_RUNS: dict[Evidence, str] = {
    "model": "explored",
    "trace": "traced",
    "simulated": "simulated",
    "robot": "of the robot",
}
_LEAST: dict[Evidence, str] = {
    "model": "possible in the check's model, or in any run",
    "trace": "taken in a run, a trace too",
    "simulated": "taken in a simulated run or by the robot",
    "robot": "taken by the robot",
}


def _annotated(file: FileCoverage, least: Evidence) -> Iterator[str]:
    lines = file.text.splitlines()
    for number, found in file.by_line().items():
        mark = TAKEN if all(each.taken(least) for each in found) else MISSING
        yield f"{number:>5} {mark} {lines[number - 1].rstrip()}"
        for each in found:
            sign = TAKEN if each.taken(least) else MISSING
            yield f"        {sign} {each.it.words} ({seen_text(each.seen)})"


def seen_text(seen: dict[Evidence, TakenBy]) -> str:
    """Return how often what has taken a branch, and the first run of the strongest kind."""
    counts = [
        "possible" if by == "model" else f"{seen[by].times} × {by}" for by in EVIDENCE if by in seen
    ]
    runs = [by for by in EVIDENCE[1:] if by in seen]
    return ", ".join([*counts, *(f"first in {seen[by].first}" for by in runs[-1:])]) or "never"


def _table(coverage: Coverage, least: Evidence) -> Iterator[str]:
    rows = [*_cells(coverage, least)]
    wide = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for name, *cells in rows:
        numbers = (f"{cell:>{width}}" for cell, width in zip(cells, wide[1:], strict=True))
        yield f"{name:<{wide[0]}}  {'  '.join(numbers)}"


def _row(
    coverage: Coverage, name: str, files: Sequence[FileCoverage], least: Evidence
) -> tuple[str, ...]:
    every = [branch for file in files for branch in file.branches.values()]
    counts = [str(sum(kind in each.seen for each in every)) for kind in EVIDENCE]
    share = coverage.share(least, files)
    return name, str(len(every)), *counts, f"{int(share.percent)} %" if every else "-"


def _rules(coverage: Coverage) -> Iterator[str]:
    if coverage.rules:
        yield "rules of the robot (not counted), with runs that broke them or were stopped:"
    for (robot, rule), seen in coverage.rules.items():
        yield f"  {robot}: {rule} ({seen_text(seen)})"
    if coverage.rules:
        yield ""


def as_json(coverage: Coverage, least: Evidence) -> str:
    """Return the coverage as JSON, see ``docs/coverage.md``."""
    whole = {
        "format": FORMAT,
        "evidence": least,
        "runs": coverage.runs,
        "percent": coverage.share(least).percent,
        "files": [
            {
                "file": file.name,
                "percent": coverage.share(least, [file]).percent,
                "branches": [_plain(each, least) for each in _in_order(file)],
            }
            for file in coverage.files.values()
        ],
        "rules": [
            {"robot": robot, "rule": rule, "seen": _seen(seen)}
            for (robot, rule), seen in coverage.rules.items()
        ],
        "not_counted": coverage.others,
    }
    return json.dumps(whole, indent=1, ensure_ascii=False)


def _in_order(file: FileCoverage) -> Iterator[CoveredBranch]:
    for found in file.by_line().values():
        yield from found


def _plain(branch: CoveredBranch, least: Evidence) -> dict[str, Any]:
    key = branch.it.key
    return {
        "line": branch.line,
        "kind": key.kind,
        "name": key.name,
        "what": branch.it.what,
        "leads": branch.it.leads,
        "taken": branch.taken(least),
        "seen": _seen(branch.seen),
    }


def _seen(seen: dict[Evidence, TakenBy]) -> dict[str, Any]:
    return {by: seen[by]._asdict() for by in EVIDENCE if by in seen}


def as_lcov(coverage: Coverage, least: Evidence) -> str:
    """Return the coverage in the format of lcov, which editors and CI servers read."""
    return "".join(f"{line}\n" for file in coverage.files.values() for line in _lcov(file, least))


def _lcov(file: FileCoverage, least: Evidence) -> Iterator[str]:
    if not file.branches:
        return
    yield "TN:pirate-sm"
    yield f"SF:{file.name}"
    strong = EVIDENCE[EVIDENCE.index(least) :]
    sums = []
    for line, found in file.by_line().items():
        times = [sum(each.seen[by].times for by in strong if by in each.seen) for each in found]
        yield from (f"BRDA:{line},0,{number},{each}" for number, each in enumerate(times))
        sums.append((line, times))
    yield f"BRF:{sum(len(times) for _, times in sums)}"
    yield f"BRH:{sum(each > 0 for _, times in sums for each in times)}"
    yield from (f"DA:{line},{sum(times)}" for line, times in sums)
    yield "end_of_record"


# --- a page ---------------------------------------------------------------------------------------


_STYLE = """<style>
.lines { font: 12.5px/1.5 ui-monospace, monospace; overflow-x: auto; white-space: pre; }
.lines div { border-left: 4px solid transparent; padding: 0 8px; }
.lines .good { border-color: var(--good); }
.lines .bad { border-color: var(--bad); background: var(--bad-box); }
.lines small { white-space: normal; display: block; margin-left: 5ch; }
</style>"""


def as_page(coverage: Coverage, least: Evidence) -> str:
    """Return the coverage as a page that loads no other file."""
    header, *rows = _cells(coverage, least)
    total = share_text(coverage.share(least))
    lines = [f"{total} {_LEAST[least]}.", *coverage.others]
    sections = [FigureSection("Branches", lines, header, rows, markup=_STYLE)]
    if coverage.rules:
        rules = [[robot, rule, seen_text(seen)] for (robot, rule), seen in coverage.rules.items()]
        sections.append(FigureSection("Rules of the robot", (), ("robot", "rule", "seen"), rules))
    sections += [
        FigureSection(
            file.name, [share_text(coverage.share(least, [file]))], markup=_listing(file, least)
        )
        for file in coverage.files.values()
    ]
    return figure_page("Coverage of branches", sections)


def _cells(coverage: Coverage, least: Evidence) -> Iterator[Sequence[str]]:
    yield "file", "branches", *EVIDENCE, "taken"
    for file in coverage.files.values():
        yield _row(coverage, file.name, [file], least)
    if len(coverage.files) > 1:
        yield _row(coverage, "total", [*coverage.files.values()], least)


def _listing(file: FileCoverage, least: Evidence) -> str:
    by_line, parts = file.by_line(), []
    for number, text in enumerate(file.text.splitlines(), 1):
        found = by_line.get(number, [])
        kind = ("good" if all(each.taken(least) for each in found) else "bad") if found else ""
        notes = "".join(
            f"<small>{TAKEN if each.taken(least) else MISSING} "
            f"{escape(each.it.words)} ({escape(seen_text(each.seen))})</small>"
            for each in found
        )
        parts.append(f'<div class="{kind}">{number:>4}  {escape(text)}{notes}</div>')
    return f'<div class="lines" tabindex="0">{"".join(parts)}</div>'
