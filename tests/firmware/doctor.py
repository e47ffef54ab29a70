"""The doctor's examination of the binary, in virtual time."""

from __future__ import annotations

from pirate_sm.core.loading import LoadedMission
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.diagnosis.facts import ExpectedRobot, Facts
from pirate_sm.robot.diagnosis.judgement import judged
from pirate_sm.robot.diagnosis.listening import Listening
from pirate_sm.robot.diagnosis.moving import Moving
from tests.unit.robot.diagnosis.conftest import BayPort

from .avr_bay import AvrBay, Built


def examined(
    built: Built, loaded: LoadedMission, dead: int | None = None, plan: LinkPlan | None = None
) -> Facts:
    """Examine the robot of a mission in its pipe.

    Its wheels are moved, unless a board is dead or another plan than the robot's is expected.
    """
    robot, moves = loaded.loaded_robot, dead is None and plan is None
    plan = plan or read_plan(robot.folder, robot.profile, loaded.robot)
    bay = AvrBay(built, robot.profile, robot.folder, loaded.pipe, seed=3)
    bay.dead.update({dead} if dead is not None else ())
    subject = ExpectedRobot(robot.profile, loaded.robot, plan)
    with Listening(subject, BayPort(bay), plan.serial.baud, lambda: None) as listening:
        listening.listen(5.0)
        facts = listening.facts()
        if moves:
            moved = Moving(listening, lambda text: None).run()
            assert moved.accepted == moved.sent
    return judged(facts, subject)
