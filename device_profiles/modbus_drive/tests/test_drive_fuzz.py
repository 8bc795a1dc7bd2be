"""Any master: whatever it writes, the drive answers, goes on, and its registers tell one state."""

import contextlib
from collections.abc import Callable
from random import Random
from typing import Any

import pytest

from bridges.modbus.protocol.client_side import Answer, mask_write, read, write, write_single
from bridges.modbus.protocol.pdu import Refused, Request, Table

HOLDING, INPUT = Table.HOLDING_REGISTERS, Table.INPUT_REGISTERS
CONTROL = 4


def any_request(chance: Random) -> Request:
    address = chance.choice([0, 0, 1, 2, 3, 4, 4, 4, 5, 10, 12])
    count = chance.randint(1, 6)
    words = [
        chance.choice([0, 1, 3, 17, chance.getrandbits(5), chance.getrandbits(16)]) for _ in range(count)
    ]
    return chance.choice(
        [
            read(INPUT, chance.randint(0, 7), count),
            read(HOLDING, address, count),
            write(HOLDING, address, words),
            write_single(HOLDING, address, words[0]),
            mask_write(CONTROL, chance.getrandbits(16), chance.getrandbits(5)),
        ]
    )


@pytest.mark.parametrize("seed", range(4))
def test_any_requests_leave_a_drive_that_answers(master: Callable[..., Any], seed: int) -> None:
    plc, chance = master(), Random(seed)
    for _ in range(150):
        with contextlib.suppress(Refused):
            assert isinstance(plc.raw(any_request(chance)), Answer)
        assert plc.drive.failed is None
    bits = plc.kept(CONTROL)[0]
    is_on = bool(plc.axis.snapshot().loop_on)
    assert ("enabled" in plc.status) == is_on
    assert ("fault" in plc.status) == (plc.told(5) != (0,))
    assert is_on <= (bits & 1)  # with the loop on its bit is one
    plc.put(CONTROL, 0)
    plc.put(CONTROL, 8)
    plc.put(CONTROL, 0)
    assert plc.status <= {"moving"}
    assert plc.target(0.0, control=(60, 600, 1)) == ()
    assert plc.status == {"enabled"}
