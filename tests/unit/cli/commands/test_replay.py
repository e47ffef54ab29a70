"""`pirate replay` and `pirate repair`, as a person meets them."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import pytest
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from typer.testing import CliRunner

from pirate_sm.cli.commands.replay import field_words
from pirate_sm.cli.entry import only_run
from pirate_sm.core import effects as fx
from pirate_sm.core.events import Answer, Tick
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.write import piece_maker, recorder

ROOT = Path(__file__).resolve().parents[4]
PIPE = "sequences/pipes/mitre_90.yaml"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A run of half a minute with a checkpoint every two seconds, in several pieces."""
    path = tmp_path_factory.mktemp("runs") / "run.mcap"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "CHECKPOINT_S", 2.0)
        patch.setattr(recorder, "_HELP_AT", 50)
        patch.setattr(recorder, "_MOST_STEPS", 200)
        CliRunner().invoke(only_run(), ["mitre_bend", "--quiet", "--record", str(path)])
    return path.read_bytes()


@pytest.fixture
def run(recorded: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = Path("run.mcap")
    path.write_bytes(recorded)
    return path


def chunks_in(data: bytes) -> list[tuple[int, int]]:
    """Where each piece begins and ends."""
    at, found = len(MCAP0_MAGIC), []
    while at < len(data) - len(MCAP0_MAGIC):
        end = at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
        if data[at] == Opcode.CHUNK:
            found.append((at, end))
        at = end
    return found


def test_the_whole_run_comes_out_the_same(pirate: Any, run: Path) -> None:
    result = pirate("replay", run)

    assert result.exit_code == 0
    assert "replayed identically" in result.stdout


def test_a_stretch_begins_at_the_checkpoint_before_it(pirate: Any, run: Path) -> None:
    result = pirate("replay", run, "--from", "9 s", "--until", "0.2 min")

    ((since, until),) = re.findall(r"from ([\d.]+) s up to ([\d.]+) s", result.stdout)
    assert result.exit_code == 0
    assert 7.0 < float(since) <= 9.0
    assert 11.9 < float(until) <= 12.0


def test_a_stretch_for_which_there_is_no_checkpoint_begins_at_the_start(
    pirate: Any, run: Path
) -> None:
    result = pirate("replay", run, "--from", "1 s", "--until", "2 s")

    assert result.exit_code == 0
    assert "it begins at the start" in result.stdout
    assert "inputs, up to 1.9" in result.stdout or "inputs, up to 2.0" in result.stdout


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--from", "soon"), "--from: expected a duration"),
        (("--until", "3 m"), "--until: expected a duration"),
        (("--from", "5 s", "--until", "5 s"), "--until must be later than --from"),
        (("--until", "0 s"), "--until must be later than the start of the run"),
        (("--from", "-5 s"), "is not negative"),
        (("--from", "5 s", "--mission", "mitre_bend"), "excludes another --mission"),
    ],
)
def test_a_stretch_that_cannot_be_is_refused(
    options: tuple[str, ...], said: str, pirate: Any, run: Path
) -> None:
    result = pirate("replay", run, *options)

    assert result.exit_code == 2
    assert said in result.stderr


def test_where_nothing_was_executed_nothing_came_out_the_same(pirate: Any, run: Path) -> None:
    data = run.read_bytes()
    Path("empty.mcap").write_bytes(data[: chunks_in(data)[0][0]])
    nothing = pirate("replay", "empty.mcap")
    beyond = pirate("replay", run, "--from", "1 h")

    assert (nothing.exit_code, beyond.exit_code) == (2, 2)
    assert "before the engine was started" in nothing.stderr
    assert "holds nothing after" in beyond.stderr
    assert "the same" not in nothing.stdout + beyond.stdout


def test_a_state_that_differs_without_an_effect_is_reported(pirate: Any, tmp_path: Path) -> None:
    right = piece_maker.state_to_text
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "CHECKPOINT_S", 2.0)
        patch.setattr(piece_maker, "state_to_text", lambda it: right(it._replace(wake_at_s=1e6)))
        path = tmp_path / "other.mcap"
        CliRunner().invoke(only_run(), ["mitre_bend", "--quiet", "--record", str(path)])
    result = pirate("replay", path)

    assert result.exit_code == 1
    assert "but the engine's state differs in wake_at_s" in result.stdout
    assert "nothing" not in result.stdout


