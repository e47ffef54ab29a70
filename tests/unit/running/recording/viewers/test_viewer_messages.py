"""What viewers are shown is of the types that Foxglove has published, and true."""

from __future__ import annotations

import json
from collections import defaultdict
from math import atan2, cos, hypot, isclose, nan, sin
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from keeping import header
from mcap.reader import make_reader
from recording_runs import ROOT, record_with_viewers
from representative import thorough_but

from pirate_sm.core import effects as fx
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_mission
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.viewers.live_server import Live
from pirate_sm.running.recording.viewers.viewer_messages import ViewerMessages, ViewerSnapshot
from pirate_sm.running.recording.write.sampler import EVERY_S
from pirate_sm.running.wiring import Order, prepare

NEWT = ROOT / "tests" / "robots" / "newt"
SCHEMAS = ROOT / "pirate_sm" / "running" / "recording" / "viewers" / "foxglove_schemas"
FOXGLOVE = {
    "/tf": "foxglove.FrameTransforms",
    "/scene": "foxglove.SceneUpdate",
    "/joint_states": "foxglove.JointStates",
    "/log": "foxglove.Log",
}
FLAT = {"/signals", "/setpoints", "/places", "/state"}
RUNS = {
    "sim": Order("mitre_bend"),
    "trace": Order("mitre_bend", backend="trace"),
    "odometry": Order("mitre_bend", detector="odometry"),
    "rolled": Order("exp_2a_commands"),
    "another robot": Order(str(NEWT / "patrol.yaml")),
}


@pytest.fixture(scope="module", params=thorough_but({"odometry", "trace", "another robot"}, RUNS))
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("runs") / "run.mcap"
    kept = record_with_viewers(path, RUNS[request.param])
    assert kept.tap is not None
    assert kept.tap.failure == ""
    assert kept.recording is not None
    assert kept.recording.side.failure == ""
    return path


def messages(path: Path) -> dict[str, list[dict[str, Any]]]:
    found: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for each in read_recording(path).shown():
        found[each.topic].append(each.content)
    return found


@pytest.mark.thorough
def test_every_message_is_of_the_type_that_was_published(recording: Path) -> None:
    kinds: dict[str, str] = {}
    with recording.open("rb") as stream:
        validators: dict[str, Any] = {}
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            assert channel.message_encoding == "json"
            kinds[channel.topic] = schema.name
            if channel.topic not in validators:
                published = json.loads(schema.data)
                if channel.topic in FOXGLOVE:
                    file = SCHEMAS / f"{schema.name}.json"
                    assert published == json.loads(file.read_text("utf-8"))
                kind = jsonschema.Draft202012Validator
                validators[channel.topic] = kind(published)
            validators[channel.topic].validate(json.loads(message.data))
    shown = {topic: kind for topic, kind in kinds.items() if not topic.startswith("/engine/")}
    assert shown.keys() == FOXGLOVE.keys() | FLAT
    assert {topic: shown[topic] for topic in FOXGLOVE} == FOXGLOVE


def test_signals_that_nothing_reads_are_estimated_for_viewers(tmp_path: Path) -> None:
    record_with_viewers(tmp_path / "run.mcap", RUNS["odometry"])

    forces = [each.get("normal_force_1_N") for each in messages(tmp_path / "run.mcap")["/signals"]]

    assert sum(force is not None and force > 5 for force in forces) > len(forces) / 4


def check_for_lichtblick(schema: dict[str, Any]) -> None:
    """Raise where Lichtblick 1.x would drop the topic.

    Its parser (parseJsonSchema) knows objects with properties, one plain type per field, and
    arrays of plain types or objects; everything else is an error there.
    """
    assert schema["type"] == "object"
    for name, field in schema["properties"].items():
        if "oneOf" in field:  # how Foxglove publishes its enumerations
            assert all("const" in each for each in field["oneOf"]), name
            continue
        assert isinstance(field["type"], str), name
        if field["type"] == "array":
            item = field["items"]
            assert item["type"] in {"boolean", "string", "number", "integer", "object"}, name
            if item["type"] == "object":
                check_for_lichtblick(item)
        elif field["type"] == "object":
            check_for_lichtblick(field)
        else:
            assert field["type"] in {"boolean", "string", "number", "integer"}, name


