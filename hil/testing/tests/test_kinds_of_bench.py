"""One test file at ``--hil=virtual``, ``live`` and at real boards, in a pytest of its own."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from hil.testing import Bench, LiveError, ServedBench, UnsupportedHere, live, real_boards
from hil.testing.real_boards import BoardsAbsent, RealBoards

pytestmark = pytest.mark.long  # they start daemons

TESTS = """
import pytest
from hil.testing import UnsupportedHere

S1 = {"bench": "one", "speed": 5, "devices": {"s1": {"profile": "sac"}}}
PAIR = {"bench": "pair", "speed": 5, "devices": {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}},
        "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {"port": "pty"}}}}}
JAMMED = S1 | {"faults": [{"fault": "shaft_jam", "target": "s1"}]}

def test_a_sac_answers(bench):
    b = bench(S1, seed=3)
    assert b.start() == []
    port = b.port("s1")
    port.read()
    port.write(b"vd\\r")
    came = [b""]
    def prompt():
        came[0] += port.read()
        return came[0].endswith(b"SAC>")
    b.wait_until(prompt, within_ms=3000)
    assert came[0].startswith(b"vd\\r\\n")
    with b.serial("s1", timeout=3) as opened:
        opened.write(b"vd\\r")
        assert opened.read_until(b"SAC>").endswith(b"SAC>")

def test_bytes_are_lost(bench, fault):
    b = bench(S1)
    b.start()
    port = b.port("s1")
    port.read()
    lost = fault(b, "byte_drop", "s1", rate=1)
    port.write(b"vd\\r")
    b.run(ms=300)
    assert lost.is_active and port.read() == b""

def test_the_shaft_is_jammed(bench):
    b = bench(S1)
    with b.fault("shaft_jam", "s1"):
        b.run(ms=10)

def test_the_shaft_is_jammed_from_the_start(bench):
    assert bench(JAMMED).axis("s1").snapshot().at_ns >= 0

def test_its_angle(bench):
    assert bench(S1).axis("s1").snapshot().position_deg == 0

def test_two_boards(bench):
    bench(PAIR).tap("bus0.master").read()

def test_a_tap_that_only_the_test_has(bench):
    wire = {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}
    bench(S1 | {"segments": {"bus0": wire}}).tap("bus0.master")

def test_exact_times(bench):
    assert bench(S1).port("s1").timeline is not None

def test_a_line_in_memory(segment):
    b = segment(2)
    assert b.tap("bus0.master").read() == b""

def test_wrong_board(bench):
    bench({"bench": "one", "devices": {"s1": {"profile": "mechaduino"}}})

def test_it_goes_on(bench):
    try:
        bench(S1).inputs
    except UnsupportedHere:
        pass

def test_a_slip(bench):
    b = bench(S1)
    with pytest.raises(AttributeError):
        b.prot("s1")
    with pytest.raises(KeyError):
        b.port("s9")

def test_two_benches(bench):
    bench(S1), bench(S1)

def test_on_the_rig_alone(real_bench):
    assert real_bench().kind == "real"
