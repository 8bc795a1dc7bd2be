"""The same requests at a bench in memory and at a door with sockets have the same answers."""

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as some
from pymodbus.client import ModbusTcpClient
from served_beside import ServedBeside

from hil.testing import Bench
from hil.testing.doors.door_time import TRIP_NS

CONFIG = {
    "bench": "modbus",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
        "d1": {"profile": "modbus_drive"},
    },
    "bridges": {"modbus": {"units": {"m1": 1, "s1": 7, "d1": 20}}},
}
UNITS = some.sampled_from([1, 1, 7, 20, 2, 0])
ADDRESSES = some.sampled_from(
    [0, 1, 2, 6, 8, 11, 12, 13, 200, 204, 300, 308, 1000, 1002, 2000, 2256, 2258, 65535]
)
COUNTS = some.integers(1, 20)
WORDS = some.sampled_from([0, 1, 2, 9, 0x42B4, 0x7FC0, 0x8000, 0xFFFF])
READINGS = some.tuples(some.sampled_from([1, 2, 3, 4]), UNITS, ADDRESSES, COUNTS)
WRITINGS = some.one_of(
    some.tuples(some.just(5), UNITS, some.integers(0, 12), some.booleans()),
    some.tuples(some.just(6), UNITS, ADDRESSES, WORDS),
    some.tuples(
        some.just(15), UNITS, some.integers(0, 12), some.lists(some.booleans(), min_size=1, max_size=4)
    ),
    some.tuples(some.just(16), UNITS, ADDRESSES, some.lists(WORDS, min_size=1, max_size=6)),
    some.tuples(some.just(22), UNITS, ADDRESSES, WORDS),
    some.tuples(some.just(23), UNITS, ADDRESSES, COUNTS),
)
RAW = some.tuples(some.just(0), UNITS, some.binary(min_size=1, max_size=9), some.none())
PAUSES = some.tuples(some.just(-1), some.integers(1, 400), some.none(), some.none())
ANY = some.one_of(READINGS, READINGS, WRITINGS, WRITINGS, RAW, PAUSES)
REQUESTS = some.lists(ANY, min_size=10, max_size=25)


def ask(client: ModbusTcpClient, request: tuple[Any, ...]) -> object:
    function, unit, address, value = request
    match function:
        case 0:
            client.send(b"\x12\x34\0\0" + (len(address) + 1).to_bytes(2, "big") + bytes([unit]) + address)
            return client.recv(None)
        case 1:
            return client.read_coils(address, count=value, device_id=unit)
        case 2:
            return client.read_discrete_inputs(address, count=value, device_id=unit)
        case 3:
            return client.read_holding_registers(address, count=value, device_id=unit)
        case 4:
            return client.read_input_registers(address, count=value, device_id=unit)
        case 5:
            return client.write_coil(address, value, device_id=unit)
        case 6:
            return client.write_register(address, value, device_id=unit)
        case 15:
            return client.write_coils(address, value, device_id=unit)
        case 16:
            return client.write_registers(address, value, device_id=unit)
        case 22:
            return client.mask_write_register(address=address, and_mask=0xF0F0, or_mask=value, device_id=unit)
    return client.readwrite_registers(
        read_address=address, read_count=value, write_address=12, values=[0x4234, 0], device_id=unit
    )


@pytest.mark.long
@settings(
    max_examples=12,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
@given(REQUESTS)
def test_any_requests_are_answered_as_at_the_served_door(requests: list[tuple[Any, ...]]) -> None:
    heard: list[bytes] = []
    said: list[bytes] = []
    with Bench(CONFIG) as bench:
        bench.start()
        beside = ServedBeside(CONFIG)
        try:
            mine = bench.modbus(trace_packet=lambda is_sent, data: heard.append(data) or data)
            theirs = ModbusTcpClient(
                "127.0.0.1", port=beside.port, trace_packet=lambda is_sent, data: said.append(data) or data
            )
            assert theirs.connect()
            for request in requests:
                if request[0] < 0:
                    bench.run(request[1])
                    beside.run_to(bench.now_ns)
                    beside.settle()
                    continue
                beside.run_to(bench.now_ns + TRIP_NS)
                got = ask(mine, request)
                want = ask(theirs, request)
                assert str(got) == str(want), request
                beside.run_to(bench.now_ns)
            assert heard == said
            theirs.close()
        finally:
            beside.close()


@pytest.mark.long
def test_a_live_bench_says_the_same(live_bench: Any) -> None:
    """Answers that time does not change: identification, presets, all exceptions."""
    options = {"bridges": {"modbus": CONFIG["bridges"]["modbus"] | {"listen": "127.0.0.1:0"}}}
    live = live_bench(CONFIG | options)
    host, _, port = live.ask("status")["bridges"]["modbus"]["listen"][0].rpartition(":")
    requests = [
        *((4, unit, 4, 2) for unit in (1, 7, 20)),
        *((3, unit, 2000, 40) for unit in (1, 7, 20)),
        *((function, unit, 65000, 1) for function in (1, 2, 3, 4) for unit in (1, 2)),
        (6, 1, 2256, 0x42B4),
        (3, 1, 2256, 2),
        (5, 7, 12, True),
        (16, 1, 0, [9] * 100),
        (0, 1, b"\x2b\x0e\x01\x00", None),
        (0, 1, b"\x63", None),
    ]
    with Bench(CONFIG) as bench, ModbusTcpClient(host, port=int(port)) as theirs:
        bench.start()
        mine = bench.modbus()
        for request in requests:
            assert str(ask(mine, request)) == str(ask(theirs, request)), request