def test_a_recording_that_was_cut_short_is_repaired(
    pirate: Any, run: Path, recorded: bytes
) -> None:
    before = recorded[: chunks_in(recorded)[3][0] + 1_000]
    torn = Path("cut.mcap")
    torn.write_bytes(before)
    result = pirate("repair", torn)
    again = pirate("replay", "cut.repaired.mcap")

    assert result.exit_code == 0
    assert torn.read_bytes() == before
    assert "cut.repaired.mcap holds" in result.stdout
    assert "the last 1000 bytes of the file, which are not whole" in result.stdout
    assert again.exit_code == 0
    assert "the recording ends early" in again.stdout
    assert "the recording ends there" in again.stdout


def test_a_whole_recording_is_left_alone(pirate: Any, run: Path) -> None:
    result = pirate("repair", run)

    assert result.exit_code == 0
    assert "there is nothing to repair" in result.stdout
    assert [path.name for path in Path().iterdir()] == ["run.mcap"]


def test_nothing_is_overwritten(pirate: Any, run: Path, recorded: bytes) -> None:
    torn = Path("cut.mcap")
    torn.write_bytes(recorded[:-5_000])
    Path("mine.mcap").write_text("mine")
    for output in (torn, "mine.mcap"):
        result = pirate("repair", torn, "-o", output)
        assert result.exit_code == 2
        assert "exists already" in result.stderr
    assert Path("mine.mcap").read_text() == "mine"


