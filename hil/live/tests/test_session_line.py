"""A port joined to a device over a paced line, and devices whose firmware is broken."""

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from session_bench import Bench, Echo, MemoryPort

from hil.live.lines import PacedLines
from hil.live.port_link import BACKLOG_HOLD_BYTES, PortLink
from hil.live.sim_backends import UartBackend
from hil.sim.bench import BenchHooks
from hil.sim.inputs import Bytes, Reset
from hil.sim.processor_line import ProcessorLine
from hil.sim.twin import Twin
from hil.sim.uart import USB_HELD_BYTES
from hil.vocab.firmware import Board, ByteAvailable, CoreEvent, Delay, Main, UartFrame
from hil.vocab.line_format import LineFormat, format_named
from hil.vocab.time import FOREVER, SimTimeNs
from hil.wire.serial_line import character_ns, resample


@pytest.fixture(autouse=True)
def loop() -> Iterator[asyncio.AbstractEventLoop]:
    """Event loop that never runs: the tests say when what is due soon is due."""
    loop = asyncio.new_event_loop()
    asyncio.set_event_loop(loop)
    yield loop
    asyncio.set_event_loop(None)
    loop.close()


def lines_of(bench: Bench) -> PacedLines:
    return PacedLines(asyncio.get_event_loop(), lambda: bench.runtime.now_ns)


def joined(
    bench: Bench, device: Twin, port: MemoryPort, *, native_usb: bool = False
) -> PortLink[UartBackend]:
    link = PortLink[UartBackend](device.name, port)
    link.occupy(UartBackend(bench.runtime, lines_of(bench), link, device, native_usb=native_usb))
    port.resumed = 0
    return link


def paced(device_baud: int, client_baud: int | None) -> tuple[Bench, PortLink[UartBackend], MemoryPort]:
    bench = Bench()
    device = bench.add("m1", Echo, device_baud)
    port = MemoryPort(client_baud)
    return bench, joined(bench, device, port), port


