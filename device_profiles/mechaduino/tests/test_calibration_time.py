"""Time that a calibration takes, by the steps that the firmware has to take back before."""

import pytest

from hil.testing import Bench

DONE = b"written to non-volatile Flash memory!"


def calibration_s(bench: Bench) -> float:
    """Let the board calibrate; answers how long that takes, which the verb has said before."""
    port, begin_ns, said = bench.port("m1"), bench.now_ns, b""
    told_ns = bench.device("m1").do("calibrate")["ends_after_ns"]
    while DONE not in said:
        bench.run(ms=100)
        said += port.read()
        assert bench.now_ns - begin_ns < 120e9, said[-200:]
    assert bench.now_ns - begin_ns == pytest.approx(told_ns, abs=0.11e9)
    return (bench.now_ns - begin_ns) / 1e9


def test_a_second_calibration_first_goes_back_and_a_reset_forgets_that() -> None:
    with Bench({"bench": "b", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        bench.run(ms=5000)
        first_s = calibration_s(bench)
        assert first_s == pytest.approx(26.5, abs=0.5)
        bench.run(ms=1000)
        assert calibration_s(bench) - first_s == pytest.approx(200 * 0.11, abs=0.5)
        bench.device("m1").reset()
        bench.run(ms=5000)
        assert calibration_s(bench) == pytest.approx(first_s, abs=0.5)
