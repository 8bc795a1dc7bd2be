"""Benches in processes of their own: fixture, context manager, and what they say when it goes wrong."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from hil.testing import LiveError, ServedBench, live

pytestmark = pytest.mark.long  # they start daemons

BENCH = {
    "bench": "t",
    "speed": 20,
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
}
INNER = """
import pytest
BENCH = {"bench": "t", "speed": 20, "devices": {"s1": {"profile": "sac"}}}

def test_it_fails(live_bench):
    bench = live_bench(BENCH)
    bench.type("s1", b"v\\r", until=b"SAC>")
    bench.ask("inject", fault="no_such", target="s1", parameters={})

def test_of_two_both_are_reported(live_bench):
    one, two = live_bench(BENCH), live_bench(BENCH)
    assert one.port("s1") != two.port("s1")
    one.port("s2")

def test_a_mistake(live_bench):
    live_bench("bench: t\\ndevices:\\n  m1: {profile: mechadino}\\n")

def test_a_mistake_in_the_kit(bench):
    bench({"bench": "t", "devices": {"m1": {"profile": "mechadino"}}})
"""


@pytest.fixture(scope="module")
def bench() -> Iterator[ServedBench]:
    with live(BENCH) as made:
        yield made


def test_its_boards_answer_at_once(bench: ServedBench) -> None:
    with serial.Serial(bench.port("m1"), 115200, timeout=5) as port:
        port.write(b"p")
        assert b"raw encoder: 286" in port.read_until(b"\n")
    assert bench.type("s1", b"\r", b"\r", until=b"SAC>").count(b"SAC>") == 2
    assert set(bench.ports) == {"m1", "s1"}
    assert bench.info["bauds"] == {"m1": None, "s1": 38400}


def test_commands_and_verbs_reach_it(bench: ServedBench) -> None:
    assert "bench t" in bench.hil("status")
    assert bench.ask("do", device="m1", name="enable", parameters={})["effective_at_ns"] > 4e9
    with pytest.raises(LiveError, match="exit code 2\nhil: no device 'm2'"):
        bench.hil("monitor", "m2")
    with pytest.raises(LiveError, match="'m2'"):
        bench.ask("reset", device="m2")
    with pytest.raises(KeyError) as wrong:
        bench.port("s11")
    with pytest.raises(KeyError, match='did you mean "s1"'):
        bench.type("s11", b"\r", until=b">")
    with pytest.raises(TypeError, match="a port carries bytes: b'v', not 'v'"):
        bench.type("s1", "v", until=b">")  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="a port carries bytes: b'>', not '>'"):
        bench.type("s1", b"v", until=">")  # type: ignore[arg-type]
    assert str(wrong.value) == "there is no port 's11'; did you mean \"s1\"? there are m1, s1"
    with pytest.raises(LiveError, match=r"s1 did not answer b'nothing' to b'\\r' in 0.2 s: b'"):
        bench.type("s1", b"\r", until=b"nothing", timeout_s=0.2)


def test_its_report_has_what_passed(bench: ServedBench) -> None:
    bench.type("s1", b"vd\r", until=b"SAC>")
    (_, log), (title, ports) = bench.report()
    assert title.startswith("traffic of t (")
    assert "s1 client -> board 'vd\\r'" in ports
    assert log == "nothing"


def test_it_leaves_nothing_behind(tmp_path: Path) -> None:
    before = dict(os.environ)
    with live(BENCH, keep=tmp_path / "kept") as made:
        folder, pid = made.folder, made.pid
        assert Path(made.port("m1")).is_relative_to(folder)
        assert len(made.info["control"]) < 100
    assert not folder.exists()
    assert not Path(f"/proc/{pid}").exists()
    assert {path.name for path in (tmp_path / "kept").iterdir()} == {
        *("hil.log", "capture.pcapng", "run.hil.gz")
    }
    assert dict(os.environ) == before


def test_a_body_that_raises_is_told_what_the_daemon_said() -> None:
    with pytest.raises(ZeroDivisionError) as raised, live(BENCH, capture=False):
        raise ZeroDivisionError
    assert "what hil serve said" in raised.value.__notes__[0]


def test_a_long_folder_for_temporary_files_is_no_reason(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    folder = tmp_path / ("long" * 30)
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    with live(BENCH, capture=False) as made:
        assert len(made.info["control"]) < 60


def test_a_configuration_error_is_what_is_said(tmp_path: Path) -> None:
    with pytest.raises(LiveError, match=r'^<dict>: devices\.m1\.profile: there is no profile "mechadino"'):
        live({"bench": "t", "devices": {"m1": {"profile": "mechadino"}}}).__enter__()
    with pytest.raises(LiveError, match=r"^<text>:3:17: devices\.m1\.profile: there is no profile"):
        live("bench: t\ndevices:\n  m1: {profile: mechadino}\n").__enter__()
    with pytest.raises(LiveError, match=r"nowhere\.yaml: No such file"):
        live(tmp_path / "nowhere.yaml").__enter__()


def test_boards_that_are_late_are_no_endless_wait() -> None:
    begun_s = time.monotonic()
    with pytest.raises(LiveError, match=r"^the boards do not answer after 2 s"):
        live(BENCH | {"speed": 0.01}, timeout_s=2).__enter__()
    assert time.monotonic() - begun_s < 15


@pytest.mark.thorough
def test_reports_of_tests_that_fail(tmp_path: Path) -> None:
    (tmp_path / "test_inner.py").write_text(INNER)
    env = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }
    plugins = ("-p", "hil.testing.plugin", "-p", "no:cacheprovider")
    command = [sys.executable, "-m", "pytest", "-q", *plugins, str(tmp_path)]
    done = subprocess.run(command, env=env, capture_output=True, text=True, cwd=tmp_path, check=False)
    said = done.stdout
    assert "4 failed" in said, said + done.stderr
    assert said.count("hil serve t (") == 3
    assert said.count("t now, by hil status") == 3
    assert said.count("simulated ") == 3
    assert "s1 client -> board 'v\\r'" in said
    assert "no_such" in said
    assert "E       hil.testing.given.NoSuchName: there is no port 's2'" in said
    assert "<text>:3:17: devices.m1.profile: there is no profile" in said
    assert "ConfigError: <dict>: devices.m1.profile: there is no profile" in said
    assert "site-packages" not in said
    assert "contextlib" not in said
    assert "check.py" not in said