def test_lichtblick_takes_every_topic(recording: Path) -> None:
    with recording.open("rb") as stream:
        schemas = make_reader(stream).get_summary().schemas.values()  # type: ignore[union-attr]
    assert len(schemas) > len(FOXGLOVE) + len(FLAT)
    for schema in schemas:
        check_for_lichtblick(json.loads(schema.data))


def test_what_is_unknown_is_left_out(recording: Path) -> None:
    for topic in ("/signals", "/places", "/setpoints"):
        for content in messages(recording).get(topic, []):
            assert all(value is not None for value in content.values())


def test_states_have_codes_that_plot_beside_their_words(recording: Path) -> None:
    with recording.open("rb") as stream:
        schemas = make_reader(stream).get_summary().schemas.values()  # type: ignore[union-attr]
    (published,) = (json.loads(each.data) for each in schemas if each.name == "pirate_sm.state")
    for content in messages(recording)["/state"]:
        for region in (name for name in content if f"{name}_code" in content):
            legend = published["properties"][f"{region}_code"]["description"]
            assert f"{content[f'{region}_code']} {content[region]}" in legend.split(", ")


def test_numbers_and_words_are_all_named_by_the_schema(recording: Path) -> None:
    with recording.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            if channel.topic in FLAT:
                known = json.loads(schema.data)["properties"].keys()
                assert json.loads(message.data).keys() <= known


def test_the_frames_put_every_wheel_where_it_is(recording: Path) -> None:
    found = messages(recording)
    assert found["/tf"]
    for frames, places in zip(found["/tf"], found["/places"], strict=True):
        for wheel, (x, y) in _wheels(frames["transforms"]).items():
            if f"{wheel}_x_m" in places:
                assert isclose(x, places[f"{wheel}_x_m"], abs_tol=2e-3)
                assert isclose(y, places[f"{wheel}_y_m"], abs_tol=2e-3)


def _wheels(transforms: list[dict[str, Any]]) -> dict[str, tuple[float, float]]:
    """The place of each frame in the plane; frames that turn about x lie in it all the same."""
    known: dict[str, tuple[float, float, float]] = {"pipe": (0.0, 0.0, 0.0)}
    for each in transforms:
        x, y, heading = known[each["parent_frame_id"]]
        dx, dy = each["translation"]["x"], each["translation"]["y"]
        turned = each["rotation"]
        assert isclose(hypot(turned["x"], turned["y"], turned["z"], turned["w"]), 1.0, abs_tol=1e-5)
        known[each["child_frame_id"]] = (
            x + dx * cos(heading) - dy * sin(heading),
            y + dx * sin(heading) + dy * cos(heading),
            heading + 2 * atan2(turned["z"], turned["w"]),
        )
    return {name: (x, y) for name, (x, y, _) in known.items()}


def test_everything_drawn_has_a_frame(recording: Path) -> None:
    found = messages(recording)
    frames = {each["child_frame_id"] for each in found["/tf"][0]["transforms"]} | {"pipe"}
    (scene,) = found["/scene"]

    assert {entity["frame_id"] for entity in scene["entities"]} == frames


def test_a_viewer_sees_ten_pictures_a_second() -> None:
    assert 1 / 20 <= EVERY_S <= 1 / 10


def test_the_log_tells_phases_commands_and_the_end(recording: Path) -> None:
    lines = [line["message"] for line in messages(recording)["/log"]]

    assert any(line.startswith("phase ") for line in lines)
    assert any(line.endswith(" sent") for line in lines)
    assert lines[-1].startswith("ended succeeded")


