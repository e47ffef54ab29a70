"""Lists and loads the missions that the operator can choose."""

from __future__ import annotations

from collections import Counter
from functools import partial
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.gate import pass_or_raise
from pirate_sm.core import library
from pirate_sm.core.documents import read_document
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.generated_missions import by_hand
from pirate_sm.core.loading import LoadedMission, load_pipe, load_robot, with_fitted
from pirate_sm.core.models import SIMULATORS
from pirate_sm.robot.detectors.registry import speaks_of_bends
from pirate_sm.running.wiring import Order, chosen, fit_of, load
from pirate_sm.views.console import availability
from pirate_sm.views.console.confirmed_actions import ConfirmedActions
from pirate_sm.views.console.dialogs import Pick, PickLine


class ListedMission(NamedTuple):
    """A mission as shown in the list."""

    path: Path
    name: str
    description: str
    robot: str
    pipe: str


def listed_missions(folder: Path | None = None) -> list[ListedMission]:
    """Return the missions in a folder, then the shipped ones; leave out other files."""
    own = sorted(folder.glob("*.yaml")) if folder is not None else []
    found = {each.resolve(): each for each in (*own, *library.missions())}
    return [listed for path in found.values() if (listed := _listed(path)) is not None]


def _listed(path: Path) -> ListedMission | None:
    try:
        data = read_document(path, path.name).data
    except PirateError:
        return None
    if not isinstance(data, dict) or "mission" not in data:
        return None
    pipe = data.get("pipe")
    description, robot = (str(data.get(key, "")) for key in ("description", "robot"))
    return ListedMission(path, path.stem, description, robot, pipe if isinstance(pipe, str) else "")


def load_listed(order: Order, path: Path) -> LoadedMission:
    """Return the mission in this file, for the console's robot and pipe.

    Raises:
        LoadError: The file has errors; it lists all of them.
        UsageError: An argument does not fit the mission.
        CheckError: The mission is refused.
    """
    loaded = load(chosen(order, str(path)))
    if order.check:
        pass_or_raise(loaded, words_of_bends=speaks_of_bends(order.detector), backend=order.backend)
    return loaded


def without_mission(order: Order) -> LoadedMission:
    """Return a robot without a mission: the named or first shipped one, in the named pipe.

    By default the pipe is the one of most missions of this robot.

    Raises:
        LoadError: A file cannot be used.
        UsageError: There is no such robot or pipe.
    """
    if order.robot is not None:
        folder = library.find_robot(order.robot, Path.cwd())
    elif robots := library.robots():
        folder = robots[0]
    else:
        raise UsageError("no robot is shipped: name one with --robot")
    robot = with_fitted(load_robot(folder), fit_of(order))
    name = order.pipe or (_usual_pipe(folder.name) if order.backend in SIMULATORS else "")
    if not name:
        return by_hand(robot)
    pipe, document = load_pipe(library.find_pipe(name, Path.cwd()))
    return by_hand(robot, pipe, pipe.pipe or Path(document.name).stem)


def _usual_pipe(robot: str) -> str:
    missions = (each for each in listed_missions() if each.robot == robot)
    pipes = Counter(each.pipe for each in missions if each.pipe)
    return pipes.most_common(1)[0][0] if pipes else ""


class MissionActions(ConfirmedActions):
    """The list of missions, and the change to another one."""

    def action_missions(self) -> None:
        """Read the missions in the background, then show the list."""
        if self.session.latest.over:
            self._refuse("missions", availability.OVER)
            return
        look = partial(listed_missions, Path.cwd())
        self.run_worker(look, thread=True, group="missions", exclusive=True, exit_on_error=False)

    def _choose_mission(self, missions: list[ListedMission]) -> None:
        robot = self.session.latest.scene.loaded.loaded_robot.folder.name
        choices = [
            PickLine(
                str(each.path),
                each.name,
                each.description,
                "" if each.robot == robot else f"it is for {each.robot}",
            )
            for each in missions
        ]
        self.push_screen(Pick("Missions", choices), self._load)

    def _load(self, path: str | None) -> None:
        if path is None:
            return
        self.notify(f"loading {Path(path).stem} …", timeout=2, markup=False)
        load = partial(load_listed, self.session.prepared.order, Path(path))
        self.run_worker(load, thread=True, group="load", exclusive=True, exit_on_error=False)

    def _take_up(self, loaded: LoadedMission) -> None:
        reason = availability.why_not_mission(self.session.latest, loaded)
        if reason:
            self._refuse(loaded.mission.mission, reason)
            return
        self.session.change(loaded)
        written_for = loaded.pipe_name
        here = self.session.prepared.loaded.pipe_name
        if written_for != here:
            name, pipe = loaded.mission.mission, written_for or "no pipe"
            text = f"{name} is written for {pipe}; the robot is in {here or 'a pipe not named'}"
            self.notify(text, severity="warning", timeout=8, markup=False)
