"""The example in each command's help, carried out at one bench in the order of the table: its exit code."""

import json
import os
import re
from collections.abc import Callable

import pytest
from e2e_support import Client, Place, free_port
from markdown_blocks import ROOT
from page_sessions import Session, captured, interrupted

from device_profiles.sac.packet import encode
from hil.cli.documents.command_tree import commands
from hil.cli.framework.command_group import app
from hil.testing.seeds.seed_results import FORMAT, digest
from hil.toolchain.avr_tools import find_avr_tools
from hil.toolchain.build_failed import NoToolchain

EXAMPLES = {
    command.name: re.findall(r"^Example: (hil .+)", command.about, re.M) for command in commands(app).all()
}
BENCH = """
bench: shop
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
  m2: {profile: mechaduino, flash: {table: identity}}
  s1: {profile: sac}
  u1: {profile: uno}
segments: {bus0: {stations: [s1], taps: {master: {port: pty}}}}
can: {can0: {bit_rate: 500000, nodes: {m1: 5}}}
labels: {rig: press}
commands: {keep_days: 30}
bridges: {zenoh: {listen: [tcp/127.0.0.1:PORT]}, modbus: {listen: "127.0.0.1:0"}}
"""
SQUARE = "run: square\naxes: {m1: {}}\nsteps: [{move: {m1: 90}}, {move: {m1: 0}}]\n"
ROW = " {} , 100 , 1 , 1 , 69 , 4321 , 1 , 10.47 , .5 , 3 , 1 , 2400000 \r\n"
PIECES = ["test_x.py::test_y[seed-0]", "test_x.py::test_y[seed-1]"]


def results(number: int) -> str:
    """File of results of one shard of two."""
    piece = PIECES[number - 1]
    rows: list[dict[str, object]] = [
        {"format": FORMAT, "shard": number, "of": 2},
        {"piece": piece, "test": "test_x.py::test_y", "seed": number - 1, "outcome": "passed"},
        {"end": 1, "pieces": 2, "run": digest(PIECES), "mine": 1},
    ]
    return "\n".join(map(json.dumps, rows))


FILES = {
    "bench.yaml": BENCH,
    "square.yaml": SQUARE,
    "moves.txt": "".join(ROW.format(position) for position in range(1, 31)),
    "long.txt": "".join(f" {n} , 9 , 0 , 1 , 300 , 1000 , 0 , 999 , 999 , 0 , 0 , 0 \r\n" for n in (1, 2, 3)),
    "mill.yaml": (ROOT / "examples/line/mill.yaml").read_text(),
    "drawing.ngc": (ROOT / "examples/line/drawing.ngc").read_text(),
    "home.py": "import serial, sys\nserial.Serial(sys.argv[1], 115200, timeout=1).write(b'p')\n",
    "hil-results-1-of-2.jsonl": results(1),
    "hil-results-2-of-2.jsonl": results(2),
    "sketches/blink/blink.ino": "void setup() { pinMode(13, 1); }\nvoid loop() { PINB = 32; delay(5); }\n",
    "commands.txt": "xm1200v160\r\n" + "\r\n" * 99,
}
LAST = ("sac command", "shutdown", "replay", "find", "export", "diff", "bundle")
"""Examples that come last: they take the board's address, and the log of a bench that has ended."""
ELSEWHERE = {
    "serve": "this bench",
    "with-lines": "hil/cli/tests/test_with_lines.py: this program has a window",
    "parity": "test_parity_live.py: there is no board",
    "sketch cycles": "test_running_sketch.py",
    "sketch profile": "test_running_sketch.py",
    "sketch plot": "test_running_sketch.py: it prints nothing here",
    "sketch gdb": "test_running_sketch.py: no GDB comes",
    "sac calibrate": "test_sac_companion.py: a minute by the computer's clock",
}
"""Examples that are not carried out here, and where they are."""
try:
    HAS_COMPILER = find_avr_tools(os.environ).core is not None
except NoToolchain:
    HAS_COMPILER = False
MAY_FAIL = ("hil doctor", "hil usb doctor")
"""Commands whose exit code says what they found here."""


def talk(session: Session) -> None:
    with Client(str(session.place.runtime / "shop" / "bus0.master")) as master:
        master.write(encode(85, 1, b"y"))
        master.read_until(b"\x06")


def greet(session: Session) -> None:
    with Client(str(session.place.runtime / "shop" / "s1")) as terminal:
        terminal.write(b"1 good morning\r")


def carried_out(session: Session, command: str) -> str:
    """Carry out a command that ends by itself, and says of its success by its exit code."""
    code, said = session.ended(command)
    assert code == 0 or (code == 1 and command.startswith(MAY_FAIL)), f"$ {command}\nexit code {code}: {said}"
    return said


def moved(session: Session, command: str) -> str:
    """Carry out a command that waits for a motion, which this begins."""
    carried_out(session, session.here(r"hil type m1 'xyr100\n' --until 100"))
    return carried_out(session, command)


def asked_at_its_door(session: Session, command: str) -> str:
    """Carry out a command that asks the bench at its own zenoh door, where others may be a router's."""
    return carried_out(session, command.replace(session.swaps["7447"], session.swaps["PORT"]))


GO_ON: dict[str, Callable[[Session, str], str]] = {
    "list": asked_at_its_door,
    "status": lambda session, command: interrupted(session, command, lambda said: said.count("ticks") > 1),
    "capture": lambda session, command: captured(session, command, lambda: talk(session), 2),
    # Where masters of a CAN bus count by the angle, it is refused.
    "zero": lambda session, command: carried_out(session, command.replace("m1", "m2")),
    "wait": moved,
    "lease break": lambda session, command: carried_out(session, f"hil lease take --why example; {command}"),
    "line watch": lambda session, command: captured(session, command, lambda: greet(session), 1),
    "web user": lambda session, command: carried_out(session, f"echo a long password | {command}"),
    "zenoh router": lambda session, command: interrupted(session, command, lambda said: "Ctrl-C" in said),
}
"""How commands are carried out that go on until Ctrl-C, which is no error of them, or want another board."""


def test_each_command_has_an_example() -> None:
    groups = {name.rpartition(" ")[0] for name in EXAMPLES} | {""}
    assert [name for name, lines in EXAMPLES.items() if not lines and name not in groups] == []


def test_examples_work(place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place.folder)
    with Session(place, "") as session:
        session.swaps |= {"PORT": str(free_port()), "7447": str(free_port())}
        for name, text in FILES.items():
            (place.folder / name).parent.mkdir(parents=True, exist_ok=True)
            session.write(name, text)
        server = session.serve(BENCH, "--log", "bench.log", speed=2)
        order = sorted(EXAMPLES, key=lambda each: LAST.index(each) if each in LAST else -1)
        for name, line in ((each, line) for each in order for line in EXAMPLES[each]):
            assert line.split()[1 : 1 + len(name.split())] == name.split()
            if name in ("axis", "pulses"):
                session.run("hil axis m1 enable")
            if name == "reset":
                since_ns = server.ask("status")["sim_ns"]
            if name == "replay":
                session.end_benches()
            is_without = name.startswith("sketch ") and not HAS_COMPILER
            if name not in ELSEWHERE and not is_without:
                GO_ON.get(name, carried_out)(session, session.here(line))
            if name == "reset":
                server.ready("m1", since_ns)
