"""What files of somebody else may ask for: scenes, campaigns, pirate.toml, missions, recordings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from inspect import Parameter
from pathlib import Path
from typing import get_args

import pytest

from pirate_sm.checking import permissions
from pirate_sm.cli import settings
from pirate_sm.cli.command_line import COMMANDS, found
from pirate_sm.cli.options.declaring import parameters_of
from pirate_sm.cli.scene_steps import simulating, why_refused
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.lab.campaign.campaign_file import check_campaign
from pirate_sm.lab.campaign.campaign_model import SimulatedBackend
from pirate_sm.running.wiring import Order
from pirate_sm.running.wiring.resume_offer import EndOfRun, end_of_run
from pirate_sm.running.wiring.resumed_run import prepare_again
from tests.unit.running.recording.recording_runs import record_cut_off

MISSION = Path("sequences/mitre_bend.yaml")


def _parameters(command: str) -> list[Parameter]:
    return parameters_of(found("options", COMMANDS[command][0]))


def test_the_list_names_commands_and_options_that_there_are() -> None:
    for command, allowed in permissions.SCENES.items():
        assert allowed <= {each.name for each in _parameters(command)}
    for command, written in permissions.WRITES.items():
        assert set(written) <= permissions.SCENES[command]


@pytest.mark.parametrize("command", permissions.SCENES)
def test_every_option_of_a_scene_that_can_write_is_kept_below_its_folder(
    command: str, tmp_path: Path
) -> None:
    reads = {"file", "mission", "twin", "fitted", "script", "counterexample", "resume", "robot"}
    reads.add("forecast")
    for each in _parameters(command):
        kind = str(get_args(each.annotation)[1].metavar)
        names_a_file = "FILE" in kind or "DIR" in kind or "OUT" in kind
        if each.name in permissions.SCENES[command] and names_a_file and each.name not in reads:
            assert each.name in permissions.WRITES[command]


@pytest.mark.parametrize(
    "step",
    [
        "run mitre_bend --backend serial --port /dev/ttyACM0 --yes",
        "run mitre_bend --backend=serial",
        "run mitre_bend --port socket://there:1",
        "run mitre_bend --detector socket:0.0.0.0:9000",
        "run mitre_bend --also socket",
        "run mitre_bend --live",
        "run mitre_bend --panel any",
        "run mitre_bend --record {out}/run.mcap --record {out}/../run.mcap",
        "run mitre_bend --record={out}/../run.mcap",
        "graph mitre_bend -o /tmp/any.svg --overwrite",
        "graph mitre_bend -o../any.svg",
        "report {out}/run.mcap -o {out}/../../../X",
        "report elsewhere/run.mcap",
        "repair elsewhere/run.mcap",
        "map {out}/run.mcap -o ../X",
        "map {out}/run.mcap -o {out}/link/X",
        "export {out}/run.mcap --csv elsewhere",
        "fit --robot {out}/run.mcap --write ../twin.yaml",
        "check . --counterexamples elsewhere",
        "doctor",
        "calibrate",
        "console",
        "new robot mine",
        "run --help",
        "list --nonsense",
    ],
)
def test_a_scene_cannot_reach_a_robot_or_write_outside_its_folder(
    step: str, tmp_path: Path
) -> None:
    own = tmp_path / "runs" / "own"
    own.mkdir(parents=True)
    (own / "link").symlink_to(tmp_path)

    assert why_refused(step.replace("{out}", str(own)).split(), own)


def test_an_option_is_refused_as_it_is_written(tmp_path: Path) -> None:
    refused = why_refused(["run", "mitre_bend", "--guard-for", "5s", "--set", "a=1"], tmp_path)

    assert refused == "a scene cannot give 'run' the option --guard-for"


@pytest.mark.parametrize(
    "step",
    [
        "run mitre_bend --backend bay --line cut_after=12s --record {out}/run.mcap",
        "run mitre_bend --detector vision:setup --no-record",
        "run mitre_bend --detector odometry --start-at 700mm --no-record",
        "map {out}/run.mcap -o {out}/map.yaml",
        "graph mitre_bend --output={out}/a/b.svg",
        "fit --robot {out}/run.mcap --write {out}/twin.yaml",
        "check nowhere.yaml",
    ],
)
def test_a_scene_may_simulate_and_write_below_its_folder(step: str, tmp_path: Path) -> None:
    assert why_refused(step.replace("{out}", str(tmp_path)).split(), tmp_path) == ""


def test_no_setting_chooses_what_runs_a_scene_or_where_it_is_recorded() -> None:
    whole = ["run", "mitre_bend", "--backend", "sim", "--no-record"]

    assert simulating(["run", "mitre_bend"]) == whole
    assert simulating(whole) == whole


@pytest.fixture
def on_a_robot(tmp_path: Path) -> Callable[..., EndOfRun]:
    """Returns where a recording ends that says it is of a real robot at a port."""
    record_cut_off(tmp_path / "cut.mcap", Order("mitre_bend"), 2.0)
    end = end_of_run(tmp_path / "cut.mcap")

    def at(port: str, detector: str = "") -> EndOfRun:
        chosen = {"port": port, "detector": detector or None}
        header = replace(
            end.recording.header,
            backend="serial",
            options={**end.recording.header.options, **chosen},
        )
        return end._replace(recording=replace(end.recording, header=header))

    return at


@pytest.mark.parametrize("port", ["spy:///dev/ttyACM0?file=/home/a/x", "socket://there:1", "../x"])
def test_a_recording_cannot_choose_an_address_as_port(
    on_a_robot: Callable[..., EndOfRun], port: str
) -> None:
    with pytest.raises(UsageError, match="is not a device of this computer"):
        prepare_again(on_a_robot(port), Order("mitre_bend"))


def test_a_recording_cannot_open_a_socket(on_a_robot: Callable[..., EndOfRun]) -> None:
    end = on_a_robot("/dev/ttyACM0", "socket:0.0.0.0:9000")
    with pytest.raises(UsageError, match=r"the detector of the recording, .* opens a socket"):
        prepare_again(end, Order("mitre_bend"))

    prepare_again(end, Order("mitre_bend", detector="odometry"))


@pytest.mark.parametrize(
    ("port", "allowed"),
    [
        ("", True),
        ("/dev/ttyUSB0", True),
        ("/dev/serial/by-id/usb-Arduino_Mega_7543-if00", True),
        ("/dev/cu.usbmodem1101", True),
        ("COM3", True),
        ("/dev/pirate", True),
        ("/dev/tty/../sda", False),
        ("socket://there:1", False),
    ],
)
def test_a_port_is_a_serial_line_of_this_computer(port: str, allowed: bool) -> None:
    assert permissions.is_device(port) == allowed


def test_a_campaign_only_simulates(tmp_path: Path) -> None:
    assert set(get_args(SimulatedBackend)) <= set(permissions.SIMULATED)
    path = tmp_path / "trial.yaml"
    path.write_text(
        "format: 1\ncampaign: trial\nmissions: [mitre_bend]\nseeds: 2\n"
        "detector: 'socket:0.0.0.0:9000'\n",
        "utf-8",
    )

    _, found = check_campaign(path)
    assert "a campaign only simulates: 'socket:0.0.0.0:9000' opens a socket" in str(found)


@pytest.mark.parametrize("key", ["backend: serial", "port: /dev/ttyACM0", "record: /tmp/x.mcap"])
def test_a_mission_has_no_key_that_reaches_a_robot_or_a_file_to_write(
    key: str, tmp_path: Path
) -> None:
    path = tmp_path / "asks.yaml"
    path.write_text(f"{MISSION.read_text('utf-8')}\n{key}\n", "utf-8")

    with pytest.raises(LoadError, match=key.partition(":")[0]):
        load_mission(path)


@pytest.mark.parametrize(
    ("name", "value"), [("backend", "serial"), ("port", "/dev/ttyACM0"), ("runs", "../elsewhere")]
)
def test_a_project_cannot_reach_a_robot(name: str, value: str, tmp_path: Path) -> None:
    trusted = settings.SettingValue((), settings.BUILT_IN)

    assert settings._refused(name, str(tmp_path / value), tmp_path / "pirate.toml", trusted)
