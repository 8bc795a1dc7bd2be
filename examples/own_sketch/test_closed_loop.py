"""``closed_loop.ino``: an angle over SPI, and a motor that comes to its place."""

import pytest


def told_deg(port):
    port.write(b"p\n")
    _, deg, _, misread = port.readline().split()
    assert misread == b"0"
    return float(deg)


@pytest.fixture
def loop(bench, built):
    b = bench(built("closed_loop") / "bench.yaml")
    port = b.serial("u1", timeout=2)
    assert port.readline() == b"at 0.00 misread 0\r\n"
    return b, port


def test_the_encoder_tells_where_the_shaft_is(loop):
    b, port = loop
    begun_deg = b.axis("d1").snapshot().position_deg
    port.write(b"g 90\n")
    b.run(ms=1000)
    turned_deg = b.axis("d1").snapshot().position_deg - begun_deg
    assert turned_deg == pytest.approx(90, abs=0.9)
    assert told_deg(port) == pytest.approx(turned_deg, abs=0.4)


def test_a_motor_that_was_held_fast_comes_to_its_place(loop):
    b, port = loop
    begun_deg = b.axis("d1").snapshot().position_deg
    with b.fault("shaft_jam", "d1"):
        port.write(b"g -120\n")
        b.run(ms=500)
        assert abs(b.axis("d1").snapshot().position_deg - begun_deg) < 5
    b.run(ms=1500)
    assert b.axis("d1").snapshot().position_deg - begun_deg == pytest.approx(-120, abs=0.9)
    assert b.axis("d1").snapshot().steps_taken < -120 / 0.225 - 100  # many were lost


def test_a_magnet_that_slips_moves_the_place(loop):
    b, port = loop
    begun_deg = b.axis("d1").snapshot().position_deg
    with b.fault("encoder_slip", "e1", counts=455):  # 10 deg
        b.run(ms=500)
        assert b.axis("d1").snapshot().position_deg - begun_deg == pytest.approx(-10, abs=0.9)
        assert told_deg(port) == pytest.approx(0, abs=0.9)


def test_a_wire_of_the_encoder_that_is_off_is_told(loop):
    b, port = loop
    with b.fault("encoder_disconnect", "e1"):
        b.run(ms=100)
    port.write(b"p\n")
    _, _, _, misread = port.readline().split()
    assert int(misread) == pytest.approx(50, abs=2)
