"""Counterexamples as a person would run them: from their files, through a trace."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.checking.reports.counterexamples import SCRIPT_SUFFIX, write_counterexample
from pirate_sm.core import effects as fx
from pirate_sm.core.robot import safety
from pirate_sm.running.runtime.ending import Stop, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.running.wiring.backends import read_script

REFUSED = re.compile(r"step\..*|call\..*|handler\..*")
MOST_EFFECTS = 1_000
"""Of an event sequence and what comes after it, which may go on forever."""

_FILE = re.compile(r"[^\s(]*\.yaml:")


class Seen:
    """Keeps every effect of a run, and stops it when it has seen enough of them."""

    def __init__(self, requests: StopRequests) -> None:
        self.effects: list[fx.Effect] = []
        self._requests = requests

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        self.effects += effects
        if len(self.effects) > MOST_EFFECTS and self._requests.stop is None:
            self._requests.ask(Stop("it would go on", 1))


def written(finding: Finding, check: MissionCheck, path: Path, folder: Path) -> Path:
    """The mission of the counterexample; its script stands beside it."""
    write_counterexample(finding, check, folder, "example", path)
    return folder / "example.yaml"


def play(mission: Path) -> list[fx.Effect]:
    """What a trace does that follows the script."""
    firings, course = read_script(mission.with_name(f"example{SCRIPT_SUFFIX}"))
    assert not firings
    prepared = prepare(Order(str(mission), "trace", course=course))
    requests = StopRequests()
    seen = Seen(requests)
    run = MissionRun(
        prepared.engine, prepared.backend, observers=[seen], companions=prepared.companions,
        requests=requests,
    )  # fmt: skip
    run.execute()
    return seen.effects


def shows(finding: Finding, effects: Sequence[fx.Effect]) -> bool:
    """Whether what is found happens among the effects."""
    return any(is_it(finding, effect) for effect in effects)


def is_it(finding: Finding, effect: fx.Effect) -> bool:
    """Whether the effect is what is found."""
    if REFUSED.fullmatch(finding.code):
        return (
            isinstance(effect, fx.CommandStatus)
            and effect.status == "refused"
            and effect.place.split(":")[-2:] == str(finding.place).split(":")[-2:]
            and effect.reason in finding.message
        )
    if finding.code == safety.RULE_BROKEN:
        return isinstance(effect, fx.Fault) and _told(effect.message) == _told(finding.message)
    assert finding.code == "loop.endless"
    phase = finding.message.split("'")[1]
    return isinstance(effect, fx.PhaseChange) and effect.phase.split("/")[0] == phase


def _told(message: str) -> str:
    """The message without names of files, which a counterexample does not share."""
    return _FILE.sub("", message)
