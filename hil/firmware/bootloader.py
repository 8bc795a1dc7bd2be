"""Bootloader of a board: what a tool that uploads is answered over the serial port, as optiboot 4.4 does.

A tool speaks version 1 of the protocol of Atmel's STK500: a command, its bytes, and a space; the answer
begins with 14h and ends with 10h. The processor is held meanwhile, and nothing but this drives its pins.

Optiboot answers 0 for fuses and lock bits, and writes what is meant for the EEPROM into the flash. Here fuses
and lock bits are the processor's, and the EEPROM is refused.

Sources: Atmel, application note AVR061, STK500 Communication Protocol; DS40002061, chapter 28 (serial
programming instructions); how optiboot 4.4 behaves.
"""

from collections.abc import Callable, Generator
from typing import Any

from hil.sketch.chip import BOOT_START, ERASED, FLASH, NRWW_START, PAGE_BYTES, SIGNATURE
from hil.vocab.firmware import Board, ByteAvailable, Delay, Processor, Request
from hil.vocab.time import NS_PER_S

USUAL_BAUD = 115_200
LED_NUMBER = 13
"""Number of PB5, at which an LED is that it flashes."""
LED_TOGGLES = 6
LED_NS = 62_464_000
"""Time before each toggle: 976 counts of timer 1 at 16 MHz / 1024."""
SILENCE_NS = NS_PER_S
"""Silence after which its watchdog starts the sketch."""
RESTART_NS = 16_000_000
"""Shortest time of the watchdog, by which it starts the sketch at once."""
PAGE_ERASE_NS = PAGE_WRITE_NS = 4_500_000
"""Maximum time of an erase and of a write of a page. Source: DS40002061, chapter 27."""
RECEIVER_BYTES = 3
"""Room of the serial interface while nobody reads: two buffers and the shift register."""

SPACE, IN_SYNC, OK, FAILED = 0x20, 0x14, 0x10, 0x11
GET_PARAMETER, SET_DEVICE, SET_DEVICE_EXT, LEAVE = 0x41, 0x42, 0x45, 0x51
LOAD_ADDRESS, UNIVERSAL, WRITE_PAGE, READ_PAGE, READ_SIGNATURE = 0x55, 0x56, 0x64, 0x74, 0x75
VERSION = {0x81: 4, 0x82: 4}
"""Numbers of the version, major and minor, by their parameters."""
OTHER_PARAMETER = 3
EEPROM_TYPE = ord("E")
LARGEST_LENGTH = 256
"""Number of bytes that a length of 0 stands for."""
READ_EEPROM, WRITE_EEPROM, WRITE_OTHERS, ERASE_CHIP = 0xA0, 0xC0, 0xAC, 0x80
"""First bytes of serial programming instructions; of ``WRITE_OTHERS`` the second is ``ERASE_CHIP``, or says
which fuse."""
OSCCAL = 0x66
"""Address in the data space of the oscillator's calibration."""

NOTE = "upload"
NO_EEPROM = "a tool wanted the EEPROM: the bootloader writes and reads flash alone; a sketch can write it"
NO_FUSES = "a tool wanted to write fuses or lock bits, which no bootloader can: nothing was written"
IN_BOOT_SECTION = (
    f"a tool wanted to write pages from 0x{BOOT_START:04X} on, where the bootloader is: they were not written"
)

Wait = Generator[Request, Any, int]
Steps = Generator[Request, Any, None]


class _Over(Exception):
    """End of the bootloader: the watchdog starts the sketch."""