"""


@pytest.fixture(scope="module")
def desk() -> Iterator[ServedBench]:
    """Bench whose SAC is the real board here."""
    config = {"bench": "desk", "speed": 5, "devices": {"s1": {"profile": "sac"}}}
    with live(config, capture=False) as made:
        yield made


def rig(folder: Path, at: str) -> Path:
    file = folder / "rig.yaml"
    file.write_text(json.dumps({"bench": "rig", "devices": {"s1": {"profile": "sac", "at": at}}}))
    return file


def run_tests(folder: Path, *options: str, tests: str = TESTS) -> subprocess.CompletedProcess[str]:
    (folder / "test_inner.py").write_text(tests)
    paths = os.pathsep.join(filter(None, sys.path))
    env = os.environ | {"PYTHONPATH": paths, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    plugins = ("-p", "hil.testing.plugin", "-p", "no:cacheprovider")
    command = [sys.executable, "-m", "pytest", "-q", "-rs", *plugins, *options, "test_inner.py"]
    return subprocess.run(command, env=env, capture_output=True, text=True, cwd=folder, check=False)


def test_in_memory_all_are_carried_out_but_the_rigs(tmp_path: Path) -> None:
    done = run_tests(tmp_path)
    assert "13 passed, 1 skipped" in done.stdout, done.stdout + done.stderr
    assert "hil: 1 test skipped at --hil=virtual:\n  1: kind=virtual: pytest --hil=FILE.yaml" in done.stdout


@pytest.mark.thorough
def test_live_what_needs_memory_is_skipped_and_counted(tmp_path: Path) -> None:
    done = run_tests(tmp_path, "--hil=live")
    assert "12 passed, 2 skipped" in done.stdout, done.stdout + done.stderr
    said = done.stdout
    assert "hil: 2 tests skipped at --hil=live:\n" in said
    assert "  1: kind=live: 'timeline' is of a bench in memory alone (--hil=virtual)\n" in said
    assert "hil: 1 test passed in spite of a refusal at --hil=live:\n  1: kind=live: 'inputs' is of" in said
    assert "SKIPPED [1] test_inner.py:" in said  # at the test's own line, not in the plugin


@pytest.mark.thorough
def test_at_a_real_board_what_it_cannot_do_is_skipped_with_the_reason(
    tmp_path: Path, desk: ServedBench
) -> None:
    rig(tmp_path, desk.port("s1"))
    done = run_tests(tmp_path, "--hil=rig.yaml")
    said = done.stdout
    assert "5 passed, 9 skipped" in said, said + done.stderr
    assert "hil: 9 tests skipped at --hil=rig.yaml:\n" in said
    for reason in (
        "  2: kind=real: s1 is real, and hil cannot give it shaft_jam (the shaft is clamped where it"
        " is); its line can have byte_flip, byte_drop, byte_duplicate, byte_delay\n",
        "  1: kind=real: s1 is a real board: the daemon sees its terminal, not its pins, shaft or encoder;",
        "  1: kind=real: rig.yaml has no device s2; it has s1\n",
        "  1: kind=real: rig.yaml has no device s4; it has s1\n",
        "  1: kind=real: rig.yaml has no bus0.master\n",
        "  1: kind=real: 'timeline' is of a bench in memory alone (--hil=virtual)\n",
        "  1: kind=real: real boards are in one bench at a time, and this test makes two\n",
        "  1: kind=real: s1 is a sac in rig.yaml, not a mechaduino\n",
    ):
        assert reason in said
    assert "hil: 1 test passed in spite of a refusal at --hil=rig.yaml:\n" in said


def test_a_board_that_is_absent_is_an_error_of_each_test_that_needs_it(tmp_path: Path) -> None:
    nowhere = str(tmp_path / "ttyACM7")
    rig(tmp_path, nowhere)
    done = run_tests(tmp_path, "--hil=rig.yaml", "-k", "answers or lost or two_boards")
    assert "2 failed, 1 skipped" in done.stdout, done.stdout + done.stderr
    why = f"BoardsAbsent: {tmp_path}/rig.yaml: s1 is not there: {nowhere}: No such file or directory;"
    assert done.stdout.count(why) == 2
    assert "skipped at --hil=rig.yaml" in done.stdout


def test_an_absent_board_is_not_looked_for_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    boards = RealBoards(rig(tmp_path, "/nowhere/ttyACM7"))
    monkeypatch.setattr(real_boards, "FOUND_S", 0.2)
    with pytest.raises(BoardsAbsent, match=r"s1 is not there: /nowhere/ttyACM7"):
        boards.serve().__enter__()
    monkeypatch.setattr(real_boards, "live", None)
    with pytest.raises(LiveError, match=r"s1 is not there: /nowhere/ttyACM7"):
        boards.serve().__enter__()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("lve", '--hil=lve: did you mean "live"? write virtual, live, or the file of a configuration whose'),
        (
            "rig.yml",
            "--hil=rig.yml: write virtual, live, or the file of a configuration whose devices",
        ),
        ("bad.yaml", 'bad.yaml:3:17: devices.s1.profile: there is no profile "sca" (did you mean "sac"?'),
        ("twins.yaml", "twins.yaml: no device has at:, the place of a real board"),
    ],
)
def test_a_kind_that_there_is_not_ends_the_run_before_it_begins(
    tmp_path: Path, given: str, said: str
) -> None:
    (tmp_path / "bad.yaml").write_text("bench: rig\ndevices:\n  s1: {profile: sca, at: /dev/ttyACM0}\n")
    (tmp_path / "twins.yaml").write_text("bench: rig\ndevices:\n  s1: {profile: sac}\n")
    done = run_tests(tmp_path, f"--hil={given}")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert said in done.stderr
    if not (tmp_path / given).exists():
        assert f"it was looked for at {tmp_path / given}" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_rig_with_a_twin_beside_the_board(tmp_path: Path, desk: ServedBench) -> None:
    devices = {"s1": {"profile": "sac", "at": desk.port("s1")}, "s2": {"profile": "sac"}}
    file = tmp_path / "rig.yaml"
    file.write_text(json.dumps({"bench": "rig", "devices": devices}))
    config = {"bench": "t", "devices": {"s1": {"profile": "sac"}, "s2": {"profile": "sac"}}}
    with RealBoards(file).serve(config) as b:
        assert b.kind == "real"
        assert b.start() == []
        assert b.axis("s2").snapshot().position_deg == 0
        with b.fault("shaft_jam", "s2") as fault:
            assert fault.is_active
        for call in (
            lambda: b.axis("s1").snapshot(),
            lambda: b.fault("byte_drop", "s1", rate=1, for_s=1),
            lambda: b.fault("wire_cut", "s1.network"),
            lambda: b.device("s1").pin("sync", 0),
            lambda: b.axis("s1").zero(),
            lambda: setattr(b.axis("s1"), "load_torque_Nm", 0.1),
            lambda: b.wait_until("s1", "position_deg > 1"),
            lambda: b.port("s1.network"),
        ):
            with pytest.raises(UnsupportedHere, match=r"^kind=real: "):
                call()
        b.device("s1").reset()
        b.run(ms=200)
        assert b"SAC>" in b.port("s1").read()
    with Bench(config) as virtual:
        assert virtual.kind == "virtual"


MAP = {
    "modbus_map": 1,
    "position_deg": {"input": 0, "type": "i32", "scale": 0.01},
    "status": {name: {"input": 4, "bit": bit} for bit, name in enumerate(("enabled", "moving", "fault"))},
    "set_point_deg": {"holding": 0, "type": "i32", "scale": 0.01},
    "control": {name: {"holding": 4, "bit": bit} for bit, name in enumerate(("enable", "start", "stop"))},
}


def test_a_real_drive_moves_and_tells_where_it_is(tmp_path: Path) -> None:
    door = {"modbus": {"listen": "127.0.0.1:0"}}
    far = {"bench": "far", "devices": {"d1": {"profile": "modbus_drive", "map": MAP}}, "bridges": door}
    with live(far, capture=False) as drive:
        at = f"modbus+tcp://{drive.info['bridges']['modbus'][0]}?unit=1"
        file = tmp_path / "rig.yaml"
        device = {"profile": "modbus_drive", "at": at, "map": MAP}
        file.write_text(json.dumps({"bench": "rig", "devices": {"d1": device}}))
        with RealBoards(file).serve(far) as b:
            axis = b.axis("d1")
            axis.do("enable")
            axis.do("move_abs", position_deg=90)
            b.wait_until("d1", "position_deg > 89", within_ms=20_000)
            assert axis.snapshot().position_deg > 89
            for call, said in (
                (lambda: b.fault("byte_drop", "d1", rate=1), "d1 is a real drive: hil sees no bytes on"),
                (lambda: b.fault("shaft_jam", "d1"), r"d1 is real, and hil cannot give it shaft_jam \(.*\)$"),
                (lambda: axis.zero(), "d1"),
                (lambda: b.port("d1"), "d1"),
                (lambda: b.modbus(), "rig.yaml has no modbus"),
            ):
                with pytest.raises(UnsupportedHere, match=f"^kind=real: {said}"):
                    call()
