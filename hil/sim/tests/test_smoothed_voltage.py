"""An RC low-pass between a PWM pin and an analogue pin: exact, however time is cut."""

import math

import pytest
from avr_words import CONVERT, PWM_64_OF_256, RESULT

from hil.core import CoreAxis
from hil.testing import Bench

RC_S, ON_V = 0.2, 5 * 64 / 256
CONFIG = {
    "bench": "t",
    "devices": {
        "u1": {"profile": "uno", "voltages": {"A0": {"of": "u2.d6_V", "rc_s": RC_S}}},
        "u2": {"profile": "uno"},
    },
}
NO_BOOT = 0xFF, 0xDF, 0xFD, 0xFF


def axis_of(bench: Bench, name: str) -> CoreAxis:
    return bench.runtime.devices[name].axis


def start(bench: Bench, name: str, flash: bytes) -> None:
    processor = axis_of(bench, name).processor
    assert processor
    processor.set_fuses(*NO_BOOT)
    processor.load(0, flash)
    processor.reset(1)


def counts(bench: Bench) -> int:
    processor = axis_of(bench, "u1").processor
    assert processor
    return int.from_bytes(processor.data(RESULT, 2), "little")


def run(bench: Bench, ms: float, cuts: int) -> None:
    for _ in range(cuts):
        bench.run(ms=ms / cuts)


@pytest.mark.parametrize("cuts", [1, 7, 100])
def test_it_rises_and_falls_by_its_time_constant(cuts: int) -> None:
    with Bench(CONFIG) as bench:
        bench.run(ms=50)
        start(bench, "u1", CONVERT)
        start(bench, "u2", PWM_64_OF_256)
        run(bench, 100, cuts)
        risen_V = ON_V * (1 - math.exp(-0.1 / RC_S))
        assert counts(bench) == pytest.approx(risen_V * 1024 / 5, abs=1)
        processor = axis_of(bench, "u2").processor
        assert processor
        processor.hold()  # its pins are inputs
        run(bench, 100, cuts)
        fallen_V = risen_V * math.exp(-0.1 / RC_S)
        assert counts(bench) == pytest.approx(fallen_V * 1024 / 5, abs=1)


def test_it_comes_to_the_mean() -> None:
    with Bench(CONFIG) as bench:
        bench.run(ms=50)
        start(bench, "u1", CONVERT)
        start(bench, "u2", PWM_64_OF_256)
        bench.run(ms=4000)
        assert counts(bench) == int(ON_V * 1024 / 5) - 1  # never quite


def test_a_firmwares_levels_go_through_it_as_well() -> None:
    config = CONFIG | {"devices": CONFIG["devices"] | {"u2": {"profile": "uno"}}}
    with Bench(config) as bench:
        bench.run(ms=50)
        start(bench, "u1", CONVERT)
        bench.port("u2").write(b"pin 6 1\n")
        bench.run(ms=200)
        assert counts(bench) == pytest.approx(1024 * (1 - math.exp(-0.2 / RC_S)), abs=6)  # typing takes a ms