def test_signals_that_are_unknown_or_infinite_are_left_out() -> None:
    loaded = load_mission(library.find_mission("mitre_bend"))
    prepared = prepare(Order("mitre_bend", backend="trace"), loaded)
    state, _ = prepared.engine.start(0.0)
    numbers = (nan, float("inf"), 1.0, *state.sensing.numbers[3:])
    state = state._replace(sensing=state.sensing._replace(numbers=numbers))
    viewer = ViewerMessages(loaded, None)

    found = {
        channel.topic: json.loads(data)
        for channel, data in viewer.sample(
            2.0, 10**18 + 5, ViewerSnapshot(state, state.sensing.shown, None, False)
        )
    }

    assert list(found["/signals"].values())[:1] == [1.0]
    assert found["/joint_states"]["timestamp"] == {"sec": 10**9, "nsec": 5}
    assert any(joint.keys() == {"name"} for joint in found["/joint_states"]["joints"])
    assert not found["/places"]["known"]


@pytest.mark.parametrize(
    ("effect", "expected"),
    [
        (fx.Log("warning", "careful"), (3, "careful", "", 0)),
        (
            fx.CommandStatus("Go", "refused", "no", "some:where.yaml:12:3"),
            (3, "command Go refused: no", "some:where.yaml", 12),
        ),
        (fx.CommandStatus("Go", "sent"), (2, "command Go sent", "", 0)),
        (fx.PhaseChange("there"), (2, "phase there", "", 0)),
        (
            fx.WaitArmed("p", ("a", "b"), ("x > 1", "y > 2"), 1.0),
            (2, "waits for x > 1 or y > 2, at most until 1.0 s", "", 0),
        ),
        (fx.TriggerFired("p", "a", "q", "why"), (2, "trigger why → q", "", 0)),
        (fx.Detected("close"), (2, "detected close", "", 0)),
        (fx.Fault("x.y", "bad", "stop"), (4, "fault x.y: bad (safe stop)", "", 0)),
        (fx.Fault("x.y", "bad", "back"), (3, "fault x.y: bad (→ back)", "", 0)),
        (fx.Ask("Well?", ("yes", "no")), (2, "asks Well? (yes / no)", "", 0)),
        (fx.Ask("", ()), None),
        (fx.Ended("failed", "over"), (4, "ended failed: over", "", 0)),
        (fx.WakeAt(3.0), None),
    ],
)
def test_an_effect_is_a_line_of_the_log(
    effect: fx.Effect, expected: tuple[int, str, str, int] | None
) -> None:
    viewer = ViewerMessages(load_mission(library.find_mission("mitre_bend")), None)

    lines = [
        tuple(json.loads(data)[key] for key in ("level", "message", "file", "line"))
        for channel, data in viewer.of_effects(0, [effect])
        if channel.topic == "/log"
    ]

    assert lines == ([] if expected is None else [expected])


def test_viewers_that_look_on_see_the_same(tmp_path: Path) -> None:
    foxglove = pytest.importorskip("foxglove")
    live = Live(port=0)
    loaded = load_mission(library.find_mission("mitre_bend"))
    channel, data = ViewerMessages(loaded, None).scene(10**18)
    with foxglove.open_mcap(str(tmp_path / "served.mcap"), context=live._context):
        live.show(channel, 10**18, data)
    port = int(live.address.rpartition(":")[2])
    with pytest.raises(UsageError, match="--live cannot serve"):
        Live(port)
    live.close()

    with (tmp_path / "served.mcap").open("rb") as stream:
        ((schema, served, message),) = make_reader(stream).iter_messages()
    assert schema is not None
    assert (served.topic, schema.name) == ("/scene", "foxglove.SceneUpdate")
    assert (message.data, message.log_time) == (data, 10**18)
    assert live.address.startswith("ws://127.0.0.1:")


def test_the_header_names_every_channel_and_slot() -> None:
    found = header()

    assert found.boards[22][0] == "bend_angle"
    assert ("rotate", "angle") in found.slots
