"""Dialogue with one GDB about one chip.

While the chip runs, GDB waits. It stops at breakpoints, after steps, and when GDB interrupts.
"""

from collections.abc import Callable
from enum import IntEnum

from hil.gdb.avr_target import (
    PC,
    SP,
    SREG,
    DebuggedChip,
    all_registers,
    read_memory,
    register,
    set_all_registers,
    set_register,
    write_memory,
)
from hil.gdb.remote_packets import MOST_BYTES, Interrupt, PacketReader
from hil.gdb.run_control import RunControl

_DONE, _UNKNOWN, _REFUSED = b"OK", b"", b"E01"
_SAID = {
    "qSupported": b"PacketSize=%x;QStartNoAckMode+;vContSupported+" % MOST_BYTES,
    "qAttached": b"1",
    "qC": b"QC1",
    "qfThreadInfo": b"m1",
    "qsThreadInfo": b"l",
    "qSymbol": _DONE,
}
"""Answers to queries that are always the same: there is one thread, which GDB did not start."""
_MONITOR = {
    "reset": "reset: reset the chip; it stands at its first instruction",
    "time": "time: the chip's cycles, and the bench's time",
}


class StopSignal(IntEnum):
    """Reasons for a stop, as GDB numbers them."""

    INTERRUPTED = 2
    TRAP = 5


