"""Tests that fail: what their reports say, and what ``--hil-artifacts`` keeps."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hil.compose.decoding import Decoder, decoded
from hil.sim.inputs import Bytes
from hil.testing import Bench, replay
from hil.testing.failures.bench_account import account
from hil.testing.failures.bench_traffic import traffic_lines
from hil.testing.failures.failure_folder import LONGEST_NAME, folder_name
from hil.wire.pcapng import RAW, Interface, Record, RecordKind, read

TESTS = """
import pytest

CELL = {
    "bench": "cell",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"master": {}}}},
}

def turned(b):
    b.start()
    b.port("m1").write(b"xy")
    b.run(100)
    b.fault("shaft_jam", "m1", for_s=60)
    b.tap("bus0.master").write(bytes.fromhex("0255017900"))
    b.port("m1").write(b"r90\\r")
    b.run(500)
    return b.axis("m1").snapshot()

@pytest.mark.parametrize("name", ["a/b c"])
def test_jammed(bench, name):
    b = bench(CELL)
    b.more_sections.append(lambda: [("the program", "it waited for 'OK'")])
    assert turned(b).yw > 80

def test_two_benches(bench):
    a, b = bench(CELL), bench(CELL)
    turned(b)
    assert a.axis("m1").snapshot() == b.axis("m1").snapshot()

def test_on_the_bus(canbus):
    here = canbus(1)
    here.drives()[0].boot()
    assert here.heard == []

def test_unlogged(bench):
    from hil.sim.inputs import Bytes
    b = bench(CELL)
    b.more_sections.append(lambda: 1 / 0)
    b.start()
    b.runtime.apply_unlogged("m1", Bytes(b"p"))
    b.run(200)
    assert False

def test_live(live_bench):
    b = live_bench({"bench": "desk", "devices": {"s1": {"profile": "sac"}}})
    assert b"nothing" in b.type("s1", b"v\\r", until=b"SAC>")

