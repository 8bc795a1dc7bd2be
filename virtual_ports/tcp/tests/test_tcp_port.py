"""Real sockets: what clients send, what they get, what is counted, what one may do to the others."""

import asyncio
import os
import socket
import struct
from collections.abc import Callable
from pathlib import Path

import pytest
import serial
from pydantic import ValidationError

from hil.net.endpoint import authority
from hil.net.traffic import QUEUE_BYTES
from hil.testing.ports import DEADLINE_S, RecordingHost, Scenario, accounted, open_fds, run_port, until
from hil.vocab.ports import Port, PortContext, PortError
from virtual_ports.tcp.port import Options, make


def made(options: Options) -> tuple[Port, RecordingHost]:
    port = make(options, PortContext("b", "m1", Path("/nowhere")))
    return port, RecordingHost(port)


def connect(port: Port) -> socket.socket:
    host, number = port.address.removeprefix("socket://").rsplit(":", 1)
    connection = socket.create_connection((host.strip("[]"), int(number)))
    connection.setblocking(False)
    return connection


async def connected(port: Port) -> socket.socket:
    before = port.stats().connects
    connection = connect(port)
    await until(lambda: port.stats().connects == before + 1)
    return connection


async def read_exactly(connection: socket.socket, size: int) -> bytes:
    loop = asyncio.get_running_loop()
    data = b""
    while len(data) < size:
        chunk = await asyncio.wait_for(loop.sock_recv(connection, size - len(data)), DEADLINE_S)
        assert chunk, "closed early"
        data += chunk
    return data


def reset(connection: socket.socket) -> None:
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def run(scenario: Scenario, host: str = "127.0.0.1", max_clients: int = 32) -> None:
    async def leaving_nothing(port: Port, board: RecordingHost) -> None:
        without_listener = len(open_fds()) - 1
        await scenario(port, board)
        await port.close()  # run_port closes once more
        assert len(open_fds()) == without_listener

    options = Options(listen=authority(host, 0), max_clients=max_clients)
    run_port(make(options, PortContext("b", "m1", Path("/nowhere"))), leaving_nothing)


def test_every_byte_value_passes_both_ways_unchanged() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        every = bytes(range(256)) * 4
        port.write(b"for nobody")
        with await connected(port) as connection:
            connection.send(every)
            await until(lambda: len(board.got) == len(every))
            port.write(every)
            assert await read_exactly(connection, len(every)) == every
            assert board.got == every
            assert port.client_baud() is None
        await until(lambda: port.stats().clients == 0)
        stats = port.stats()
        assert (stats.connects, stats.rx_bytes, stats.tx_bytes) == (1, len(every), len(every))
        assert (stats.dropped_bytes, stats.unheard_bytes) == (0, 10)

    run(scenario)


def test_pyserial_opens_the_address() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        board.answer = lambda data: data.upper()

        def ask() -> bytes:
            with serial.serial_for_url(port.address, timeout=DEADLINE_S) as line:
                line.write(b"menu")
                return bytes(line.read(4))

        assert await asyncio.to_thread(ask) == b"MENU"

    run(scenario)


def test_the_address_shows_the_number_that_was_found() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        assert port.address.startswith("socket://127.0.0.1:")
        assert not port.address.endswith(":0")

    run(scenario)


def test_ipv6() -> None:
    if not socket.has_ipv6 or not os.path.exists("/proc/net/if_inet6"):
        pytest.skip("no IPv6 here")

    async def scenario(port: Port, board: RecordingHost) -> None:
        assert port.address.startswith("socket://[::1]:")
        with await connected(port) as connection:
            connection.send(b"m")
            await until(lambda: board.got == b"m")

    run(scenario, "::1")


def test_clients_share_the_line() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        clients = [await connected(port) for _ in range(4)]
        port.write(b"to all")
        for number, each in enumerate(clients):
            assert await read_exactly(each, 6) == b"to all"
            each.send(b"%d" % number)
            await until(lambda number=number: len(board.got) == number + 1)  # type: ignore[misc]
        assert board.got == b"0123"
        assert port.stats().clients == 4
        assert port.stats().tx_bytes == 24
        for each in clients:
            each.close()
        await until(lambda: port.stats().clients == 0)

    run(scenario)


def test_send_and_close_at_once_loses_nothing() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        for number in range(100):
            with connect(port) as connection:
                connection.send(b"%03d," % number)
        await until(lambda: port.stats().connects == 100 and port.stats().clients == 0)
        assert sorted(bytes(board.got).split(b",")) == [b"", *(b"%03d" % number for number in range(100))]

    run(scenario, max_clients=100)


def test_at_room_0_clients_are_held_up_and_nothing_is_lost() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        board.room_bytes = 10
        flood = bytes(range(128)) * 200
        first, second = await connected(port), await connected(port)
        first.sendall(flood)
        await until(lambda: len(board.got) == 10)
        first.close()
        second.send(b"\xfe" * 6)
        with await connected(port) as third:
            third.send(b"\xff" * 5)
            for _ in range(100):
                await asyncio.sleep(0)
            assert len(board.got) == 10
            total = len(flood) + 11
            while len(board.got) < total:
                board.room_bytes = 777
                port.resume_reading()
                await until(lambda: board.room_bytes == 0 or len(board.got) == total)
        assert bytes(byte for byte in board.got if byte < 128) == flood
        assert (board.got.count(0xFE), board.got.count(0xFF)) == (6, 5)
        assert port.stats().rx_bytes == total
        second.close()

    run(scenario)


