"""Reports as text for a terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from textwrap import wrap

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, Rehearsal, RehearsedRun, marked
from pirate_sm.core.events import BUILT_IN_FAULTS, BuiltInFault

_WIDTH = 100
_LEAST = 20
"""Columns for the text after a label, however narrow the terminal is."""

_FIXING = "by --fix", "by a guess, with --fix --unsafe-fixes"
_MOST_CALLS = 3
_MOST_PLACES = 3

Paint = Callable[[str, str], str]
"""Returns text that is safe for a terminal, in the colour of a role."""


def text_report(report: CheckReport, paint: Paint, columns: int = _WIDTH) -> str:
    """Return the findings by place, the allowed findings, and the summary.

    Args:
        report: The report.
        paint: Makes text safe for the terminal, and optionally coloured. The roles are the
            severities, ``place``, ``mark``, ``label`` and ``""``.
        columns: How wide source lines and explanations may be.
    """
    lines: list[str] = []
    for finding in report.open:
        lines += [*_finding(finding, paint, columns), ""]
    if report.allowed:
        lines.append(paint("label", "allowed:"))
        for each in report.allowed:
            lines.append(f"  {paint('place', str(each.place))} {paint('', each.code)}")
            lines.append(f"    {paint('', f'{each.message}; because {each.allowed}')}")
        lines.append("")
    if report.rehearsals:
        lines.append(paint("label", "rehearsed in the simulator, and what nearly happened:"))
        for rehearsal in report.rehearsals:
            lines += _rehearsal(rehearsal, paint, columns)
        lines.append("")
    lines += [paint("", line) for line in (*_fixes(report), summary(report))]
    return "\n".join(lines)


def _finding(finding: Finding, paint: Paint, columns: int) -> Iterator[str]:
    entry = catalogue.entry_of(finding.code)
    severity = finding.severity.word
    head = f"{paint('place', str(finding.place))}: {paint(severity, severity)}"
    yield f"{head} {paint('label', f'[{finding.code}]')} {paint('', finding.message)}"
    before = len(f"  {finding.place.line} | ")
    source = marked(finding, min(_WIDTH, columns - before) if columns < _WIDTH else _WIDTH)
    if source is not None:
        margin = " " * len(str(finding.place.line))
        yield paint("label", f"  {finding.place.line} | ") + paint("", source.line)
        yield paint("label", f"  {margin} | ") + paint("mark", source.under)
    for place, what in finding.related:
        yield f"  {paint('place', str(place))}: {paint('', what)}"
    yield from _story(finding, paint, columns)
    said = ("why", entry.why), ("fix", advice(finding)), ("example", finding.example)
    for label, text in said:
        if text:
            yield from _wrapped(f"  {label + ': ':6}", text, paint, columns)


def _story(finding: Finding, paint: Paint, columns: int) -> Iterator[str]:
    if finding.story:
        yield paint("label", "  how it comes about:")
    width = len(str(len(finding.story)))
    for number, sentence in enumerate(finding.story, start=1):
        yield from _wrapped(f"    {number:>{width}}. ", sentence, paint, columns)


def _rehearsal(rehearsal: Rehearsal, paint: Paint, columns: int) -> Iterator[str]:
    """Yield the results of a mission's runs, and their near misses."""
    said = f"not run: {rehearsal.skipped}" if rehearsal.skipped else _runs(rehearsal.runs)
    yield f"  {paint('place', rehearsal.file)}: {paint('', said)}"
    for each in rehearsal.nearly[:_MOST_CALLS]:
        which = f", seed {each.seed}" if len(rehearsal.runs) > 1 else ""
        label = f"    {each.share:4.0%} at {each.at_s:.1f} s{which}: "
        yield from _wrapped(label, each.text, paint, columns)


def _runs(runs: Sequence[RehearsedRun]) -> str:
    good = [run for run in runs if run.succeeded]
    if len(runs) == 1:
        (run,) = runs
        return f"{run.outcome} after {run.time_s:.1f} s: {run.message}"
    times = [run.time_s for run in good or runs]
    return (
        f"{len(good)} of {len(runs)} runs succeeded"
        f"{f', after {min(times):.1f} s to {max(times):.1f} s' if good else ''}"
    )


def _wrapped(label: str, text: str, paint: Paint, columns: int) -> Iterator[str]:
    """Yield the text after a label, wrapped to the width of a terminal."""
    lines = wrap(
        text, max(columns - len(label), _LEAST), break_long_words=False, break_on_hyphens=False
    )
    for number, line in enumerate(lines):
        margin = " " * len(label) if number else paint("label", label)
        yield f"{margin}{paint('', line)}"


