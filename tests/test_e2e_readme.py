"""The first block of ``README.md``: a program on simulated time, a fault, a recording that is looked into."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from e2e_support import HIL, PATIENCE_S, TERMINAL, Place
from markdown_blocks import ROOT, block, fits

HOMING = ROOT / "examples" / "homing"
NUMBERS = r"-?\d+(?:\.\d+)?"
COMMAND = re.compile(r"^\$ (.*?)(?:  +#.*)?\n((?:(?!\$ ).*\n)*)", re.M)
"""A command without its remark, and what it prints."""


def program(words: str, place: Place) -> "subprocess.Popen[str]":
    """Start the program as the page does, with this place's folder instead of the reader's."""
    typed = words.replace("/run/user/1000/hil", str(place.runtime))
    return subprocess.Popen(
        [sys.executable, *shlex.split(typed)[1:]],
        cwd=HOMING,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def carried_out(words: str, place: Place) -> str:
    """Run the commands of hil in a line, each after the other, and return what they print."""
    where = os.environ | TERMINAL | {"XDG_STATE_HOME": str(place.folder)}
    said = ""
    for command in words.split(" && "):
        name, *rest = shlex.split(command)
        assert name == "hil"
        looks = ["--runtime-dir", str(place.runtime)] if rest[0] in ("wait", "fault") else []
        done = subprocess.run(
            [HIL, *rest, *looks], cwd=HOMING, env=where, capture_output=True, text=True, timeout=PATIENCE_S
        )
        assert done.returncode == 0, done
        said += done.stdout
    return said


def test_the_first_block(place: Place) -> None:
    (enter, virtual, serve, started, jammed, looked) = COMMAND.findall(block("README.md", "hil"))
    assert enter[0] == "cd examples/homing"
    assert serve == ("hil serve bench.yaml", "")
    assert fits(virtual[1], carried_out(virtual[0], place))

    place.state = Path(place.folder, "hil")
    text = (HOMING / "bench.yaml").read_text()
    place.serve(text, bench="slide").ready("s1", boot_ns=1_150_000_000)
    home = program(started[0], place)
    said = carried_out(jammed[0], place)
    assert fits(jammed[1], said, NUMBERS), said
    printed, _ = home.communicate(timeout=PATIENCE_S)
    assert fits(started[1], printed), printed
    said = carried_out(looked[0], place)
    assert fits(looked[1], said, NUMBERS, r" +"), said
    stands, ought = (
        float(re.findall(rf"{name} +(\S+)", said)[0]) for name in ("position_deg", "commanded_deg")
    )
    assert stands < ought - 1000  # that is what the page says of it
