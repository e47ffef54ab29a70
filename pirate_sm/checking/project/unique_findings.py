"""Findings of several files as one list: each once, and no message longer than can be shown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from pirate_sm.checking.findings import Finding
from pirate_sm.loading.problems import Place

_LONGEST_MESSAGE = 300


def each_once(findings: Iterable[Finding]) -> list[Finding]:
    """Return one finding per code, place and message: the worst, and of these the shortest."""
    kept: dict[tuple[str, Place, str], Finding] = {}
    for finding in map(_short, findings):
        key = finding.code, finding.place, finding.message
        before = kept.get(key)
        if before is None or _weight(finding) > _weight(before):
            kept[key] = finding
    return list(kept.values())


def _short(finding: Finding) -> Finding:
    """Return the finding with a message that can be shown: names in a file can be a megabyte."""
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
    """Return how findings are ranked: by severity, then with a story, then the shortest."""
    return finding.severity, bool(finding.story), -len(finding.story)
