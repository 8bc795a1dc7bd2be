"""Exit codes: each of the table that the reference has, by real cases of every group of commands."""

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from e2e_support import HIL, PATIENCE_S, Place, Server, until

from hil.cli.framework.command_group import panel_of
from hil.cli.framework.command_table import PANELS
from hil.cli.framework.exit_codes import EXIT_CODES, Exit

BENCH = """
bench: t
speed: 5
devices:
  m1: {profile: mechaduino, flash: {table: identity}}
  s1: {profile: sac}
  u1: {profile: modbus_drive}
segments: {bus0: {stations: [s1], taps: {master: {port: pty}}}}
"""
FILES = {
    "wrong.yaml": "bench: t\ndevices: {m1: {profile: mechadunio}}\n",
    "right.yaml": "bench: u\ndevices: {m1: {profile: mechaduino}}\n",
    "far.yaml": "run: far\naxes: {m1: {}}\nsteps: [{move: {m1: 720000}}]\n",
    "near.yaml": "run: near\naxes: {m1: {max_deg: 1}}\nsteps: [{move: {m1: 9}}]\n",
    "empty.pcapng": "",
}
CASES: dict[str, tuple[int, str]] = {
    "list": (Exit.DONE, "bench t "),
    "list -b t": (Exit.DONE, "bench t "),
    "list -b nowhere": (Exit.FAILED, "bench 'nowhere' is not running here; running: t"),
    "check right.yaml": (Exit.DONE, "no problems"),
    "status --bench nowhere": (Exit.FAILED, "running: t"),
    "check wrong.yaml": (Exit.MISTAKE, 'did you mean "mechaduino"'),
    "check latin.yaml": (
        Exit.MISTAKE,
        "latin.yaml:2:3: the byte 0xff is not UTF-8 text (save the file as UTF-8)",
    ),
    "serve wrong.yaml": (Exit.MISTAKE, 'did you mean "mechaduino"'),
    "replay nothing.jsonl": (Exit.MISTAKE, "No such file"),
    "recordings": (Exit.DONE, "recording"),
    "recordings --bench nowhere": (Exit.FAILED, "no recordings of nowhere in "),
    "status m1": (Exit.DONE, "position_deg"),
    "profile list": (Exit.DONE, "mechaduino"),
    "reset s1": (Exit.DONE, "s1: off and on again"),
    "pin m1 D2 1": (Exit.DONE, "m1: D2 is 1"),
    "set m1 pKi 0.2": (Exit.DONE, "m1: pKi is 0.2"),
    "type m1 p --until encoder --within 20s": (Exit.DONE, "raw encoder"),
    "type m1 p --until nothing --within 1s": (Exit.FAILED, "'nothing' did not come within 1 s"),
    "type m9 p": (Exit.MISTAKE, "no device 'm9'"),
    "wait m1 loop_on==0": (Exit.DONE, "m1: loop_on==0 after 0.000 s: loop_on is 0"),
    "wait m1 loop_on>1 --within 1s": (Exit.FAILED, "m1: loop_on>1 did not hold within 1 s"),
    "wait m1 loop_no>1": (Exit.MISTAKE, 'did you mean "loop_on"?'),
    "monitor u1": (Exit.FAILED, "has no serial port"),
    "monitor m9": (Exit.MISTAKE, "no device 'm9'"),
    "pin m1 D9 0": (Exit.MISTAKE, "no input 'D9'; there are D0"),
    "pin m1 D2 2": (Exit.MISTAKE, "level: 2 is too large; write 0 or 1"),
    "pin m1 D2 low": (Exit.MISTAKE, 'level: "low" is no number; write 0 or 1'),
    "reset m9": (Exit.MISTAKE, "no device 'm9'"),
    "set m1 pKp 1e9": (Exit.MISTAKE, "pKp: 1000000000 is too large; write 0 to 1000000"),
    "set m1 pKq 1": (Exit.MISTAKE, "no field 'pKq'"),
    "set m1 pKp nan": (Exit.MISTAKE, "write a number"),
    "sketch build nowhere": (Exit.MISTAKE, "nowhere: there is no such folder"),
    "sketch load m1 nothing.hex": (Exit.MISTAKE, "nothing.hex: No such file"),
    "sketch pins m1": (Exit.FAILED, "m1 has no processor that runs a program of yours"),
    "sketch pins m9": (Exit.MISTAKE, "no device 'm9'"),
    "sketch gdb m1": (Exit.FAILED, "m1 has no processor"),
    "sketch cycles m1 --for soon": (Exit.FAILED, "m1 has no processor"),
    "profile check nowhere": (Exit.MISTAKE, "no folder nowhere"),
    "seeds merge nothing.jsonl": (Exit.MISTAKE, "No such file"),
    "seeds merge wrong.yaml": (Exit.MISTAKE, "give one of `pytest --hil-results FILE`"),
    "sac load nothing.txt": (Exit.MISTAKE, "No such file"),
    "axis m1": (Exit.DONE, "move-abs"),
    "axis m1 move-rel 5": (Exit.FAILED, "the control loop is off"),
    "axis s1 move-abs 9e99": (Exit.MISTAKE, "write "),
    "axis m1 stop softly": (Exit.MISTAKE, "write grace or prejudice"),
    "axis m1 move-abs": (Exit.MISTAKE, "position_deg: this one is missing"),
    "axis m9 stop": (Exit.MISTAKE, "no device 'm9'"),
    "plot m1 --signals yv": (Exit.MISTAKE, "no signal 'yv'"),
    "run show nothing": (Exit.MISTAKE, "no run 'nothing'"),
    "axis m1 jump": (Exit.MISTAKE, "has no 'jump'"),
    "run near.yaml": (Exit.MISTAKE, "near.yaml:"),
    "run right.yaml": (Exit.MISTAKE, "a bench's configuration, not a run (`hil serve right.yaml` starts"),
    "run latin.yaml": (Exit.MISTAKE, "latin.yaml:2:3: the byte 0xff"),
    "drive m1 --file latin.yaml": (Exit.MISTAKE, "latin.yaml:2:3: the byte 0xff"),
    "step s1 90": (Exit.FAILED, "no set-point that could step"),
    "modbus cycle 1:3:10": (Exit.DONE, "cycle "),
    "capture bus0 --bench nowhere": (Exit.FAILED, "running: t"),
    "decode empty.pcapng": (Exit.MISTAKE, "empty.pcapng"),
    "play empty.pcapng bus0.master": (Exit.MISTAKE, "empty.pcapng"),
    "line send bus0.master 85 v150": (Exit.DONE, "85 v150: done"),
    "line scan bus0.master --addresses 9-12": (Exit.FAILED, "0 of 4 addresses answer"),
    "line send bus0.master 2 v150": (Exit.MISTAKE, "write 4 to 255"),
    "line scan bus0.mastr": (Exit.MISTAKE, 'did you mean "bus0.master"?'),
    "can eds m1": (Exit.MISTAKE, "no CANopen node"),
    "can send can9 605#00": (Exit.MISTAKE, "no CAN bus 'can9'"),
    "modbus map m9": (Exit.MISTAKE, "no device 'm9'"),
    "capture nothing -w out.pcapng": (Exit.MISTAKE, "no port 'nothing'"),
    "capture": (Exit.MISTAKE, "SOURCE is missing"),
    "modbus cycle 1-": (Exit.MISTAKE, "write UNIT:FUNCTION"),
    "fault kinds": (Exit.DONE, "byte_flip"),
    "fault list --bench nowhere": (Exit.FAILED, "running: t"),
    "fault clear": (Exit.DONE, "no fault is active"),
    "fault inject byte_drop m9": (Exit.MISTAKE, "no 'm9'; "),
    "fault clear 9": (Exit.MISTAKE, "no fault 9"),
    "fault inject byte_drop m1 rat=0.01": (Exit.MISTAKE, 'did you mean "rate"?'),
    "fault inject byte_drop m1 rate": (Exit.MISTAKE, "write its name before it, as in rate=0.01"),
    "docs tour": (Exit.DONE, "# Tour"),
    "arduino install --sketchbook /proc/none": (Exit.FAILED, "/proc/none"),
    "docs no-such-page": (Exit.MISTAKE, "no page 'no-such-page'"),
    "completion tcsh": (Exit.MISTAKE, "bash, zsh, fish"),
    "zenoh keys": (Exit.MISTAKE, "DIR is missing"),
}
"""Command lines with their exit code and a part of what they say."""
HANGER = """
class Hanger:
    def __init__(self, board):
        self.board = board

    def interrupt(self, event):
        pass

    def main(self):
        yield ByteAvailable()
        sum(range(10**12))  # C code that looks at no signals
"""