def test_a_character_takes_its_time_each_way() -> None:
    # "abc" at 9600 baud: character n is complete at n * 10 / 9600 s; each is sent back from there.
    bench, link, port = paced(9600, 9600)
    link.received(b"abc")
    end = [n * 10 * 10**9 // 9600 for n in range(5)]
    bench.until(end[3] - 1)
    assert [(at_ns, data) for _, at_ns, data in bench.heard] == [(end[1], b"a"), (end[2], b"b")]
    bench.until(end[3])
    link.backend.flush()
    heard_ns = [at_ns + end[1] for at_ns in end[1:4]]
    assert link.backend.release(SimTimeNs(heard_ns[0] - 1)) == heard_ns[0]
    assert port.got == b""
    assert link.backend.release(SimTimeNs(heard_ns[0])) == heard_ns[1]
    assert port.got == b"a"
    assert link.backend.release(SimTimeNs(heard_ns[2])) == FOREVER
    assert port.got == b"abc"


@pytest.mark.parametrize(("device_baud", "client_baud"), [(38400, 19200), (19200, 38400), (115200, 9600)])
def test_a_mismatch_garbles_both_ways(device_baud: int, client_baud: int) -> None:
    # What the device reads is what its line model makes of the client's signal; its answer to each byte
    # is a signal of its own as soon as it is complete, joined to the one before if there is no gap.
    bench, link, port = paced(device_baud, client_baud)
    link.received(b"m\r")
    bench.until(10**9)
    read = [sampled.byte for sampled in resample(b"m\r", client_baud, device_baud)]
    assert b"".join(data for _, _, data in bench.heard) == bytes(read)
    link.backend.flush()
    link.backend.release(FOREVER)
    pieces: list[bytes] = []
    ends: list[int] = []
    for _, at_ns, data in bench.heard:
        if ends and at_ns <= ends[-1]:
            pieces[-1] += data
        else:
            pieces.append(data)
        ends.append(at_ns + 10 * 10**9 // device_baud)
    expected = [sampled.byte for piece in pieces for sampled in resample(piece, device_baud, client_baud)]
    assert list(port.got) == expected


def test_m_and_cr_at_half_the_rate_are_the_known_bytes() -> None:
    bench, link, _ = paced(38400, 19200)
    link.received(b"m\r")
    bench.until(10**9)
    assert b"".join(data for _, _, data in bench.heard).hex(" ") == "e6 9e e6 80"


def test_a_client_without_a_baud_has_the_devices() -> None:
    bench, link, port = paced(9600, None)
    link.received(b"x")
    bench.until(10**9)
    link.backend.flush()
    link.backend.release(FOREVER)
    assert port.got == b"x"


def test_a_client_that_does_not_read_holds_the_device_up() -> None:
    bench = Bench()
    device = bench.add("m1", Echo)
    port = MemoryPort()
    link = joined(bench, device, port)
    assert link.room() > 0
    port.unread = BACKLOG_HOLD_BYTES + 1
    assert link.room() == 0
    link.refresh()
    assert port.resumed == 0
    port.unread = 0
    link.drained()
    assert port.resumed == 1
    link.drained()
    assert port.resumed == 1


def test_a_held_port_reads_on_before_the_line_is_empty() -> None:
    # A client's line has no gap then: half of what the port took is still to be sent when it reads on.
    bench, link, port = paced(9600, 9600)
    link.received(bytes(USB_HELD_BYTES))
    assert link.room() == 0
    half = USB_HELD_BYTES // 2
    assert link.backend.release(bench.runtime.now_ns) == character_ns(half + 1, 9600)
    assert port.resumed == 0
    bench.until(character_ns(half + 1, 9600))
    link.backend.release(bench.runtime.now_ns)
    assert (port.resumed, link.room()) == (1, half + 1)


class Counted(UartBackend):
    """Backend that counts how often it is looked at."""

    released = 0
    refreshed = 0

    def release(self, now_ns: SimTimeNs) -> SimTimeNs:
        self.released += 1
        return super().release(now_ns)

    def refresh(self) -> None:
        self.refreshed += 1
        super().refresh()


def test_only_lines_that_hold_something_are_looked_at() -> None:
    bench = Bench()
    lines = lines_of(bench)
    links = [PortLink[Counted](f"m{i}", MemoryPort(9600)) for i in range(3)]
    for link in links:
        link.occupy(Counted(bench.runtime, lines, link, bench.add(link.label, Echo, 9600)))
    assert lines.release(SimTimeNs(0)) == FOREVER
    links[1].backend.send(SimTimeNs(0), b"ab")
    lines.flush()
    first_ns = character_ns(1, 9600)
    assert lines.release(SimTimeNs(first_ns)) == character_ns(2, 9600)
    assert lines.release(SimTimeNs(2 * first_ns + 1)) == FOREVER
    assert lines.release(FOREVER) == FOREVER
    assert [each.backend.released for each in links] == [0, 3, 0]  # once when it was put on its line
    port = links[2].port
    assert isinstance(port, MemoryPort)
    port.unread, port.resumed = BACKLOG_HOLD_BYTES + 1, 0
    assert links[2].room() == 0
    lines.refresh()
    port.unread = 0
    lines.refresh()
    lines.refresh()
    assert [each.backend.refreshed for each in links] == [0, 0, 2]
    assert port.resumed == 1


def test_without_a_baud_bytes_reach_the_port_at_once() -> None:
    bench = Bench()
    device = bench.add("m1", Echo)
    port = MemoryPort(9600)  # a USB client's baud means nothing
    link = joined(bench, device, port)
    link.received(b"hello")
    assert port.got == b"hello"


class Greeter(Echo):
    """Firmware that says so when it starts."""

    def main(self) -> Main:
        self.uart.write(b"up")
        yield from super().main()


@pytest.mark.parametrize(
    ("native_usb", "device_baud", "client_baud", "starts"),
    [
        (True, None, 1200, 2),
        (True, None, 1201, 1),
        (True, None, None, 1),
        (True, 1200, 1200, 1),
        (False, None, 1200, 1),
    ],
)
def test_the_touch_resets_a_board_with_native_usb(
    native_usb: bool, device_baud: int | None, client_baud: int | None, starts: int
) -> None:
    bench = Bench()
    device = bench.add("m1", Greeter, device_baud)
    link = joined(bench, device, MemoryPort(), native_usb=native_usb)
    bench.until(1_000_000)
    link.client_left(client_baud)
    bench.until(2_000_000)
    assert [data for _, _, data in bench.heard] == [b"up"] * starts


class UsbPort(MemoryPort):
    """Port that is a part of the board, and whose client chooses a format."""

    def __init__(self, baud: int | None = None, name: str = "8N1") -> None:
        super().__init__(baud)
        self.name = name
        self.powers: list[bool] = []
        self.errors: list[tuple[bool, bool]] = []

    def power(self, is_on: bool) -> None:
        self.powers.append(is_on)

    def client_format(self) -> LineFormat:
        found = format_named(self.name)
        assert found
        return found

    def tell_errors(self, *, framing: bool, parity: bool) -> None:
        self.errors.append((framing, parity))


def test_a_port_that_is_a_part_of_the_board_is_told_of_its_power() -> None:
    bench = Bench()
    device = bench.add("m1", Echo)
    port = UsbPort()
    link = joined(bench, device, port, native_usb=True)
    assert port.powers == [True]
    bench.runtime.apply_to(device, Reset())
    assert port.powers == [True, False, True]
    device.power.switch("no power", bench.runtime.now_ns)
    assert port.powers[3:] == [False, False]
    link.vacate()
    device.power.switch(None, bench.runtime.now_ns)
    assert len(port.powers) == 5


def test_an_adapter_is_not_told_of_the_boards_power() -> None:
    bench = Bench()
    port = UsbPort()
    joined(bench, bench.add("m1", Echo, 9600), port, native_usb=True)
    joined(bench, bench.add("m2", Echo), port)
    assert port.powers == []


@pytest.mark.parametrize(
    ("name", "heard", "got", "errors"),
    [
        ("8N1", b"mr", b"mr", []),
        ("7E1", b"\xedr", b"mr", []),  # the board's 8N1 of EDh is 7E1 of m
        ("8N2", b"mr", b"mr", []),
        ("7O1", b"m\xf2", b"mr", []),
    ],
)
def test_a_client_has_a_format_of_its_own(
    name: str, heard: bytes, got: bytes, errors: list[tuple[bool, bool]]
) -> None:
    bench = Bench()
    device, port = bench.add("m1", Echo, 9600), UsbPort(9600, name)
    link = joined(bench, device, port)
    link.received(b"mr")
    bench.until(10**9)
    assert b"".join(data for _, _, data in bench.heard) == heard
    link.backend.flush()
    link.backend.release(FOREVER)
    assert (bytes(port.got), port.errors) == (got, errors)


def test_a_client_is_told_of_errors_in_what_it_reads() -> None:
    bench = Bench()
    device, port = bench.add("m1", Greeter, 9600), UsbPort(9600, "7E1")
    link = joined(bench, device, port)
    bench.until(10**9)
    link.backend.flush()
    link.backend.release(FOREVER)
    assert bytes(port.got) == b"up"
    assert port.errors == [(False, True)]  # u and p have five and three ones


class FormattedProcessor:
    """Processor that runs, and whose program has set a format. It hears nothing."""

    is_running = True
    baud = 9600

    def __init__(self, name: str) -> None:
        found = format_named(name)
        assert found
        self.line_format = found
        self.heard: list[tuple[int, int]] = []

    def hear(self, start_ns: int, bit_ns: float, bits: int, length: int, *, is_broken: bool) -> bool:
        self.heard.append((bits, length))
        return True

    def retract(self, after_ns: int) -> None:
        """Ignored: it hears nothing."""


@pytest.mark.parametrize(
    ("sent", "read", "got", "errors"),
    [
        ("8E1", "8E1", b"ae", []),
        ("8E1", "8N1", b"ae", [(True, False)]),  # the parity bit of e is 0 where a stop bit is looked for
        ("8E1", "8O1", b"ae", [(False, True)]),
        ("7E1", "8N1", b"\xe1e", []),
        ("7E1", "7E1", b"ae", []),
    ],
)
def test_frames_of_a_program_have_its_format(
    sent: str, read: str, got: bytes, errors: list[tuple[bool, bool]]
) -> None:
    bench = Bench()
    device, port = bench.add("m1", Echo, 9600), UsbPort(9600, read)
    link = joined(bench, device, port)
    processor = FormattedProcessor(sent)
    uart = device.uarts[""]
    uart.processor = ProcessorLine(processor)
    for number, byte in enumerate(b"ae"):
        at_ns = SimTimeNs(number * 2_000_000)
        uart.send_frame(at_ns, UartFrame(byte, processor.line_format, 9600))
        link.backend.send(at_ns, bytes((byte,)))  # as it is handed on
    link.backend.flush()
    link.backend.release(FOREVER)
    assert (bytes(port.got), port.errors) == (got, errors)


@pytest.mark.parametrize("port", [MemoryPort(9600), UsbPort(9600, "8E1"), UsbPort(9600, "8N1")])
def test_a_program_hears_a_client_in_the_clients_format(port: MemoryPort) -> None:
    bench = Bench()
    device = bench.add("m1", Echo, 9600)
    link = joined(bench, device, port)
    processor = FormattedProcessor("8E1")
    device.uarts[""].processor = ProcessorLine(processor)
    link.received(b"e")
    is_8n1 = (
        isinstance(port, UsbPort) and port.name == "8N1"
    )  # another port does not say: as the program has it
    assert processor.heard == [(0x65, 8 if is_8n1 else 9)]


# ---- broken firmware ----


class Broken(Echo):
    """Firmware that echoes until ``!`` comes, then breaks in its own way."""

    how: Callable[[], Any]

    def main(self) -> Main:
        while True:
            yield ByteAvailable()
            byte = self.uart.read()
            if byte == ord("!"):
                yield from type(self).how()
                return
            self.uart.write(bytes([byte]))


def raises() -> Main:
    raise RuntimeError("lamp burnt out")
    yield


def loops() -> Main:
    while True:
        yield Delay(0)


def yields_nonsense() -> Main:
    yield "please"  # type: ignore[misc]


def sets_an_unknown_field() -> Main:
    raise KeyError("warp")
    yield


def returns() -> Main:
    return
    yield


@pytest.mark.parametrize(
    ("how", "why"),
    [
        (raises, "RuntimeError: lamp burnt out"),
        (loops, "FirmwareStuck: resumed"),
        (yields_nonsense, "FirmwareStuck: the main program yielded 'please'"),
        (sets_an_unknown_field, "KeyError"),
        (returns, "FirmwareStuck: the main program returned"),
    ],
)
def test_a_broken_firmware_stops_its_device_alone(how: Callable[[], Main], why: str) -> None:
    firmware = type("ThisBroken", (Broken,), {"how": staticmethod(how)})
    told: list[str | None] = []
    bench = Bench(BenchHooks(on_failed=lambda device: told.append(device.failed)))
    broken, sound = bench.add("m1", firmware), bench.add("m2", Echo)
    bench.until(1000)
    bench.runtime.apply_to(broken, Bytes(b"a!b"))
    assert broken.failed is not None
    assert broken.failed.startswith(why)
    assert told == [broken.failed]
    bench.runtime.apply_to(broken, Bytes(b"c"))
    bench.runtime.apply_to(sound, Bytes(b"d"))
    bench.until(10**9)
    assert sound.failed is None
    assert bench.heard == [("m1", 1000, b"a"), ("m2", 1000, b"d")]
    assert broken.due_ns == FOREVER
    assert told == [broken.failed]
    # Power off and on, and it works until the next !
    bench.runtime.apply_to(broken, Reset())
    bench.runtime.apply_to(broken, Bytes(b"e"))
    assert broken.failed is None
    assert bench.heard[-1] == ("m1", 10**9, b"e")


def test_a_firmware_that_fails_in_its_interrupt_stops_its_device_alone() -> None:
    class Interrupted(Echo):
        def __init__(self, board: Board) -> None:
            super().__init__(board)
            board.axis.set("print_yw", 1)
            board.axis.loop(True)

        def interrupt(self, event: CoreEvent) -> None:
            raise OSError(f"at {event.at_ns}")

    bench = Bench()
    broken, sound = bench.add("m1", Interrupted), bench.add("m2", Echo)
    bench.until(10**8)
    # The fifth control step is the first that prints.
    why = f"OSError: at {5 * 7385 * 1000 // 48} (test_session_line.py:"
    assert broken.failed
    assert broken.failed.startswith(why)
    assert broken.axis.snapshot().loop_on == 0
    bench.runtime.apply_to(sound, Bytes(b"d"))
    assert bench.heard == [("m2", 10**8, b"d")]
