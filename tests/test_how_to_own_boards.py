"""Python of the pages on boards and sketches of a user's own does what the pages say."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from markdown_blocks import blocks

from hil.testing import Bench

BOARDS = "docs/how-to/add-a-profile.md"
SKETCH = "docs/how-to/own-mechaduino.md"
HEATER = """\
name: heater
title: A heater with a log
uarts: {main: {baud: 9600}, log: {baud: 9600}}
fields: {heater: {about: "the heater's relay, 1 is closed", type: switch}}
"""
PROFILE = """\
from hil.vocab.profile import Profile, UartSpec

from .firmware import Heater

PROFILE = Profile(firmware=Heater, uarts={"main": UartSpec(about="commands"), "log": UartSpec(about="log")})
"""


def python_below(page: str, heading: str) -> str:
    return next(each.text for each in blocks(page) if each.heading == heading and each.language == "python")


def test_the_handlers_of_the_page_switch_the_heater_and_log_it(tmp_path: Path) -> None:
    board = tmp_path / "boards" / "heater"
    board.mkdir(parents=True)
    (board / "__init__.py").touch()
    (board / "profile.yaml").write_text(HEATER)
    (board / "board.py").write_text(PROFILE)
    (board / "firmware.py").write_text(python_below(BOARDS, "Handlers instead of a main loop"))
    devices = {"h1": {"profile": "heater"}}
    with Bench({"bench": "t", "profile_path": [str(tmp_path / "boards")], "devices": devices}) as bench:
        port, log = bench.port("h1"), bench.port("h1.log")
        bench.run(ms=1500)
        port.write(b"1")
        bench.run(ms=1000)
        assert log.read() == b"1000 ms: heater 0\r\n2000 ms: heater 1\r\n"
        assert bench.axis("h1").snapshot().heater == 1


def test_fields_are_read_and_written_as_the_page_has_it() -> None:
    fields = {"temperature_degC": 61.0, "heater": 1}
    names = {"self": SimpleNamespace(board=SimpleNamespace(fields=fields))}
    exec(python_below(BOARDS, "Fields of your own"), names)
    assert fields["heater"] == 0


def test_the_button_of_the_page_turns_the_shaft(tmp_path: Path) -> None:
    sketch = tmp_path / "button.py"
    sketch.write_text(python_below(SKETCH, "Your own sketch on a Mechaduino"))
    device = {"profile": "mechaduino", "sketch": str(sketch), "flash": {"table": "identity"}}
    with Bench({"bench": "t", "devices": {"m1": device}}) as bench:
        bench.run(ms=4500)
        bench.device("m1").pin("D3", 1)
        bench.run(ms=1000)
        assert bench.axis("m1").snapshot().yw == pytest.approx(90, abs=0.2)