def advice(finding: Finding) -> str:
    """Return how to fix a finding: a suggestion, the expected input, or the catalogue's advice."""
    if not finding.suggestion:
        return finding.fix or catalogue.entry_of(finding.code).fix
    names = finding.fix.startswith("expected ")  # of which the suggestion is the nearest
    return f"did you mean '{finding.suggestion}'? {'' if names else finding.fix}".rstrip()


def summary(report: CheckReport) -> str:
    """Return the number of checked files and of findings, in one line."""
    kinds = Counter(file.kind.value for file in report.files)
    looked = ", ".join(count(number, kind) for kind, number in kinds.items())
    where = f" in {', '.join(report.where)}" if 0 < len(report.where) <= _MOST_PLACES else ""
    return f"{looked or 'nothing'} checked{where}: {_counted(report)}"


def _fixes(report: CheckReport) -> Iterator[str]:
    """Yield how many findings were removed by --fix, and how many can be."""
    if report.fixed:
        yield f"{count(report.fixed, 'finding')} fixed"
    for number, how in zip(report.fixable, _FIXING, strict=True):
        if number:
            yield f"{count(number, 'finding')} can be fixed {how}"


def _counted(report: CheckReport) -> str:
    by_severity = Counter(each.severity for each in report.open)
    parts = [_some(by_severity[each], each) for each in sorted(Severity, reverse=True)]
    if report.allowed:
        parts.append(f"{len(report.allowed)} allowed")
    return ", ".join(part for part in parts if part) or "no findings"


def _some(number: int, severity: Severity) -> str:
    if not number:
        return ""
    return f"{number} possible" if severity is Severity.POSSIBLE else count(number, severity.word)


def count(number: int, thing: str) -> str:
    """Return a number of things: `1 robot`, `2 robots`."""
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"


def explained(code: str) -> str:
    """Return the explanation of a code: of a finding, of a fault, or of both."""
    found = [_finding_explained(code)] if code in catalogue.entries() else []
    if code in BUILT_IN_FAULTS:
        found.append(_fault_explained(BUILT_IN_FAULTS[code]))
    return "\n\n".join(found)


def _fault_explained(fault: BuiltInFault) -> str:
    handled = f"on_fault: [{{fault: {fault.code}, then: continue}}]"
    return "\n".join(
        [
            f"{fault.code} (fault): {fault.meaning}",
            "",
            f"How it is seen: {_seen_by(fault)}",
            f"A mission can handle it: {handled}"
            if fault.catchable
            else "No mission can handle it: the run ends in the safe state.",
        ]
    )


def _seen_by(fault: BuiltInFault) -> str:
    match fault.origin:
        case "sensors":
            return "the engine judges what the sensors show, on every backend alike."
        case "link":
            return "the link to the robot reports it, or the engine hears nothing over it."
        case "camera":
            return "the detector vision judges its camera's pictures."
        case "surroundings":
            return "the simulated surroundings of the robot report it."
        case "program":
            return "this program watches itself and the mission."


def _finding_explained(code: str) -> str:
    entry, group = catalogue.entries()[code], catalogue.group_of(code)
    return "\n".join(
        [
            f"{code} ({entry.severity}): {entry.title}",
            "",
            f"Why it matters: {entry.why}",
            f"How to fix it: {entry.fix}",
            f"Decided by: {group.decided_by}",
            f"Not decided: {group.not_decided}",
            f"On its line it can be allowed: # pirate: allow {code}: <reason>"
            if code in catalogue.allowable()
            else "It cannot be allowed.",
            "",
            "Wrong:",
            *_indented(entry.wrong),
            "",
            "Right:",
            *_indented(entry.right),
        ]
    )


def listed() -> str:
    """Return all codes with their titles, by group."""
    width = max(map(len, catalogue.entries()))
    lines = []
    for group in catalogue.groups():
        lines += [group.group, f"  {group.about}", ""]
        lines += [f"  {code:{width}}  {entry.title}" for code, entry in group.codes.items()]
        lines.append("")
    lines += ["Faults during a run", "  What any robot can have; its profile adds its own.", ""]
    lines += [f"  {code:{width}}  {fault.meaning}" for code, fault in BUILT_IN_FAULTS.items()]
    return "\n".join(lines).rstrip("\n")


def _indented(text: str) -> Iterable[str]:
    return (f"  {line}" for line in text.splitlines())
