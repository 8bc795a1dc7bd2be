"""Clients of pymodbus at a bench in memory."""

import asyncio
import gc
import struct
import warnings
from typing import Any

import pytest
from pymodbus.client import AsyncModbusTcpClient, ModbusTcpClient
from pymodbus.exceptions import ConnectionException, ModbusIOException

from hil.testing import Bench

CONFIG = {
    "bench": "modbus",
    "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}, "s1": {"profile": "sac"}},
    "bridges": {"modbus": {"units": {"m1": 1, "s1": 7}}},
}

MOVE_ABS, PARAMETERS_OF_MOVE = 8, 2000 + 32 * 8


@pytest.fixture
def started() -> Any:
    with Bench(CONFIG) as bench:
        assert not bench.start()
        yield bench


def test_a_client_is_one_of_pymodbus_and_connected(started: Bench) -> None:
    client = started.modbus()
    assert isinstance(client, ModbusTcpClient)
    assert client.connected
    assert (client.comm_params.host, client.comm_params.port) == ("127.0.0.1", 1502)
    answer = client.read_input_registers(0, count=2, device_id=7)
    assert not answer.isError()
    assert answer.registers[0] == 1


def test_a_request_takes_the_time_of_its_two_ways(started: Bench) -> None:
    client, before_ns = started.modbus(), started.now_ns
    client.read_coils(0, count=1, device_id=1)
    assert started.now_ns - before_ns == 100_000


def test_a_program_that_asks_in_a_loop_sees_a_motion_end(started: Bench) -> None:
    client, began_ns = started.modbus(), started.now_ns
    assert not client.write_register(0, 1, device_id=1).isError()
    client.write_registers(PARAMETERS_OF_MOVE, list(struct.unpack(">2H", struct.pack(">f", 90))), device_id=1)
    assert not client.write_coil(MOVE_ABS, True, device_id=1).isError()
    assert client.read_coils(MOVE_ABS, count=1, device_id=1).bits[0]
    while not client.read_discrete_inputs(MOVE_ABS, count=1, device_id=1).bits[0]:
        assert started.now_ns - began_ns < 5e9
    assert started.axis("m1").snapshot().position_deg == pytest.approx(90, abs=0.5)
    assert not client.read_coils(MOVE_ABS, count=1, device_id=1).bits[0]
    assert started.now_ns - began_ns > 0.1e9


@pytest.mark.parametrize(
    ("unit", "address", "code"),
    [(2, 0, 10), (1, 65000, 2)],
)
def test_bad_requests_have_the_doors_exceptions(started: Bench, unit: int, address: int, code: int) -> None:
    answer = started.modbus().read_holding_registers(address, count=1, device_id=unit)
    assert answer.isError()
    assert answer.exception_code == code


def test_a_time_out_is_simulated_and_pymodbus_own(started: Bench) -> None:
    client, before_ns = started.modbus(timeout=20e-6, retries=2), started.now_ns
    with pytest.raises(ModbusIOException):
        client.read_coils(0, count=1, device_id=1)
    assert started.now_ns - before_ns == 3 * 20_000


def test_a_client_closes_and_connects_again(started: Bench) -> None:
    with started.modbus() as client:
        assert client.connected
    assert not client.connected
    assert client.connect()
    assert not client.read_coils(0, count=1, device_id=1).isError()
    client.close()
    assert not client.read_coils(0, count=1, device_id=1).isError()  # it connects by itself, as pymodbus does


def test_a_bench_that_is_closed_has_hung_up() -> None:
    bench = Bench(CONFIG)
    client = bench.modbus()
    bench.close()
    for _ in range(2):
        with pytest.raises(ConnectionException):
            client.read_coils(0, count=1, device_id=1)
    assert not client.connect()
    with pytest.raises(ValueError, match="the bench is closed"):
        bench.modbus()


def test_lost_framing_hangs_up(started: Bench) -> None:
    client = started.modbus()
    client.send(b"\0\1\xff\xff\0\2\1\1")
    with pytest.raises(ConnectionException):
        client.recv(None)
    assert client.connect()