@pytest.mark.thorough
def test_damage_leaves_a_gap_that_every_command_says(
    pirate: Any, run: Path, recorded: bytes
) -> None:
    data = bytearray(recorded)
    begins, ends = chunks_in(recorded)[4]
    data[(begins + ends) // 2] ^= 0xFF
    Path("bad.mcap").write_bytes(data)
    refused = pirate("replay", "bad.mcap")
    result = pirate("repair", "bad.mcap")

    assert refused.exit_code == 2
    assert result.exit_code == 0
    (gap,) = read_recording(Path("bad.repaired.mcap")).gaps
    stretch = f"from {gap.from_s:.3f} s to {gap.until_s:.3f} s"
    assert f"lost: what came {stretch}" in result.stdout
    viewed = pirate("export", "bad.repaired.mcap", "--viewers", "viewed.mcap", "--csv", "tables")
    assert viewed.exit_code == 0, viewed.output
    assert read_recording(Path("viewed.mcap")).gaps == (gap,)
    for name in ("bad.repaired.mcap", "viewed.mcap"):
        again, report = pirate("replay", name), pirate("report", name)
        assert again.exit_code == 0
        assert f"up to {gap.from_s:.3f} s, where it stops" in again.stdout
        assert f"nothing is known {stretch}" in again.stdout
        assert f"nothing is known {stretch}" in report.output
        assert f"othing is known {stretch}" in Path(name).with_suffix(".html").read_text("utf-8")
    with Path("tables/signals.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    after = [row for row in rows if float(row["time_s"]) >= gap.until_s]
    assert len(after) > len(rows) / 2
    unknown = [row for row in after if not row["odometry_m"]]
    assert 0 < len(unknown) < len(after)
    assert unknown == after[: len(unknown)]
    assert float(unknown[-1]["time_s"]) < gap.until_s + 2.2  # up to the next checkpoint
    assert all(row["gamma_1_rad"] for row in after[20:])  # each board has reported


def test_what_came_after_the_end_is_not_called_lost_where_a_piece_is_missing_before_it(
    pirate: Any, run: Path, recorded: bytes
) -> None:
    begins, ends = chunks_in(recorded)[4]
    Path("gap.mcap").write_bytes(recorded[:begins] + recorded[ends:])
    result = pirate("repair", "gap.mcap")

    ((_, from_s, until_s),) = read_recording(Path("gap.repaired.mcap")).gaps
    assert result.stdout.splitlines()[1:] == [
        f"lost: what came from {from_s:.3f} s to {until_s:.3f} s"
    ]


def test_a_file_is_not_repaired_where_nothing_could_use_it(
    pirate: Any, run: Path, recorded: bytes
) -> None:
    Path("torn.mcap").write_bytes(recorded[: chunks_in(recorded)[0][0] + 100])
    result = pirate("repair", "torn.mcap")

    assert result.exit_code == 2
    assert "no input of the run is whole in torn.mcap" in result.stderr
    assert not Path("torn.repaired.mcap").exists()


@pytest.mark.thorough
def test_of_a_run_whose_end_is_there_nothing_is_said_that_nobody_knows(
    pirate: Any, run: Path, recorded: bytes
) -> None:
    Path("cut.mcap").write_bytes(recorded[: chunks_in(recorded)[-1][1]])
    said = [pirate(command, "cut.mcap").stdout for command in ("replay", "repair")]
    said.append(pirate("replay", "cut.repaired.mcap").stdout)

    assert all("the run had ended" in each for each in (said[0], said[2]))
    assert not re.search("killed|full|cut short|written|early", "".join(said))


@pytest.mark.parametrize("piece", [1, 4])
def test_what_comes_before_missing_bytes_is_saved(
    piece: int, pirate: Any, run: Path, recorded: bytes
) -> None:
    begins, ends = chunks_in(recorded)[piece]
    Path("gap.mcap").write_bytes(recorded[: begins + 100] + recorded[ends + 100 :])
    refused = pirate("replay", "gap.mcap")
    result = pirate("repair", "gap.mcap")
    again = pirate("replay", "gap.repaired.mcap")
    whole = read_recording(run)
    saved = read_recording(Path("gap.repaired.mcap"))

    assert refused.exit_code == 2
    assert re.search(r"is damaged: at byte \d+; pirate repair saves what", refused.stderr)
    assert result.exit_code == 0
    assert re.search(r"lost: what is damaged at byte \d+\n", result.stdout)
    assert list(saved.steps()) == list(whole.steps())[: len(list(saved.steps()))]
    assert saved.until_s == pytest.approx(whole.starts_s[piece], abs=0.2)
    assert again.exit_code == 0


def test_what_cannot_be_repaired_is_refused(pirate: Any, run: Path, recorded: bytes) -> None:
    Path("none.mcap").write_bytes(recorded[:500])
    Path("other.mcap").write_bytes(b"something else")

    assert "interrupted before anything" in pirate("repair", "none.mcap").stderr
    assert "not an MCAP file" in pirate("repair", "other.mcap").stderr
    assert sorted(path.name for path in Path().iterdir()) == ["none.mcap", "other.mcap", "run.mcap"]


def test_another_mission_is_told_of_by_its_own_file_and_in_words(
    pirate: Any, run: Path, tmp_path: Path
) -> None:
    text = (ROOT / "sequences" / "mitre_bend.yaml").read_text("utf-8")
    (tmp_path / "other.yaml").write_text(text.replace("      - DriveForward\n", "", 1), "utf-8")
    result = pirate("replay", run, "--mission", "other.yaml", "--pipe", ROOT / PIPE)

    assert result.exit_code == 1
    now = result.stdout.partition("  now, ")[2]
    assert "mitre_bend.yaml" not in now
    assert re.search(r"in the phase \w+ \(other\.yaml:\d+:\d+\)", result.stdout)
    assert not re.search(r"\w+\(\w*=|\d\.\d{7,}|Tick", result.stdout)


def test_every_field_of_an_effect_has_its_name_but_empty_texts_have_none() -> None:
    done = fx.StateChange(("Held", "Free"), ())

    assert field_words(done) == "state change: states (Held, Free), unconfirmed ()"
    assert field_words(fx.CommandStatus("Hold", "done")) == "command status: name Hold, status done"
    assert field_words(Answer("yes")) == "answer: choice yes"
    assert (field_words(None), field_words(Tick())) == ("the start", "the passing of time")
