"""Random missions that the loader accepts."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from driving import PIRATE
from hypothesis import strategies as st

from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._loading.mission.program import build_program
from pirate_sm.core._loading.mission.scope import Source
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core._loading.yaml.document import parse_document
from pirate_sm.core._loading.yaml.validation import validate
from pirate_sm.core._model.mission import Mission

PHASES = ("p0", "p1", "p2", "p3")
ENDS = ("good", "bad")
TARGETS = st.sampled_from((*PHASES, *ENDS))
CONDITIONS = st.sampled_from(
    [
        *("true", "false", "detector == close", "detector in (in, past)", "segment == Joint"),
        *("odometry > 50 mm", "abs(speed) < 5 mm/s", "gamma_1 > 1 rad", "known(phi)"),
        *("BendingState == DoubleClamped", "not (LightingState == On)", "roll > 0.1 rad"),
    ]
)
TIMES = st.sampled_from(["20 ms", "100 ms", "1 s", "3 s", "20 s"])
COMMANDS = st.sampled_from(
    [
        *("ClampFront", "ClampRear", "RelaxFront", "RelaxRear", "BendInto", "BendBack"),
        *("DriveForward", "DriveBackward", "Brake", "AlignStraight", "AlignLeft", "AlignRight"),
        *("ToggleLighting", "Reset"),
    ]
)
FAULTS = ["sensor.silent", "robot.stuck", "wheel.dead", "motor.hot", "pipe.impassable"]


def _with(required: dict[str, Any], **optional: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    must = {
        key: value if isinstance(value, st.SearchStrategy) else st.just(value)
        for key, value in required.items()
    }
    return st.fixed_dictionaries(must, optional=optional)


def _some(steps: st.SearchStrategy[Any]) -> st.SearchStrategy[list[Any]]:
    return st.lists(steps, min_size=1, max_size=3)


COMMAND = _with(
    {"command": COMMANDS},
    timeout=st.sampled_from(["500 ms", "4 s"]),
    retry=st.integers(0, 2),
    unneeded=st.sampled_from(["skip", "fail"]),
    on_failure=st.one_of(TARGETS, st.just("continue")),
    **{"if": CONDITIONS},
)
LOG = st.just({"log": "a line, after {cause}"})
ASK = _with(
    {"ask": "Go on?"},
    choices=st.just({"yes": "continue", "no": "fail", "elsewhere": "p1"}),
    timeout=st.sampled_from(["100 ms", "20 s"]),
)
STEP = st.recursive(
    st.one_of(COMMAND, COMMANDS, COMMAND, LOG, ASK),
    lambda steps: st.one_of(
        st.fixed_dictionaries(
            {"repeat": st.fixed_dictionaries({"times": st.integers(1, 3), "do": _some(steps)})}
        ),
        _with(
            {
                "choose": st.lists(
                    st.fixed_dictionaries({"if": CONDITIONS, "do": _some(steps)}),
                    min_size=1,
                    max_size=2,
                )
            },
            **{"else": _some(steps)},
        ),
    ),
    max_leaves=3,
)


TRIGGER = st.one_of(
    _with({"when": CONDITIONS, "go": TARGETS}, held=TIMES),
    _with({"after": TIMES, "go": TARGETS}),
    _with({"operator": st.sampled_from(["yes", "no"]), "go": TARGETS}),
)
WAITING = _with(
    {
        "wait": st.lists(TRIGGER, min_size=1, max_size=3),
        "within": st.fixed_dictionaries({"time": TIMES, "go": TARGETS}),
    },
    do=_some(STEP),
)
GOING = _with({"do": _some(STEP), "go": TARGETS})
HANDLER = st.one_of(
    st.fixed_dictionaries({"fault": st.sampled_from(FAULTS), "then": st.just("continue")}),
    st.fixed_dictionaries({"fault": st.sampled_from(FAULTS), "go": TARGETS}),
)
MISSIONS = _with(
    {
        "format": st.just(1),
        "mission": st.just("invented"),
        "robot": st.just("pirate_ii"),
        "start": st.sampled_from(PHASES),
        "phases": st.fixed_dictionaries({name: st.one_of(WAITING, GOING) for name in PHASES}),
        "ends": st.just({"good": {"succeed": "Good"}, "bad": {"fail": "Bad: {cause}"}}),
    },
    time_limit=st.sampled_from(["500 ms", "30 s"]),
    on_failure=TARGETS,
    on_fault=st.lists(HANDLER, max_size=3),
    polarity=st.sampled_from(["normal", "mirrored"]),
    starts_in=st.sampled_from(
        [
            {
                "BendingState": "DoubleClamped",
                "FrontWheelsState": "Fixed",
                "RearWheelsState": "Fixed",
            },
            {
                "BendingState": "DoubleClamped",
                "FrontWheelsState": "DrivingForward",
                "RearWheelsState": "DrivingForward",
            },
            {"BendingState": "RearClampedFrontBending", "RearWheelsState": "DrivingForward"},
        ]
    ),
)


def program_of(mission: dict[str, Any]) -> tuple[Mission, Program]:
    document = parse_document(json.dumps(mission, indent=1), "invented.yaml")
    model = validate(document, Mission)
    problems = Problems(document)
    source = Source(model, document, Path("invented.yaml"))
    program, _ = build_program(source, load_robot(PIRATE), {}, None, None, problems)
    return model, program
