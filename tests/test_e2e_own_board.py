"""A board of one's own with its program, served: what the start says, what it answers, what checks say."""

import json
from pathlib import Path

import pytest
import yaml
from e2e_support import Place

EXAMPLE = Path(__file__).parents[1] / "examples/own_board"


def bench() -> str:
    made = yaml.safe_load((EXAMPLE / "bench.yaml").read_text()) | {"bench": "t"}
    made["profile_path"] = [str(EXAMPLE / "boards")]
    made["devices"]["x1"]["firmware"] = str(EXAMPLE / "program/step_node.hex")
    return yaml.safe_dump(made)


def test_it_is_typed_at_by_its_own_names(place: Place) -> None:
    server = place.serve(bench())
    assert ", runs its program, which sets the speed\n" in server.output
    assert "silent until" not in server.output
    assert "ready" in place.cli("type", "x1", "")
    # The opening of the port resets the board: what is typed is not its bootloader's.
    assert "sense 512 feedback " in place.cli("type", "x1", "?", "--until", "feedback ", "--within", "5s")
    (row,) = [each for each in server.ask("list")["devices"] if each["device"] == "x1"]
    assert row["greeting"] == ""
    pins = json.loads(place.cli("sketch", "pins", "x1", "--json", "--runtime-dir", str(place.runtime)))
    assert pins["STEP"]["wired"] == ["d1.step"]
    place.cli("set", "x1", "sense_V", "0.825")
    assert "sense 256 " in place.cli("type", "x1", "?", "--until", "feedback ", "--within", "5s")


@pytest.mark.parametrize(("clock_Hz", "warns"), [(8_000_000, False), (16_000_000, True)])
def test_checks_warn_of_its_clock(place: Place, clock_Hz: int, *, warns: bool) -> None:
    board = place.folder / "boards/node"
    board.mkdir(parents=True)
    text = f"name: node\ntitle: N\nprocessor: {{chip: atmega328p, clock_Hz: {clock_Hz}, supply_V: 3.3}}\n"
    (board / "profile.yaml").write_text(text)
    said = place.cli("profile", "check", str(board))
    assert said.endswith(f"{board}: passes all checks\n")
    assert (f"{board}/profile.yaml:3:41: " in said) == warns
    config = place.folder / "bench.yaml"
    config.write_text("bench: t\nprofile_path: [boards]\ndevices:\n  x1: {profile: node}\n")
    assert (
        f"x1: {board}/profile.yaml:3:41: processor.clock_Hz: 16 MHz" in place.cli("check", str(config))
    ) == warns