@pytest.fixture(scope="module")
def bench() -> Iterator[tuple[Place, Server]]:
    with Place() as place:
        for name, text in FILES.items():
            place.write(text, name)
        (place.folder / "latin.yaml").write_bytes(b"bench: t\n# \xff\n")
        yield place, place.serve(BENCH).ready()


def where(place: Place) -> tuple[str, str]:
    return "--runtime-dir", str(place.runtime)


@pytest.mark.parametrize("line", CASES)
def test_a_command_exits_with(
    bench: tuple[Place, Server], line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    place, (code, said) = bench[0], CASES[line]
    monkeypatch.chdir(place.folder)
    assert said in place.cli(*where(place), *line.split(), code=code)


def test_each_group_has_each_code() -> None:
    found = {(panel_of(line.split()[0]), code) for line, (code, _) in CASES.items()}
    assert found == {(panel, code) for panel in PANELS for code in (Exit.DONE, Exit.FAILED, Exit.MISTAKE)}
    below = {Exit.RUN_FAILED, Exit.RUN_CANCELLED, Exit.NOT_KNOWN, Exit.INTERRUPTED, Exit.FIRMWARE_HUNG}
    assert {code for _, code in found} | below == set(EXIT_CODES)


@pytest.mark.thorough
def test_serve_exits_with_a_firmware_that_cannot_be_interrupted(tmp_path: Path) -> None:
    with Place() as place:
        place.hil("profile", "new", "hanger", "--folder", str(place.folder))
        program = place.folder / "hanger" / "firmware.py"
        program.write_text(program.read_text().partition("class ")[0] + HANGER)
        board = place.folder / "hanger" / "board.py"
        board.write_text(
            "from hil.vocab.profile import Profile\n\nfrom .firmware import Hanger\n\n"
            "PROFILE = Profile(firmware=Hanger)\n"
        )
        server = place.serve("bench: t\nprofile_path: [.]\ndevices: {h1: {profile: hanger}}\n").started()
        with server.client("h1") as client:
            client.write(b"x")
            said = server.refused(code=Exit.FIRMWARE_HUNG)
    assert "h1: its firmware is in code that cannot be interrupted" in said


def is_moving(run: dict[str, Any]) -> bool:
    return run["state"] == "running" and run["left_s"] is not None


@pytest.mark.parametrize(
    ("code", "ended_by"),
    [
        (Exit.RUN_FAILED, "axis m1 disable"),
        (Exit.RUN_CANCELLED, "run cancel"),
        (Exit.INTERRUPTED, signal.SIGINT),
        (Exit.INTERRUPTED, signal.SIGTERM),
    ],
)
def test_a_run_exits_with(bench: tuple[Place, Server], code: int, ended_by: str | signal.Signals) -> None:
    place, server = bench
    place.cli(*where(place), "axis", "m1", "enable")
    command = [HIL, *where(place), "run", "far.yaml"]
    with subprocess.Popen(command, cwd=place.folder, stdout=subprocess.PIPE, text=True) as running:
        (name,) = until(
            lambda: [each["run"] for each in server.ask("runs", name="") if is_moving(each)], "it"
        )
        if isinstance(ended_by, signal.Signals):
            running.send_signal(ended_by)
        else:
            words = ended_by.split() + [name] * (code == Exit.RUN_CANCELLED)
            place.cli(*where(place), *words)
        said, _ = running.communicate(timeout=PATIENCE_S)
    assert running.returncode == code, said


def test_ctrl_c_while_a_command_exits_is_silent() -> None:
    script = (
        "import atexit, os, signal, sys; atexit.register(os.kill, os.getpid(), signal.SIGINT)\n"
        "sys.argv = ['hil', '--version']; from hil.cli.entry import main; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, timeout=PATIENCE_S, check=False
    )
    assert (done.returncode, done.stderr) == (-signal.SIGINT, b"")


@pytest.mark.parametrize(
    ("line", "code"),
    [("docs reference | head -n 1", Exit.DONE), ("list > /dev/full", Exit.FAILED)],
)
def test_an_output_that_takes_no_more(bench: tuple[Place, Server], line: str, code: int) -> None:
    """A reader that has read enough is no error, a full disk is."""
    script = f"{HIL} {' '.join(where(bench[0]))} {line}; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", script], capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert code == Exit.DONE or re.fullmatch("hil: .*No space left on device\n", done.stderr)
