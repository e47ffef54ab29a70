"""Merge findings of several files: remove duplicates, and shorten long messages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pirate_sm.checking.findings import Finding
from pirate_sm.loading.problems import Place

_LONGEST_MESSAGE = 300


def each_once(findings: Iterable[Finding]) -> list[Finding]:
    """Return one finding per code, place and message: the worst, then the shortest."""
    kept: dict[tuple[str, Place, str], Finding] = {}
    for finding in map(_short, findings):
        key = finding.code, finding.place, finding.message
        before = kept.get(key)
        if before is None or _weight(finding) > _weight(before):
            kept[key] = finding
    return list(kept.values())


def _short(finding: Finding) -> Finding:
    """Return the finding with a shortened message, because names in a file can be very long."""
    if max(map(len, (finding.message, finding.mend, finding.suggestion))) <= _LONGEST_MESSAGE:
        return finding
    return replace(
        finding,
        message=_cut(finding.message),
        mend=_cut(finding.mend),
        suggestion=_cut(finding.suggestion),
    )


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[: _LONGEST_MESSAGE - 1]}…"


def _weight(finding: Finding) -> tuple[int, bool, int]:
    """Return the rank of a finding: by severity, then with a story, then the shortest."""
    return finding.severity, bool(finding.story), -len(finding.story)
