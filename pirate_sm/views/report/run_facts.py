"""Facts about a run other than its events, from the header of its recording."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import SIMULATORS
from pirate_sm.core.options import JITTER
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.views.report.contents import Fact

_BACKENDS = {
    "physics": "in MuJoCo's physics",
    "sim": "in the simulator",
    "serial": "over the serial link",
    "trace": "as a trace",
}


@dataclass(frozen=True)
class About:
    """Facts about a run other than its events.

    Attributes:
        where: Its pipe and backend, in words.
        nominal: Whether commands ended after their nominal duration.
        first_wheel_m: Position of the first wheel at the start of odometry; None: the pipe's.
        warnings: Warnings that the reader must know first.
        facts: The details at the end of the page.
        files: Hash of each file that it was made from, by name.
        options: Of the run.
    """

    where: str
    nominal: bool
    first_wheel_m: float | None = None
    warnings: tuple[str, ...] = ()
    facts: tuple[Fact, ...] = ()
    files: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)


def about_run(header: RunHeader, loaded: LoadedMission, notices: Iterable[str] = ()) -> About:
    """Return the part of a run's report that comes from its header.

    Args:
        header: The header of the recording.
        loaded: The mission.
        notices: Notices that the reader must know first.
    """
    return About(
        where=_where(header),
        nominal=header.nominal,
        first_wheel_m=header.options.get("start_at_m"),
        warnings=tuple(_warnings(header, notices)),
        facts=tuple(_facts(header, loaded)),
        files={file.name: file.sha256 for file in header.files},
        options=header.options,
    )


def _warnings(header: RunHeader, notices: Iterable[str]) -> Iterator[str]:
    for notice in notices:
        yield f"{notice[:1].upper()}{notice[1:]}."
    jitter_m = header.options.get("diameter_jitter_m")
    if jitter_m:
        yield f"The pipe was up to {jitter_m * 1e3:g} mm wider or narrower than it is drawn."


def _where(header: RunHeader) -> str:
    """Return where it ran: ``in the simulator (seed 3, with two defects), in pipe x``."""
    options = header.options
    more = []
    if header.backend in SIMULATORS:
        more.append(f"seed {options.get('seed', 0)}")
        more += header.coarser
        more += [f"defect {name}" for name in options.get("defects", ())]
    within = f" ({', '.join(more)})" if more else ""
    pipe = f", in pipe {header.pipe}" if header.pipe else ""
    return f"{_BACKENDS.get(header.backend, f'on {header.backend}')}{within}{pipe}"


def _facts(header: RunHeader, loaded: LoadedMission) -> Iterator[Fact]:
    options = header.options
    yield Fact("mission", _described(header.mission, loaded.mission.description))
    yield Fact("robot", _described(header.robot, loaded.loaded_robot.profile.description))
    if header.polarity != "normal":
        yield Fact("polarity", header.polarity)
    if loaded.pipe is not None:
        yield Fact("pipe", _described(header.pipe, loaded.pipe.description))
        yield Fact("inner diameter", f"{loaded.pipe.diameter * 1e3:g} mm")
    yield Fact("began", header.began)
    yield Fact("backend", header.backend)
    if options.get("port"):
        yield Fact("port", str(options["port"]))
    if header.detector != "none":
        yield Fact("detector", header.detector)
    chance = [f"{o.key} ± {options[o.name]:g}" for o in JITTER if options.get(o.name)]
    if header.backend in SIMULATORS:
        yield Fact("seed", ", ".join([str(options.get("seed", 0)), *chance]))
    yield from (Fact("fidelity", name) for name in header.coarser)
    yield from (Fact("defect", name) for name in options.get("defects", ()))
    yield from (Fact("numbers of the robot", str(n)) for n in [options.get("twin")] if n)
    yield from (Fact("fitted numbers", file.name) for file in header.files if file.role == "fit")
    for name, value in header.parameters.items():
        yield Fact("parameter", f"{name} = {value}")
    if header.zeros:
        yield Fact("calibrated zeros", ", ".join(header.zeros))
    if options.get("start_phase"):
        yield Fact("from phase", str(options["start_phase"]))
    yield Fact("checked before", "yes" if options.get("check") else "no")
    yield Fact("recorded by", f"pirate-sm {header.version}")


def _described(name: str, description: str) -> str:
    return f"{name}: {description}" if description else name