class Bootloader:
    """One start of the bootloader. ``wall_second_ns``: simulated time in a second of the wall; ``keep``:
    makes durable what the flash holds, before a tool hears that all is done; ``baud``: its speed."""

    def __init__(
        self,
        board: Board,
        processor: Processor,
        wall_second_ns: int,
        keep: Callable[[], Steps],
        baud: int = USUAL_BAUD,
    ) -> None:
        self._board, self._uart, self._processor, self._keep = board, board.uart, processor, keep
        self._baud = baud
        self._led = processor.name_of(LED_NUMBER)
        self._unread = bytearray()
        self._address = 0
        # A tool waits by the wall's clock: it has to find the window at any speed of the bench.
        self._silence_ns = max(SILENCE_NS, wall_second_ns)
        self._slowness = min(1.0, wall_second_ns / NS_PER_S)

    def run(self) -> Steps:
        """Start up, flash the LED, and take commands until a tool leaves, or a second is silent."""
        self._uart.set_baud(self._baud)
        start_up_ns = self._processor.start_up_cycles * NS_PER_S // self._processor.clock_Hz
        yield Delay(round(start_up_ns * self._slowness))
        self._uart.read_all()  # lost: the chip hears nothing in reset
        yield from self._flash_led()
        yield from self.listen()

    def listen(self, heard: bytes = b"") -> Steps:
        """Take commands, the first of which begins with what was heard."""
        self._uart.set_baud(self._baud)
        self._unread += heard
        try:
            while True:
                yield from self._command()
        except _Over:
            yield from self._keep()
            if self._led:
                self._board.pins.let_go(self._led)
            self._uart.set_baud(None)

    def _flash_led(self) -> Steps:
        self._light(0)
        for toggle in range(LED_TOGGLES):
            yield Delay(round(LED_NS * self._slowness))
            self._light(1 - toggle % 2)
        heard = self._uart.read_all()
        if (
            len(heard) > RECEIVER_BYTES
        ):  # each later byte took the place of the one before, in the shift register
            heard = heard[: RECEIVER_BYTES - 1] + heard[-1:]
        self._unread += heard

    def _light(self, level: int) -> None:
        if self._led:
            self._board.pins.write(self._led, level)

    # ---- bytes ----

    def _byte(self) -> Wait:
        while not self._unread:
            if not (yield ByteAvailable(self._silence_ns)):
                raise _Over
            self._unread += self._uart.read_all()
        return self._unread.pop(0)

    def _bytes(self, number: int) -> Generator[Request, Any, bytes]:
        data = bytearray()
        while len(data) < number:
            data.append((yield from self._byte()))
        return bytes(data)

    def _end(self) -> Steps:
        """Read a command's end, and begin the answer. Another byte is no end: the watchdog strikes."""
        if (yield from self._byte()) != SPACE:
            yield Delay(RESTART_NS)
            raise _Over
        self._uart.write(bytes((IN_SYNC,)))

    # ---- commands ----

    def _command(self) -> Steps:
        command = yield from self._byte()
        carry_out = COMMANDS.get(command, Bootloader._nothing)
        self._uart.write(bytes(((yield from carry_out(self)),)))
        if command == LEAVE:
            yield Delay(RESTART_NS)
            raise _Over

    def _nothing(self) -> Wait:
        yield from self._end()
        return OK

    def _get_parameter(self) -> Wait:
        which = yield from self._byte()
        yield from self._end()
        self._uart.write(bytes((VERSION.get(which, OTHER_PARAMETER),)))
        return OK

    def _set_device(self) -> Wait:
        yield from self._bytes(20)
        return (yield from self._nothing())

    def _set_device_ext(self) -> Wait:
        yield from self._bytes(5)
        return (yield from self._nothing())

    def _leave(self) -> Wait:
        yield from self._end()
        yield from self._keep()
        return OK

    def _load_address(self) -> Wait:
        word = yield from self._bytes(2)
        self._address = 2 * int.from_bytes(word, "little") % FLASH.size
        return (yield from self._nothing())

    def _read_signature(self) -> Wait:
        yield from self._end()
        self._uart.write(SIGNATURE)
        return OK

    def _universal(self) -> Wait:
        command = yield from self._bytes(4)
        yield from self._end()
        self._uart.write(bytes((self._instruction(command),)))
        if command[0] in (READ_EEPROM, WRITE_EEPROM):
            self._board.note(NOTE, NO_EEPROM)
            return FAILED
        if command[0] == WRITE_OTHERS and command[1] != ERASE_CHIP:
            self._board.note(NOTE, NO_FUSES)
        return OK

    def _instruction(self, command: bytes) -> int:
        """Answer to a serial programming instruction, 0 to one that reads nothing of the chip's."""
        low, high, extended, lock = self._processor.fuses
        answers = {
            b"\x30\x00": (SIGNATURE + b"\0")[command[2] & 3],
            b"\x38\x00": self._processor.data(OSCCAL, 1)[0],
            b"\x50\x00": low,
            b"\x50\x08": extended,
            b"\x58\x00": lock,
            b"\x58\x08": high,
        }
        return answers.get(command[:2], 0)

    def _page(self) -> Generator[Request, Any, tuple[int, bool]]:
        """Length of a page's bytes, and whether it is one of the EEPROM."""
        _, length, kind = yield from self._bytes(3)
        return length or LARGEST_LENGTH, kind == EEPROM_TYPE

    def _write_page(self) -> Wait:
        length, is_eeprom = yield from self._page()
        data = yield from self._bytes(length)
        yield from self._end()
        if is_eeprom:
            self._board.note(NOTE, NO_EEPROM)
            return FAILED
        at = self._address
        if at >= BOOT_START:  # the lock bits of a Uno
            self._board.note(NOTE, IN_BOOT_SECTION)
            return OK
        # Below NRWW_START the erase goes on while the bytes come.
        yield Delay(PAGE_WRITE_NS + (PAGE_ERASE_NS if at >= NRWW_START else 0))
        page = bytearray((ERASED,)) * PAGE_BYTES
        for place, byte in enumerate(data[:PAGE_BYTES], at):
            page[place % PAGE_BYTES] = byte
        self._processor.load(at - at % PAGE_BYTES, bytes(page))
        return OK

    def _read_page(self) -> Wait:
        length, is_eeprom = yield from self._page()
        yield from self._end()
        if is_eeprom:
            self._board.note(NOTE, NO_EEPROM)
            self._uart.write(bytes((ERASED,)) * length)
            return FAILED
        flash, at = self._processor.flash, self._address
        self._uart.write((flash + flash)[at : at + length])
        self._address = (at + length) % FLASH.size
        return OK


COMMANDS: dict[int, Callable[[Bootloader], Wait]] = {
    GET_PARAMETER: Bootloader._get_parameter,
    SET_DEVICE: Bootloader._set_device,
    SET_DEVICE_EXT: Bootloader._set_device_ext,
    LOAD_ADDRESS: Bootloader._load_address,
    UNIVERSAL: Bootloader._universal,
    WRITE_PAGE: Bootloader._write_page,
    READ_PAGE: Bootloader._read_page,
    READ_SIGNATURE: Bootloader._read_signature,
    LEAVE: Bootloader._leave,
}
"""Commands that are more than themselves and a space, which is all that others are."""
