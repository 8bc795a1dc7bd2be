"""Master at real ports, on the computer's clock: a pty with a node that a test writes."""

import asyncio
import gc
import os
import pty
import re
import socket
import struct
import tty
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager

import pytest

from device_profiles.sac.packet import Packet, PacketDecoder, encode
from hil.master import LineGone, LineUnreachable, LiveMaster, Outcome, open_line

ACK, NAK = b"\x06", b"\x15"
PATIENCE_S = 60
Answer = Callable[[Packet], bytes]


class Node:
    """Program at the other end of a pty that answers packets."""

    def __init__(self, answer: Answer, echoes: bool = False) -> None:
        self.end, far = pty.openpty()
        tty.setraw(far)
        self.path = os.ttyname(far)
        os.close(far)
        self.heard: list[Packet] = []
        self._answer, self._decoder, self._echoes = answer, PacketDecoder(), echoes

    def listen(self) -> None:
        asyncio.get_running_loop().add_reader(self.end, self._readable)

    def say(self, data: bytes) -> None:
        os.write(self.end, encode(1, 4, data))

    def _readable(self) -> None:
        try:
            data = os.read(self.end, 4096)
        except OSError:  # nobody has the port open
            asyncio.get_running_loop().remove_reader(self.end)
            return
        if self._echoes:
            os.write(self.end, data)
        for item in self._decoder.feed(data):
            if isinstance(item, Packet):
                self.heard.append(item)
                if answer := self._answer(item):
                    os.write(self.end, encode(1, item.destination, answer))

    def unplug(self) -> None:
        asyncio.get_running_loop().remove_reader(self.end)
        os.close(self.end)
        self.end = -1


@contextmanager
def node(answer: Answer, echoes: bool) -> Iterator[Node]:
    made = Node(answer, echoes)
    try:
        yield made
    finally:
        if made.end >= 0:
            os.close(made.end)


def work(
    answer: Answer,
    do: Callable[[LiveMaster, Node], Awaitable[None]],
    *,
    echoes: bool = False,
    wanted: bool | None = None,
) -> None:
    async def run(far: Node) -> None:
        async with asyncio.timeout(PATIENCE_S), open_line(far.path, echo=wanted) as live:
            far.listen()
            await do(live, far)

    with node(answer, echoes) as far:
        asyncio.run(run(far))


def test_commands_have_their_outcomes() -> None:
    async def do(live: LiveMaster, far: Node) -> None:
        done = await live.send(4, "m100")
        refused = await live.send(5, "m100")
        silent = await live.send(6, "m100")
        sent = await live.release()
        outcomes = [each.outcome for each in (done, refused, silent, sent)]
        assert outcomes == [Outcome.DONE, Outcome.REFUSED, Outcome.NOT_KNOWN, Outcome.SENT]
        said = [(packet.destination, packet.data) for packet in far.heard]
        assert said == [(4, b"m100"), *[(5, b"m100")] * 3, (6, b"m100"), (0, b"y")]
        assert list(live.table) == [4, 5]

    work(lambda packet: {4: ACK, 5: NAK}.get(packet.destination, b""), do)


def test_a_stop_is_said_to_all_and_to_each() -> None:
    async def do(live: LiveMaster, far: Node) -> None:
        stops = await live.stop([4], is_at_once=True)
        assert [each.outcome for each in stops] == [Outcome.SENT, Outcome.DONE]
        assert [(packet.destination, packet.data) for packet in far.heard] == [(0, b"S"), (4, b"S")]

    work(lambda packet: ACK if packet.destination else b"", do)


def test_a_port_that_vanishes_says_what_was_outstanding() -> None:
    async def do(live: LiveMaster, far: Node) -> None:
        first, second = live.start(4, "m100"), live.start(4, "m200")
        far.unplug()
        with pytest.raises(LineGone, match=r"has gone \(.+\); 4 m100: not known; 4 m200: not sent") as error:
            await live.settled([first, second])
        assert error.value.outstanding == (first, second)
        with pytest.raises(LineGone):
            await live.send(4, "m300")
        assert far.heard == []

    work(lambda packet: b"", do)


def test_what_a_node_says_by_itself_is_told() -> None:
    async def do(live: LiveMaster, far: Node) -> None:
        told = asyncio.Event()
        events = []
        live.listeners.append(lambda event: (events.append(event), told.set()))
        far.say(b" hello")
        await told.wait()
        assert [(event.node, event.kind, event.text) for event in events] == [(4, "text", "hello")]

    work(lambda packet: b"", do)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("/dev/nothing-here", "/dev/nothing-here: No such file"),
        ("socket://127.0.0.1:1", "socket://127.0.0.1:1: "),
        ("rfc2217://127.0.0.1:1", "rfc2217://127.0.0.1:1: "),
        ("nonsense://x", "nonsense://x: "),
    ],
)
def test_a_line_that_cannot_be_opened_is_told(line: str, why: str) -> None:
    async def run() -> None:
        async with open_line(line):
            pass

    with pytest.raises(LineUnreachable, match=re.escape(why)):
        asyncio.run(run())


def test_a_socket_that_its_peer_resets_is_closed() -> None:
    async def run(address: str) -> None:
        async with open_line(address) as line:
            peer, _ = server.accept()
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            peer.close()  # a reset
            while line.gone is None:
                await asyncio.sleep(0.01)

    with socket.create_server(("127.0.0.1", 0)) as server:
        asyncio.run(run(f"socket://127.0.0.1:{server.getsockname()[1]}"))
    gc.collect()  # an unclosed socket would warn here


def test_a_port_that_somebody_else_has_is_told() -> None:
    async def do(live: LiveMaster, far: Node) -> None:
        with pytest.raises(LineUnreachable, match=re.escape(far.path)):
            async with open_line(far.path):
                pass

    work(lambda packet: b"", do)


def test_a_kind_of_nodes_that_there_is_not_is_told() -> None:
    async def run(profile: str) -> None:
        async with open_line("/dev/null", profile=profile):
            pass

    with pytest.raises(LineUnreachable, match="no profile 'sak'; did you mean"):
        asyncio.run(run("sak"))
    with pytest.raises(LineUnreachable, match="no master for lines of mechaduino"):
        asyncio.run(run("mechaduino"))


@pytest.mark.parametrize("wanted", [None, True])
def test_an_adapter_that_echoes_is_recognised(wanted: bool | None) -> None:
    """Nothing that comes back is heard, not even as a stray packet or a garbled one."""

    async def do(live: LiveMaster, far: Node) -> None:
        for command in ("m100", "v50", "m200"):
            assert (await live.send(4, command)).outcome is Outcome.DONE
        assert live.echo.state == "yes"
        assert live.echo.dropped_bytes == sum(len(encode(4, 1, each)) for each in (b"m100", b"v50", b"m200"))
        assert live.master.garbled == 0
        assert list(live.table) == [4]

    work(lambda packet: ACK, do, echoes=True, wanted=wanted)


def test_an_adapter_without_an_echo_is_known_too() -> None:
    async def do(live: LiveMaster, far: Node) -> None:
        for _ in range(4):
            assert (await live.send(4, "m100")).outcome is Outcome.DONE
            await asyncio.sleep(0.3)
        assert live.echo.state == "no"
        assert live.echo.dropped_bytes == 0

    work(lambda packet: ACK, do)
