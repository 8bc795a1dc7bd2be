"""Configurations with modules: those that can be, and the problems of those that cannot."""

import json
from typing import Any

import pytest

from hil.compose import find_catalogue
from hil.config import ConfigError, parse

DEVICES = {"m1": {"profile": "mechaduino"}, "arm": {"profile": "walter"}}


def problems(*modules: dict[str, Any], **keys: Any) -> list[str]:
    segments = {f"bus{place}": {"tmcl": {"modules": each, **keys}} for place, each in enumerate(modules)}
    text = json.dumps({"bench": "t", "devices": DEVICES, "segments": segments})
    try:
        parse(text, "bench.yaml", find_catalogue())
    except ConfigError as error:
        return [problem.message for problem in error.problems]
    return []


def test_a_good_one() -> None:
    assert problems({"m1": 1, "arm.ellbow": 255}) == []
    assert problems({"m1": 2}, host=9) == []


@pytest.mark.parametrize(
    ("modules", "why"),
    [
        ({"m1": 7, "arm.ellbow": 7}, "module 7 is m1 already"),
        ({"m1": 2}, "2 is the host's address: the module would take replies of others for requests"),
        ({"m2": 1}, 'there is no device "m2"'),
        ({"arm.elbo": 1}, "arm has no axis 'elbo'"),
    ],
)
def test_mistakes(modules: dict[str, Any], why: str) -> None:
    (said,) = problems(modules)
    assert why in said


@pytest.mark.parametrize("number", [0, 256])
def test_addresses_have_a_range(number: int) -> None:
    assert len(problems({"m1": number})) == 1


def test_an_axis_has_one_module() -> None:
    (said,) = problems({"m1": 1}, {"m1": 3})
    assert said == "segments.bus1.tmcl.modules.m1: m1 has a module on bus0 already"
