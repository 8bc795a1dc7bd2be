"""Ports by URLs: ``hil://m1``."""

from pathlib import Path

import pytest
import serial

from hil.testing import Bench, live
from hil.testing.serial_ports import open_benches, protocol_hil

MECHADUINO = {"bench": "first", "devices": {"m1": {"profile": "mechaduino"}}}
SAC = {"bench": "second", "devices": {"s1": {"profile": "sac"}, "m1": {"profile": "mechaduino"}}}


@pytest.fixture(autouse=True)
def no_other_bench(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(open_benches, "_OPEN", [])  # a test before may have left one open
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    tmp_path.chmod(0o700)


def test_a_url_is_a_port_of_the_newest_open_bench_that_has_it() -> None:
    with Bench(MECHADUINO) as first:
        with Bench(SAC) as second:
            first.start()
            second.start()
            port = serial.serial_for_url("hil://m1", timeout=1)
            port.write(b"p")
            assert port.readline().startswith(b"stepNumber")
            assert second.now_ns > first.now_ns
            assert serial.serial_for_url("hil://s1").baudrate == 38400
            assert serial.serial_for_url("hil://s1", 9600).baudrate == 9600
            before_ns = first.now_ns
            serial.serial_for_url("hil://first/m1", timeout=0.5).read(1000)
            assert first.now_ns == before_ns + 500_000_000
            second.close()
        port = serial.serial_for_url("hil://m1", do_not_open=True)
        assert not port.is_open
        port.timeout = 1
        port.open()
        port.write(b"p")
        assert port.readline().startswith(b"stepNumber")


def test_an_unknown_url_says_how_to_get_one() -> None:
    with pytest.raises(serial.SerialException) as none:
        serial.serial_for_url("hil://m1")
    assert str(none.value) == (
        "there is no port hil://m1: no bench has one now; make a bench in the test (hil.testing.Bench, or the"
        " fixture bench), run the program in one (hil virtual BENCH.yaml PROGRAM), or start one (hil serve"
        " BENCH.yaml)"
    )
    with Bench(MECHADUINO):
        with pytest.raises(
            serial.SerialException, match="there is no port hil://m2: there are m1; make a bench"
        ):
            serial.serial_for_url("hil://m2")
        with pytest.raises(serial.SerialException, match="no port hil://other/m1: no bench has one now"):
            serial.serial_for_url("hil://other/m1")


@pytest.mark.parametrize("url", ["hil://", "hil:///m1", "hil://a/b/c"])
def test_a_url_that_names_no_port_is_refused(url: str) -> None:
    with pytest.raises(ValueError, match=f"{url} names no port: write hil://PORT, or hil://BENCH/PORT"):
        serial.serial_for_url(url)


@pytest.mark.long
def test_outside_of_the_kit_it_is_a_port_of_a_bench_that_is_served(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(protocol_hil, "LIVE", [])  # as in another process
    with live(MECHADUINO) as served:
        monkeypatch.setenv("RUNTIME_DIRECTORY", str(served.folder / "run"))
        with serial.serial_for_url("hil://first/m1", timeout=5) as port:
            port.write(b"p")
            assert b"Angle" in port.readline()


@pytest.mark.long
def test_in_a_test_it_is_a_port_of_its_live_bench() -> None:
    with live(MECHADUINO), live(SAC):
        for url in ("hil://first/m1", "hil://second/m1", "hil://m1"):
            with serial.serial_for_url(url, timeout=5) as port:
                port.write(b"p")
                assert b"Angle" in port.readline()
        with pytest.raises(serial.SerialException, match="there is no port hil://m2"):
            serial.serial_for_url("hil://m2")
