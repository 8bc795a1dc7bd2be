"""First words of `hil monitor`, and the bytes that Enter sends."""

from pathlib import Path

import pytest

from hil.cli.framework.shown_words import line_end
from hil.cli.monitor.monitor_command import first_words
from hil.cli.monitor.port_look import SeenPort


@pytest.mark.parametrize(
    ("address", "clients", "said"),
    [
        ("/run/hil/t/m1", 1, "each byte that the device says goes to one of you"),
        ("/run/hil/t/m1", 0, ""),
        ("socket://127.0.0.1:7001", 1, "both get all that the device says"),
        ("rfc2217://127.0.0.1:7001", 2, "both get all that the device says"),
    ],
)
def test_several_clients_of_a_port_are_told_what_comes_of_it(address: str, clients: int, said: str) -> None:
    hints = first_words("m1", "p", SeenPort(address, clients, Path("/nowhere")))
    told = [hint for hint in hints if "another program has this port open" in hint]
    assert len(told) == (clients > 0)
    assert all(said in hint for hint in told)


def test_the_ends_of_the_monitor_and_the_first_keys_are_told() -> None:
    hints = first_words("s1", "\r", None)
    assert hints[0] == "Ctrl-] ends the monitor."
    assert hints[-1] == "s1 does not repeat what it said at power-up: press Enter to see it answer."


def test_a_board_that_starts_says_when_it_answers() -> None:
    assert first_words("m1", "p", None, 3_210_000_000)[-1] == "m1 starts, and answers in 3.2 s."


def test_enter_sends_what_the_board_takes() -> None:
    assert [line_end(greeting) for greeting in ("p", "\r", "?\n", "*IDN?\r\n", "")] == [
        *(b"\n", b"\r", b"\n", b"\r\n", b"\n")
    ]