class DebugSession:
    """Session of a GDB. ``send``: sends bytes to it. The chip is halted when the session begins, and runs
    again, without breakpoints, when it is closed."""

    def __init__(self, chip: DebuggedChip, send: Callable[[bytes], object]) -> None:
        self._chip, self._send = chip, send
        self._reader = PacketReader()
        self._run = RunControl(chip)
        self._signal = StopSignal.TRAP
        self.is_over = False
        """True once GDB has said that it leaves."""
        chip.halt()

    # ---- what comes in ----

    def received(self, data: bytes) -> None:
        """Take bytes from GDB."""
        answer = bytearray()
        for packet in self._reader.read(data, answer):
            if answer:  # an acknowledgement goes before what the packet causes
                self._send(bytes(answer))
                answer.clear()
            if self.is_over:
                return
            if isinstance(packet, Interrupt):
                self._interrupt()
            elif (said := self._answer(packet)) is not None:
                self._reply(said)
        if answer:
            self._send(bytes(answer))

    def stopped(self) -> None:
        """Note that the chip has stopped by itself, at a breakpoint or after a step."""
        if self._run.is_running and self._run.stopped():
            self._tell_stop(StopSignal.TRAP)

    def was_reset(self, is_other_program: bool = False) -> None:
        """Note that somebody has reset the chip, or given it another program; it runs or stands as before."""
        self._run.forget_step()
        self._say(
            "the chip was given another program: `file` reads its symbols"
            if is_other_program
            else "the chip was reset"
        )

    def close(self, why: str = "") -> None:
        """End the session, and let the chip run. ``why``: said in GDB, if it waits."""
        if self._run.is_running and not self.is_over:
            self._say(why)
            self._reply(b"W00")
        elif not self._run.is_running:
            self._run.let_go()
        self.is_over = True

    def _say(self, line: str) -> None:
        """Show a line in GDB, which takes one only while it waits."""
        if self._run.is_running:
            self._reply(b"O" + f"[hil: {line}]\n".encode().hex().encode())

    def _interrupt(self) -> None:
        if self._run.is_running:
            self._run.halt()
            self._tell_stop(StopSignal.INTERRUPTED)

    def _tell_stop(self, signal: StopSignal) -> None:
        self._signal = signal
        self._reply(self._stop_reply())

    def _stop_reply(self) -> bytes:
        names = b"".join(b"%02x:%b;" % (n, register(self._chip, n).hex().encode()) for n in (SREG, SP, PC))
        return b"T%02x%bthread:1;" % (self._signal, names)

    # ---- answers ----

    def _reply(self, payload: bytes) -> None:
        self._send(self._reader.sent(payload))

    def _answer(self, packet: bytes) -> bytes | None:
        """Answer to a packet; None: it comes when the chip stops, or there is none."""
        if self._run.is_running:  # GDB says nothing now but its interrupt
            return _REFUSED
        text = packet.decode("latin-1")
        try:
            return self._answer_command(text[:1], text[1:], packet)
        except ValueError:
            return _REFUSED

    def _answer_command(self, command: str, rest: str, packet: bytes) -> bytes | None:
        chip = self._chip
        match command:
            case "?":
                return self._stop_reply()
            case "g":
                return all_registers(chip).hex().encode()
            case "G":
                set_all_registers(chip, bytes.fromhex(rest))
            case "p":
                return register(chip, int(rest, 16)).hex().encode()
            case "P":
                number, _, content = rest.partition("=")
                set_register(chip, int(number, 16), bytes.fromhex(content))
            case "m":
                return read_memory(chip, *_numbers(rest)).hex().encode()
            case "M":
                place, _, content = rest.partition(":")
                write_memory(chip, *_numbers(place), bytes.fromhex(content))
            case "X":
                write_memory(chip, *_numbers(rest.partition(":")[0]), packet.partition(b":")[2])
            case "Z" | "z":
                return self._set_breakpoint(rest, is_on=command == "Z")
            case "c" | "s" | "C" | "S":
                self._resume(command.lower(), rest if command.islower() else rest.partition(";")[2])
                return None
            case "H" | "T" | "!":
                return _UNKNOWN if command == "!" else _DONE
            case "D":
                self._reply(_DONE)
                self.close()
                return None
            case "k":
                self.close()
                return None
            case "v":
                return self._answer_v(rest)
            case "q" | "Q":
                return self._answer_query(command + rest)
            case _:
                return _UNKNOWN
        return _DONE

    def _set_breakpoint(self, rest: str, *, is_on: bool) -> bytes:
        kind, _, place = rest.partition(",")
        if kind not in ("0", "1"):
            return _UNKNOWN  # of data: GDB steps and compares
        address = int(place.partition(",")[0], 16)
        breakpoints = self._run.breakpoints
        (breakpoints.add if is_on else breakpoints.discard)(address)
        return _DONE

    def _resume(self, how: str, address: str) -> None:
        if address:
            self._chip.jump(int(address, 16))
        (self._run.step if how == "s" else self._run.go)()

    def _answer_v(self, rest: str) -> bytes | None:
        if rest == "Cont?":
            return b"vCont;c;C;s;S;r"
        name, _, action = rest.partition(";")
        if name == "Kill":
            self._reply(_DONE)
            self.close()
            return None
        if name != "Cont" or not action:
            return _UNKNOWN
        action = action.partition(":")[0].partition(";")[0]
        if action[0] == "r":
            first, end = (int(each, 16) for each in action[1:].split(","))
            self._run.step(range(first, end))
        else:
            self._resume(action[0].lower(), "")
        return None

    def _answer_query(self, query: str) -> bytes:
        if query == "QStartNoAckMode":
            self._reader.has_acks = False
            return _DONE
        name, _, rest = query.partition(",")
        if name == "qRcmd":
            return self._monitor(bytes.fromhex(rest).decode("utf-8", "replace").split())
        return _SAID.get(query.partition(":")[0], _UNKNOWN)

    def _monitor(self, words: list[str]) -> bytes:
        match words:
            case ["reset", *_]:
                self._chip.reset()
                said = "reset; it stands at its first instruction\n"
            case ["time"]:
                said = f"{self._chip.words()}\n"
            case _:
                said = "".join(f"monitor {line}\n" for line in _MONITOR.values())
        return said.encode().hex().encode()


def _numbers(place: str) -> tuple[int, int]:
    address, _, count = place.partition(",")
    return int(address, 16), int(count, 16)
