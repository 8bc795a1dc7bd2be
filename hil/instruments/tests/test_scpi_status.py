"""Registers and the queue of errors of an instrument with SCPI's forms."""

import pytest

from hil.instruments.scpi_status import (
    ERROR,
    EVENTS,
    EVENTS_ENABLED,
    REQUESTS_ENABLED,
    STATUS,
    ScpiStatus,
    event_bit,
)


@pytest.mark.parametrize(
    ("error", "bit"),
    [
        ('-113,"Undefined header"', 32),
        ('-222,"Data out of range"', 16),
        ('-350,"Queue overflow"', 8),
        ('-0410,"Query INTERRUPTED"', 4),
        ('+511,"RS-232 framing error"', 8),
        ("Fault", 8),
        ('-999,"Unheard of"', 8),
    ],
)
def test_an_error_sets_its_bit(error: str, bit: int) -> None:
    assert event_bit(error) == bit


def test_a_look_at_the_event_register_clears_it() -> None:
    status = ScpiStatus(2, "none", "-350")
    status.note("-113")
    assert [status.look(EVENTS), status.look(EVENTS)] == [128 + 32, 0]


def test_a_full_queue_says_so() -> None:
    status = ScpiStatus(2, "none", "-350")
    status.clear()
    for error in ("-113", "-222", "-221"):
        status.note(error)
    assert [status.look(ERROR) for _ in range(3)] == ["-113", "-350", "none"]
    assert status.look(EVENTS) == 32 + 16 + 8


def test_the_status_byte_sums_what_is_enabled() -> None:
    status = ScpiStatus(20, "none", "")
    assert status.look(STATUS) == 0
    status.note("-113")
    assert status.look(STATUS) == 4
    status.put(EVENTS_ENABLED, 32)
    assert status.look(STATUS) == 4 + 32
    status.put(REQUESTS_ENABLED, 255)
    assert status.look(REQUESTS_ENABLED) == 255 - 64
    assert status.look(STATUS) == 4 + 32 + 64
    status.has_answer = True
    assert status.look(STATUS) == 4 + 16 + 32 + 64
    status.has_answer = False
    status.clear()
    assert [status.look(STATUS), status.look(EVENTS_ENABLED)] == [0, 32]