def test_a_client_that_never_reads_costs_only_its_own_bytes() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        deaf, reader = await connected(port), await connected(port)
        sent = bytearray()
        block = bytes(range(256)) * 256
        while port.stats().dropped_bytes < 1_000_000:
            port.write(block)
            sent += block
            assert await read_exactly(reader, len(block)) == block
        assert port.backlog() == 0  # the reader has it all
        assert accounted(port) + QUEUE_BYTES == 2 * len(sent)
        deaf.send(b"m")
        await until(lambda: board.got == b"m")
        heard = 2 * len(sent) - port.stats().dropped_bytes - len(sent)
        assert await read_exactly(deaf, heard) == sent[:heard]
        await until(lambda: accounted(port) == 2 * len(sent))
        reader.close()
        deaf.close()

    run(scenario)


@pytest.mark.parametrize("leave", [reset, socket.socket.close])
def test_what_waited_for_a_client_that_leaves_is_counted(leave: Callable[[socket.socket], None]) -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        deaf = await connected(port)
        given = 0
        while port.stats().dropped_bytes == 0:
            port.write(bytes(30_000))
            given += 30_000
        assert port.backlog() == QUEUE_BYTES
        leave(deaf)
        await until(lambda: port.stats().clients == 0)
        assert accounted(port) == given
        await until(lambda: board.drains == 1)

    run(scenario)


def test_a_client_that_resets_does_not_disturb_others() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        with await connected(port) as steady:
            for number in range(50):
                reset(connect(port))  # before it is accepted
                rude = connect(port)
                connects = 3 + 2 * number
                await until(lambda connects=connects: port.stats().connects == connects)  # type: ignore[misc]
                port.write(b"a")
                reset(rude)
                port.write(b"b")  # into the dead connection
                steady.send(b"%02d" % number)
                assert await read_exactly(steady, 2) == b"ab"
            await until(lambda: len(board.got) == 100 and port.stats().clients == 1)

    run(scenario)


def test_a_dead_client_is_noticed_while_nobody_is_read() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        board.room_bytes = 1
        rude = await connected(port)
        rude.send(b"mm")
        await until(lambda: len(board.got) == 1)
        given = 0
        while port.backlog() == 0:
            port.write(bytes(30_000))
            given += 30_000
        reset(rude)
        await until(lambda: port.backlog() == 0)
        port.write(b"lost")
        assert accounted(port) == given + 4
        board.room_bytes = 100
        port.resume_reading()
        await until(lambda: port.stats().clients == 0)

    run(scenario)


def test_a_thousand_clients_leave_nothing_behind() -> None:
    async def scenario(port: Port, board: RecordingHost) -> None:
        fds = len(open_fds())
        for number in range(1000):
            connection = await connected(port)
            await until(lambda: port.stats().clients == 1)
            connection.send(b"x")
            port.write(b"reply")
            (reset if number % 7 == 0 else socket.socket.close)(connection)
        await until(lambda: port.stats().clients == 0)
        assert port.stats().connects == 1000
        assert accounted(port) == 5000
        assert len(open_fds()) == fds

    run(scenario)


def test_close_ends_the_clients_and_frees_the_number() -> None:
    async def main() -> None:
        port, board = made(Options())
        await port.open(board)
        number = int(port.address.rsplit(":", 1)[1])
        with await connected(port) as connection:
            await port.close()
            assert await asyncio.get_running_loop().sock_recv(connection, 1) == b""
            again, board = made(Options(listen=f"127.0.0.1:{number}"))
            await again.open(board)
            await again.close()

    asyncio.run(main())


def refused(options: Options) -> str:
    fds = open_fds()

    async def main() -> str:
        port, board = made(options)
        with pytest.raises(PortError) as error:
            await port.open(board)
        await port.close()
        return str(error.value)

    text = asyncio.run(main())
    assert open_fds() == fds
    assert "\n" not in text
    return text


def test_a_number_in_use_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        number = other.getsockname()[1]
        text = refused(Options(listen=f"127.0.0.1:{number}"))
    assert f"127.0.0.1:{number} is in use by " in text
    assert f"(process {os.getpid()}); choose another port, or end it" in text


def test_an_address_that_is_not_ours_is_refused() -> None:
    text = refused(Options(listen="192.0.2.1:5000"))  # RFC 5737: nobody's
    assert "192.0.2.1:5000 is no address of this computer; write 127.0.0.1" in text


def test_a_host_that_does_not_exist_is_refused() -> None:
    said = "there is no computer 'no-such-host.invalid'; write 127.0.0.1"
    assert said in refused(Options(listen="no-such-host.invalid:0"))


@pytest.mark.parametrize(
    "options",
    [{"port": "5000"}, {"port": 65536}, {"host": ""}, {"listen": "x" * 70}, {"listen": ":1"}, {"baud": 9600}],
)
def test_options_that_mean_nothing_are_refused(options: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        Options.model_validate(options)


def test_every_option_is_described() -> None:
    assert all("description" in field for field in Options.model_json_schema()["properties"].values())


def test_the_first_client_opens_the_line() -> None:
    async def scenario(port: Port, host: RecordingHost) -> None:
        with connect(port) as first:
            first.send(b"a")
            await until(lambda: host.got == b"a")
            with connect(port) as second:
                second.send(b"b")
                await until(lambda: host.got == b"ab")
        await until(lambda: port.stats().clients == 0)
        with connect(port):
            await until(lambda: host.openings == [0, 2])

    run(scenario)
