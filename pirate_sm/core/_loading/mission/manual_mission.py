"""A mission that only waits, for driving the robot by hand."""

from __future__ import annotations

from math import inf

from pirate_sm.core._engine.mission.program import Enter, HandlerSpec, Program, Wait
from pirate_sm.core._loading.mission.loader import LoadedMission
from pirate_sm.core._loading.robot.loader import LoadedRobot
from pirate_sm.core._model.mission import End, Mission, Phase
from pirate_sm.core._model.pipe import Pipe

BY_HAND = "by_hand"


def by_hand(robot: LoadedRobot, pipe: Pipe | None = None, pipe_name: str = "") -> LoadedMission:
    """Return a mission with one endless wait, in which only the operator moves the robot.

    Faults that a mission may handle are only reported, because the operator is present. All other
    faults end it in the safe state. Safety rules that a mission may waive are waived.
    """
    spec = robot.normal
    codes = [code for code, catchable in spec.fault_codes.items() if catchable]
    handlers = tuple(HandlerSpec(code, None, "") for code in codes)
    bores_m = pipe.bores_m(sum(spec.body.lengths_m)) if pipe is not None else ()
    program = Program(
        mission=BY_HAND,
        instructions=(Enter(BY_HAND, 1), Wait(BY_HAND, (), inf, -1, "", "")),
        start=0,
        start_configuration=robot.table.initial,
        handlers=(handlers, handlers),
        phases=(BY_HAND,),
        phase_of=(BY_HAND, BY_HAND),
        ends=(),
        time_limit_s=inf,
        rules=tuple(rule for rule in robot.rules if not rule.waived_by),
        diameter_m=bores_m[0] if bores_m else None,
        bores_m=bores_m,
    )
    mission = Mission(
        format=1,
        mission=BY_HAND,
        robot=robot.profile.robot,
        start=BY_HAND,
        phases={BY_HAND: Phase(go=BY_HAND)},
        ends={BY_HAND: End(succeed="")},
    )
    return LoadedMission(mission, robot, spec, program, pipe, pipe_name, robot.documents, {}, {})
