"""Slips of those who write tests: each is told with what to write instead."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from hil.config import ConfigError
from hil.testing import Bench
from hil.testing.known_names import Uncalled
from hil.vocab.verbs import VerbRefused

EMPTY: dict[str, Any] = {"profile": "mechaduino", "flash": {"table": "empty"}}
IDENTITY = {"profile": "mechaduino", "flash": {"table": "identity"}}
TWO = {"bench": "t", "devices": {"m1": IDENTITY, "m2": EMPTY}}
RUN = {"run": "r", "axes": {"m2": {}}, "steps": [{"move": {"m2": 1.0}}]}


def mistyped(bench: Bench) -> None:
    bench.axis("m1").load_torque = 0.1  # type: ignore[attr-defined]


SLIPS: dict[str, tuple[Callable[[Any], object], type[Exception], str]] = {
    "starts": (
        lambda b: b.axis("m1").do("move_abs", position_deg=9),
        VerbRefused,
        "m1: it starts, .*; b.start() lets it start",
    ),
    "unnamed": (
        lambda b: b.axis("m1").do("move-abs", 90),
        TypeError,
        "parameters have names; write do('move_abs', position_deg=90)",
    ),
    "mistyped": (mistyped, AttributeError, "no 'load_torque'; did you mean \"load_torque_Nm\""),
    "field": (
        lambda b: b.axis("m1").velocity_rpm,
        AttributeError,
        'read b.axis("m1").snapshot().velocity_rpm',
    ),
    "pyserial": (lambda b: b.port("m1").readline(), AttributeError, 'b.serial("m1", timeout=1) is pyserial'),
    "nothing": (lambda b: b.port(None), TypeError, "None is no name of a port; write it as text"),
    "no function": (
        lambda b: b.wait_until(True),
        TypeError,
        "True is neither a function nor an axis",
    ),
    "one text": (
        lambda b: b.program("home.py m1"),
        TypeError,
        "give a list of words, as ['home.py', 'm1']",
    ),
    "a file": (lambda b: b.perform("run.yaml"), TypeError, "write Path('run.yaml').read_text()"),
    "not called": (
        lambda b: Uncalled("bench", Bench).run(5),
        AttributeError,
        'b = bench("bench.yaml"), then write b.run',
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_says_what_to_write(slip: str) -> None:
    act, kind, said = SLIPS[slip]
    with Bench(TWO) as bench, pytest.raises(kind, match=re.escape(said).replace(r"\.\*", ".*")):
        act(bench)


def test_a_run_sees_an_empty_table_and_what_fills_it() -> None:
    with Bench(TWO) as bench:
        bench.run(ms=4500)
        off = r"axes\.m2: its look-up table is empty \(`hil axis m2 calibrate`, then `hil axis m2 enable`\)"
        with pytest.raises(ConfigError, match=off):
            bench.perform(RUN)
        bench.axis("m2").do("enable")
        with pytest.raises(ConfigError, match=r"\(`hil axis m2 disable`, then `hil axis m2 calibrate`, then"):
            bench.perform(RUN)
        with pytest.raises(VerbRefused, match="m2: the look-up table is empty; calibrate it first"):
            bench.axis("m2").do("move_abs", position_deg=9)


def test_a_closed_bench_lets_no_time_pass() -> None:
    with Bench(TWO) as bench:
        bench.run(ms=1)
    with pytest.raises(ValueError, match=r"the bench t is closed.* use it inside of its `with`"):
        bench.run(ms=1)
    assert bench.now_ns == 1_000_000  # what it was can be read