def test_elsewhere(bench, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with bench(CELL) as b:
        b.start()
        assert False

def test_passes(bench):
    turned(bench(CELL))
"""


def run_pytest(folder: Path, *options: str) -> str:
    """Run the tests of a folder in a process of its own."""
    env = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    plugins = ("-p", "hil.testing.plugin", "-p", "no:cacheprovider")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, *options, "."]
    done = subprocess.run(command, env=env, capture_output=True, text=True, cwd=folder, check=False)
    assert done.returncode == 1, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """Output of pytest, and the folder of artifacts."""
    folder = tmp_path_factory.mktemp("failing")
    (folder / "test_cell.py").write_text(TESTS)
    said = run_pytest(folder, "--hil-artifacts", "kept")
    assert "6 failed, 1 passed" in said
    return said, folder / "kept"


def of_test(said: str, name: str) -> str:
    """Output of pytest about one test."""
    (text,) = re.findall(rf"^_+ {re.escape(name)} _+$(.*?)(?=^_+ test_|^=+ short)", said, re.M | re.S)
    return str(text)


@pytest.mark.thorough
@pytest.mark.long
def test_a_report_says_where_the_bench_stands(ran: tuple[str, Path]) -> None:
    text = of_test(ran[0], "test_jammed[a/b c]")
    assert "- bench cell at 4.600000 s -" in text
    assert "  1 shaft_jam on m1 (for_s 60), since 4.100000 s\n" in text
    assert re.search(
        r"  m1: at 6.\d\d deg, commanded 90.00 deg, shaft turned to 6.30 deg, mode x \(position\), loop on,"
        r" still; last fault: shaft_jam at 4.100000 s, in force\n",
        text,
    )
    assert (
        "  s1, s2: at 0.00 deg, commanded 0.00 deg, drive on, still; last fault: none\nnotes: none\n" in text
    )
    assert "    4.100000 m1 client -> board 'r90\\r'\n" in text
    assert re.search(r"^    4.100000 m1 board -> client 'Enter setpoint:\\r\\n'$", text, re.M)
    assert re.search(r"^    4.10\d+ bus0 .*02 55 01 79 00$", text, re.M)
    assert "- the program -" in text
    assert "it waited for 'OK'" in text
    assert "not all is known" not in text
    assert len(re.findall(r"^ .* m1 (?:board|client) -> ", text, re.M)) <= 20


@pytest.mark.long
def test_two_snapshots_differ_in_fields(ran: tuple[str, Path]) -> None:
    text = of_test(ran[0], "test_two_benches")
    assert re.search(r"^E +AssertionError: assert Snapshot\(at 0 s, .*\) == Snapshot\(at 4.6 s, ", text, re.M)
    assert re.search(r"^E +loop_on: 0 != 1$", text, re.M)
    assert text.count("- bench cell at ") == 2


@pytest.mark.long
def test_frames_are_in_words(ran: tuple[str, Path]) -> None:
    text = of_test(ran[0], "test_on_the_bus")
    assert re.search(r"^ +0.\d+ can0 .*701.*m1.canopen", text, re.M), text


@pytest.mark.long
def test_what_cannot_be_told_is_said(ran: tuple[str, Path]) -> None:
    text = of_test(ran[0], "test_unlogged")
    assert "not all is known of cell: ZeroDivisionError: division by zero" in text
    assert "assert False" in text
    assert "- bench cell at 4.200000 s -" in text
    assert "a replay differs, and with it what wires carried: m1, piece " in text
    page = (ran[1] / "test_cell.py-test_unlogged" / "failure.html").read_text()
    assert "inputs.jsonl does not replay as it ran" in page
    assert "m1, piece " in page


@pytest.mark.long
def test_each_failure_has_a_folder(ran: tuple[str, Path]) -> None:
    said, kept = ran
    folders = {path.name: path for path in kept.iterdir()}
    assert len(folders) == 6
    jammed = folders["test_cell.py-test_jammed[a-b-c]"]
    assert f"{jammed}/failure.html" in said
    names = {path.name for path in jammed.iterdir()}
    assert names == {"failure.html", "inputs.jsonl", "traffic.pcapng", "m1.svg", "s1.svg", "s2.svg"}
    two = {path.name for path in folders["test_cell.py-test_two_benches"].iterdir()}
    assert {"inputs.jsonl", "inputs-2.jsonl", "traffic-2.pcapng", "m1-2.svg"} <= two
    live = folders["test_cell.py-test_live"]
    assert {path.name for path in live.iterdir()} == {
        *("failure.html", "hil.log", "capture.pcapng", "run.hil.gz")
    }
    assert next(each.data for each in read((live / "capture.pcapng").read_bytes())) == b"v\r"
    recorded = replay(live / "run.hil.gz")
    assert recorded.difference() is None
    assert b"v\r" in [each.input.data for each in recorded.logged.inputs if isinstance(each.input, Bytes)]


@pytest.mark.long
def test_the_kept_log_replays(ran: tuple[str, Path]) -> None:
    for name in ("test_jammed[a-b-c]", "test_on_the_bus"):
        log = ran[1] / f"test_cell.py-{name}" / "inputs.jsonl"
        assert replay(log).difference() is None
        main = "import sys; sys.argv[0] = 'hil'; from hil.cli.entry import main; main()"
        command = [sys.executable, "-c", main, "replay", str(log)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert "identical" in done.stdout


@pytest.mark.long
def test_the_kept_traffic_is_a_capture(ran: tuple[str, Path]) -> None:
    path = ran[1] / "test_cell.py-test_jammed[a-b-c]" / "traffic.pcapng"
    items = [*decoded(read(path.read_bytes()), Decoder())]
    assert {item.source for item in items} == {"m1", "s1", "s2", "bus0"}
    assert 4_100_000_000 in [item.at_ns for item in items]
    if tshark := shutil.which("tshark"):
        done = subprocess.run([tshark, "-r", str(path)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert len(done.stdout.splitlines()) == len([*read(path.read_bytes())])


@pytest.mark.long
def test_the_page_has_all_of_it_and_needs_nothing_else(ran: tuple[str, Path]) -> None:
    page = (ran[1] / "test_cell.py-test_jammed[a-b-c]" / "failure.html").read_text()
    for part in (
        "test_jammed[a/b c]",
        "&gt; 80",
        "shaft_jam on m1",
        "&#x27;r90\\r&#x27;",
        'href="inputs.jsonl"',
    ):
        assert part in page
    assert page.count('src="data:image/svg+xml;base64,') == 3
    assert "<script" not in page
    assert {link for link in re.findall(r'(?:src|href)="([^"]*)"', page) if not link.startswith("data:")} == {
        *("inputs.jsonl", "traffic.pcapng", "m1.svg", "s1.svg", "s2.svg")
    }


@pytest.mark.parametrize(
    ("node_id", "name"),
    [
        ("tests/test_a.py::Class::test_b[x-1]", "tests-test_a.py-Class-test_b[x-1]"),
        ("../../etc::x", "etc-x"),
        ("a::\u00e4 b", "a-b"),
    ],
)
def test_a_folder_is_named_after_its_test(node_id: str, name: str) -> None:
    assert folder_name(node_id) == name


def test_a_long_name_is_cut_and_is_none_of_another() -> None:
    names = {folder_name("t" * 300 + end) for end in "ab"}
    assert len(names) == 2
    assert max(map(len, names)) == LONGEST_NAME + 9


def test_a_stopped_device_and_notes_are_told() -> None:
    with Bench({"bench": "b", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        device = bench.runtime.devices["m1"]
        device.power.fail("FirmwareHung: it was too slow")
        assert "notes:\n  m1 has stopped: FirmwareHung: it was too slow" in account(bench)


def test_a_fault_that_is_over_is_the_last_one() -> None:
    with Bench({"bench": "b", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        with bench.fault("shaft_jam", "m1"):
            bench.run(10)
        assert "last fault: shaft_jam at 0.000000 s, cleared at 0.010000 s" in account(bench)
        bench.fault("shaft_load", "m1", torque_Nm=0.01, start_s=1.0)
        text = account(bench)
        assert "1 shaft_load" not in text
        assert "2 shaft_load on m1 (torque_Nm 0.01, start_s 1.0), from 1.010000 s" in text
        assert Bytes(b"") not in bench.inputs.inputs


def test_of_many_ports_those_that_were_used_last_are_shown() -> None:
    ports = [Interface(f"s{number}", RAW) for number in range(20)]
    records = [
        Record(port, at_ms * 10**6, RecordKind.RX, b"x\r\n", "", 0) for at_ms, port in enumerate(ports)
    ]
    quiet, *shown = traffic_lines(reversed(records))
    assert set(quiet.removeprefix("not shown, their last is older: ").split(", ")) == {"s0", "s1", "s2", "s3"}
    assert [row.split()[1] for row in shown] == [port.name for port in ports[4:]]
