"""Lets the operator choose a mission."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from pirate_sm.core.loading import LoadedMission
from pirate_sm.views.console import availability
from pirate_sm.views.console.confirmed_actions import ConfirmedActions
from pirate_sm.views.console.dialogs import Pick, PickLine
from pirate_sm.views.console.mission_list import ListedMission, listed_missions, load_listed


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
