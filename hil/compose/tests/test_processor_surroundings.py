"""Keys of a device for what is around its processor: ``voltages`` and ``rs485``."""

from collections.abc import Mapping
from typing import Any

import pytest

from hil.testing import Bench
from hil.vocab.problem import ConfigError


def bench_of(**keys: object) -> dict[str, Any]:
    devices = {"u1": {"profile": "uno", **keys}, "m1": {"profile": "mechaduino"}}
    return {"bench": "around", "devices": devices}


def field(bench: Bench, name: str) -> float:
    return bench.runtime.devices["u1"].axis.get(name)


def test_voltages_are_there_from_the_start() -> None:
    with Bench(bench_of(voltages={"A0": 2.5, "A5": 0.1})) as bench:
        bench.run(1)
        assert (field(bench, "a0_V"), field(bench, "a1_V"), field(bench, "a5_V")) == (2.5, 0.0, 0.1)


def test_who_follows_a_field_shares_its_time() -> None:
    with Bench(bench_of(voltages={"A0": {"of": "m1.current_a_A", "gain": 0.5, "offset_V": 2.5}})) as bench:
        assert bench.runtime.parts.group_of("u1") is bench.runtime.parts.group_of("m1")
        bench.run(10)
        assert field(bench, "a0_V") == 2.5  # what is added to the field


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"voltages": {"A9": 1.0}}, "A9"),
        (
            {"voltages": {"A0": {"of": "m1.curent_a_A"}}},
            'm1 has no field "curent_a_A" (did you mean "current_a_A"?',
        ),
        ({"voltages": {"A0": {"of": "m2.current_a_A"}}}, 'there is no device "m2"'),
        ({"voltages": {"A0": {"of": "current"}}}, '"current" is no field'),
        ({"rs485": {"de": "D22"}}, 'a uno has no pin "D22"'),
    ],
)
def test_what_is_not_there_is_said_where_it_stands(keys: Mapping[str, object], said: str) -> None:
    with pytest.raises(ConfigError) as refused:
        Bench(bench_of(**keys))
    assert said in str(refused.value)


def test_other_boards_have_no_processor() -> None:
    config = {"bench": "b", "devices": {"m1": {"profile": "mechaduino", "voltages": {"A0": 1.0}}}}
    with pytest.raises(ConfigError, match="no processor that runs a user's program"):
        Bench(config)
