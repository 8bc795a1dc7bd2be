"""``setpoints:`` and ``bridges:`` in the configuration, and what is wrong with them."""

import pytest
from pydantic import BaseModel, ConfigDict, Field

from hil.compose import find_catalogue
from hil.config import Catalogue, ConfigError, parse

HEAD = "bench: t\ndevices:\n  m1:\n    profile: mechaduino\n"


class Options(BaseModel):
    """Options of a bridge of the tests."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)
    listen: str = Field(default="127.0.0.1:1", description="Where.")
    keys: int = Field(default=1, ge=1, description="How many.")


FOUND = find_catalogue()
CATALOGUE = Catalogue(FOUND.profiles, FOUND.ports, {"zenoh": Options})


def problems(text: str) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        parse(text, "b.yaml", CATALOGUE)
    return [str(problem) for problem in caught.value.problems]


def setpoints(given: str) -> str:
    return f"{HEAD}    setpoints: {given}\n"


def test_what_is_left_out_has_defaults() -> None:
    read = parse(setpoints("{timeout_ms: 250}"), "b.yaml", CATALOGUE).devices["m1"].setpoints
    assert read is not None
    assert (read.timeout_ms, read.policy, read.acceleration_rpm_per_s) == (250.0, "decelerate", 600.0)
    assert parse(HEAD, "b.yaml", CATALOGUE).devices["m1"].setpoints is None
    assert parse(setpoints("~"), "b.yaml", CATALOGUE).devices["m1"].setpoints is None


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ("{timeout_ms: 0}", "5:29: {}.timeout_ms: the number 0 is too small (write more than 0.0)"),
        ("{timeout_ms: -5}", "5:29: {}.timeout_ms: the number -5 is too small (write more than 0.0)"),
        (
            "{timeout_ms: 3600001}",
            "5:29: {}.timeout_ms: the number 3600001 is too large (write 3600000.0 or less)",
        ),
        (
            "{timeout_ms: .nan}",
            "5:29: {}.timeout_ms: nan is not a number to compute with (write a finite number)",
        ),
        (
            '{timeout_ms: "5"}',
            '5:29: {}.timeout_ms: a number is wanted here, not "5" (write it without quotes)',
        ),
        ("{policy: hold}", '5:5: {}.timeout_ms: this key is missing (add the line "timeout_ms: ...")'),
        (
            "{timeout_ms: 5, policy: brake}",
            "5:40: {}.policy: \"brake\" is none of the choices (write 'hold', 'decelerate' or 'torque_off')",
        ),
        (
            "{timeout_ms: 5, acceleration_rpm_per_s: 0.001}",
            "5:56: {}.acceleration_rpm_per_s: 0.001 is too small (write 0.01 or more)",
        ),
        ("{timeout_ms: 5, polcy: hold}", '5:32: {}.polcy: unknown key (did you mean "policy"?)'),
        ("{timeout: 5}", '5:17: {}.timeout: unknown key (did you mean "timeout_ms"?)'),
        (
            "100",
            "5:16: {}: keys are wanted here, not the number 100 (write {{timeout_ms: 100}})",
        ),
    ],
)
def test_what_is_wrong_with_setpoints(given: str, problem: str) -> None:
    assert problems(setpoints(given)) == ["b.yaml:" + problem.format("devices.m1.setpoints")]


def test_a_real_board_has_no_time_out() -> None:
    text = setpoints("{timeout_ms: 5}").replace("    setpoints", "    at: /dev/ttyUSB0\n    setpoints")
    assert problems(text) == [
        "b.yaml:6:5: devices.m1.setpoints: a real board (at: /dev/ttyUSB0) has its own"
        " (leave this key out, or leave out at)"
    ]


def test_only_real_boards_have_a_rate_of_setpoints() -> None:
    text = setpoints("{timeout_ms: 5}").replace("setpoints: {timeout_ms: 5}", "setpoint_rate_Hz: 20")
    assert problems(text) == [
        "b.yaml:5:5: devices.m1.setpoint_rate_Hz: a twin's set-point moves at each step (leave this key out)"
    ]
    real = text.replace("    setpoint", "    at: /dev/ttyUSB0\n    setpoint")
    assert parse(real, "b.yaml", CATALOGUE).devices["m1"].setpoint_rate_Hz == 20
    slow = real.replace("20", "0")
    assert problems(slow) == [
        "b.yaml:6:23: devices.m1.setpoint_rate_Hz: the number 0 is too small (write 1.0 or more)"
    ]


def test_only_real_boards_have_a_line_with_a_delay() -> None:
    text = setpoints("{timeout_ms: 5}").replace("setpoints: {timeout_ms: 5}", "line_delay_ms: 1000")
    assert problems(text) == [
        "b.yaml:5:5: devices.m1.line_delay_ms: a run reaches a twin without a line (leave this key out)"
    ]
    real = text.replace("    line_", "    at: /dev/ttyUSB0\n    line_")
    assert parse(real, "b.yaml", CATALOGUE).devices["m1"].line_delay_ms == 1000
    for wrong, said in (("-1", "is too small (write 0.0 or more)"), ("60001", "is too large")):
        (problem,) = problems(real.replace("1000", wrong))
        assert problem.startswith("b.yaml:6:20: devices.m1.line_delay_ms: ")
        assert said in problem


def test_bridges_are_read_with_their_own_models() -> None:
    config = parse(HEAD + "bridges: {zenoh: {keys: 3}}\n", "b.yaml", CATALOGUE)
    assert config.bridges == {"zenoh": Options(keys=3)}
    assert parse(HEAD + "bridges: {zenoh: }\n", "b.yaml", CATALOGUE).bridges == {"zenoh": Options()}
    assert parse(HEAD + "bridges: {}\n", "b.yaml", CATALOGUE).bridges == {}


@pytest.mark.parametrize(
    ("given", "problem"),
    [
        ("{zenooh: {}}", '5:11: bridges.zenooh: there is no bridge "zenooh" (did you mean "zenoh"?)'),
        ("{can: {}}", '5:11: bridges.can: there is no bridge "can" (known are: zenoh)'),
        (
            "{zenoh: 5}",
            "5:18: bridges.zenoh: options are wanted here, not the number 5 (write {{}} for none)",
        ),
        ("{zenoh: [1]}", "5:18: bridges.zenoh: options are wanted here, not a list (write {{}} for none)"),
        ("{zenoh: {key: 1}}", '5:19: bridges.zenoh.key: unknown key (did you mean "keys"?)'),
        ("{zenoh: {keys: 0}}", "5:25: bridges.zenoh.keys: the number 0 is too small (write 1 or more)"),
        (
            "zenoh",
            '5:10: bridges: keys are wanted here, not "zenoh" (write {zenoh: {{}}})',
        ),
    ],
)
def test_what_is_wrong_with_bridges(given: str, problem: str) -> None:
    assert problems(f"{HEAD}bridges: {given}\n") == ["b.yaml:" + problem.replace("{{}}", "{}")]