def test_the_longest_silent_of_too_many_clients_is_let_go(started: Bench) -> None:
    clients = [started.modbus() for _ in range(65)]
    assert all(each.connected for each in clients)
    started.run(1)
    with pytest.raises(ConnectionException):
        clients[0].read_coils(0, count=1, device_id=1)
    assert not clients[1].read_coils(0, count=1, device_id=1).isError()


def test_a_bench_without_the_bridge_says_what_to_write() -> None:
    with Bench({"bench": "b", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        for call in (bench.modbus, bench.modbus_async):
            with pytest.raises(KeyError, match=r"no bridge modbus; write `bridges: \{modbus: \{\}\}`"):
                call()


def test_tasks_of_a_program_are_answered_in_the_order_of_their_times(started: Bench) -> None:
    said: list[tuple[str, int]] = []

    async def poll(name: str, pause_s: float) -> None:
        client = started.modbus_async()
        assert isinstance(client, AsyncModbusTcpClient)
        async with client:
            for _ in range(3):
                answer = await client.read_input_registers(0, count=2, device_id=1)
                assert answer.registers[0] == 1
                said.append((name, started.now_ns - began_ns))
                await asyncio.sleep(pause_s)

    async def main() -> None:
        await asyncio.gather(poll("a", 0.010), poll("b", 0.004))

    began_ns = started.now_ns
    asyncio.run(main())
    assert said == [
        ("a", 100_000),
        ("b", 100_000),
        ("b", 4_200_000),
        ("b", 8_300_000),
        ("a", 10_200_000),
        ("a", 20_300_000),
    ]


def test_a_sleep_of_a_program_is_simulated_and_so_is_its_time_out(started: Bench) -> None:
    async def main() -> None:
        loop, began_ns = asyncio.get_running_loop(), started.now_ns
        client = started.modbus_async(timeout=30e-6, retries=1, reconnect_delay=0)
        await client.connect()
        began_s = loop.time()
        await asyncio.sleep(20)
        assert loop.time() - began_s == pytest.approx(20)
        assert started.now_ns - began_ns == pytest.approx(20e9)
        with pytest.raises(ModbusIOException):
            await client.read_coils(0, count=1, device_id=1)
        client.close()

    asyncio.run(main())


def test_a_program_waits_for_threads_in_the_walls_time(started: Bench) -> None:
    async def main() -> None:
        client, before_ns = started.modbus_async(), started.now_ns
        await client.connect()
        assert await asyncio.to_thread(lambda: 7) == 7
        assert started.now_ns == before_ns
        client.close()

    asyncio.run(main())


def test_a_synchronous_client_within_a_task_lets_time_pass(started: Bench) -> None:
    async def main() -> int:
        mine, theirs = started.modbus_async(), started.modbus()
        await mine.connect()
        assert theirs.read_coils(0, count=1, device_id=1).bits
        assert (await mine.read_coils(0, count=1, device_id=1)).bits
        return started.now_ns

    before_ns = started.now_ns
    assert asyncio.run(main()) - before_ns == 200_000


def test_an_asynchronous_client_notes_that_the_door_has_hung_up(started: Bench) -> None:
    async def main() -> None:
        client = started.modbus_async(reconnect_delay=0)
        await client.connect()
        client.ctx.transport.write(b"\0\1\xff\xff\0\2\1\1")
        await asyncio.sleep(0.001)
        assert not client.connected
        assert await client.connect()
        client.close()

    asyncio.run(main())


def test_the_same_program_has_the_same_bytes_and_times_again() -> None:
    def heard() -> list[tuple[int, bool, bytes]]:
        told: list[tuple[int, bool, bytes]] = []
        with Bench(CONFIG, seed=5) as bench:
            bench.start()

            def trace(is_sent: bool, data: bytes) -> bytes:
                told.append((bench.now_ns, is_sent, data))
                return data

            one, two = (bench.modbus(trace_packet=trace) for _ in range(2))
            for client, unit in ((one, 1), (two, 7)) * 20:
                client.read_input_registers(0, count=40, device_id=unit)
                client.write_coil(0, True, device_id=unit)
                bench.run(3.7)
        return told

    assert heard() == heard()


def test_a_bench_that_nobody_closes_leaves_nothing() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bench = Bench(CONFIG)
        assert bench.modbus().connected
        del bench
        gc.collect()
