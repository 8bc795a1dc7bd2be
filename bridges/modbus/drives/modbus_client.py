"""Client of Modbus drives at one place: pymodbus's, whose own retries and reconnects are off. They would send
a set-point again that has become old, and to a drive that has been reset meanwhile.

pymodbus is imported with the first place that is opened: a bench without real drives does without.
"""

import asyncio
import logging
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from bridges.modbus.drives.control_bits import RegisterWrite
from bridges.modbus.drives.modbus_drive_address import RtuPlace, TcpPlace
from bridges.modbus.protocol.exchange import sole_of_frame
from bridges.modbus.protocol.pdu import Span, Table, exception_words
from hil.drives.drive_link import Denied, Garbled, NoAnswer, PlaceLost
from hil.net.acceptor import abort
from hil.net.echo_guard import EchoGuard
from hil.vocab.ports import EchoStats, Sole
from hil.wire.echo import Echo

if TYPE_CHECKING:
    from pymodbus.client import AsyncModbusSerialClient, AsyncModbusTcpClient


_FUNCTIONS = {
    Table.COILS: 1,
    Table.DISCRETE_INPUTS: 2,
    Table.HOLDING_REGISTERS: 3,
    Table.INPUT_REGISTERS: 4,
}
_BITS = (Table.COILS, Table.DISCRETE_INPUTS)
_NEVER = 1 << 30
ILLEGAL_FUNCTION = 1


class Excepted(Denied):
    """Exception that a drive answered with; ``code`` is the protocol's."""

    def __init__(self, code: int, asked: str) -> None:
        words = exception_words(code).removeprefix("server ")
        super().__init__(f"it answered {asked} with exception {code:02} ({words})")
        self.code = code


class ModbusClient:
    """Client at one place, asked one thing at a time. ``timeout_s``: for a connection and for an answer;
    ``lost``: called when the connection is gone.

    Long because a connection that dies in any of its steps has to leave the same state.
    """

    def __init__(self, place: TcpPlace | RtuPlace, timeout_s: float, lost: Callable[[], None]) -> None:
        self._place = place
        self._timeout_s = timeout_s
        self._lost = lost
        self._client: AsyncModbusTcpClient | AsyncModbusSerialClient | None = None
        self.pause_s = 0.0
        """Silence behind an answer."""
        self._quiet_until_s = 0.0
        self._is_asking = False
        self._several_only: set[tuple[int, int]] = set()
        """Units and functions 05 and 06 that they have not: they are written by 15 and 16."""
        self._echo: Echo | None = None
        self._echo_guard: EchoGuard | None = None
        if isinstance(place, RtuPlace):
            bits = place.character_bits
            self._echo = Echo(place.baud, bits, wanted=place.echo, sole=_sole_of_request)

    @property
    def echo(self) -> EchoStats | None:
        """Echo of a serial line's adapter; None: it is no serial line."""
        return self._echo.told if self._echo else None

    @property
    def is_open(self) -> bool:
        return self._client is not None and self._client.connected

    def wait_for(self, timeout_s: float) -> None:
        """Wait so long for answers from now on."""
        self._timeout_s = timeout_s
        if self._client:
            self._client.ctx.comm_params.timeout_connect = timeout_s

    async def open(self) -> None:
        """Connect. Raises PlaceLost: that cannot be done now."""
        self.close()
        self._several_only.clear()  # another drive may be there
        client = self._client = self._make()
        try:
            async with asyncio.timeout(self._timeout_s):
                client.ctx.transport, _ = await client.ctx.call_create()
        except TimeoutError:
            self.close()
            raise PlaceLost(f"{self._place}: no connection within {self._timeout_s:g} s") from None
        except OSError as error:
            self.close()
            raise PlaceLost(f"{self._place}: {_reason(error)}") from None
        except Exception as error:  # of pyserial and termios: the line cannot be set up as it is wanted
            self.close()
            raise PlaceLost(f"{self._place}: {error}") from None

    def close(self) -> None:
        """Disconnect at once, whatever still waits to be sent."""
        client, self._client = self._client, None
        if self._echo_guard:
            self._echo_guard.close()
            self._echo_guard = None
        if client is None:
            return
        client.ctx.is_closing = True
        transport: Any = client.ctx.transport
        if transport:
            with suppress(Exception):  # a serial port that was unplugged
                if isinstance(self._place, RtuPlace):
                    transport.sync_serial.reset_output_buffer()
                abort(transport)
        client.ctx.transport = None  # type: ignore[assignment]

    async def read(self, unit: int, span: Span) -> Sequence[int]:
        """Read registers, or bits.

        Raises:
            PlaceLost, NoAnswer, Garbled, Excepted: they were not read.
        """
        client, code = self._opened(), _FUNCTIONS[span.table]
        ask: Any = {
            1: client.read_coils,
            2: client.read_discrete_inputs,
            3: client.read_holding_registers,
            4: client.read_input_registers,
        }[code]
        asked = f"a read of {span.table.value} {span.address} to {span.address + span.count - 1}"
        answer = await self._answer(ask(span.address, count=span.count, device_id=unit), code, asked)
        words: Sequence[int] = answer.bits if span.table in _BITS else answer.registers
        wanted = -(-span.count // 8) * 8 if span.table in _BITS else span.count
        if len(words) != wanted:
            raise Garbled(f"{asked} was answered with {len(words)}")
        return [int(word) for word in words[: span.count]]

    async def write(self, unit: int, write: RegisterWrite, functions: frozenset[int] | None = None) -> None:
        """Write words or bits. Raises as ``read``: they may have been written, or not. ``functions``: those
        that the drive has, None: all; without the one for several each word is written alone.

        A drive without the function for one of them (exception 01) is written by the one for several, from
        then on; many have one of the two alone.
        """
        one, several = (5, 15) if write.table in _BITS else (6, 16)
        if functions is not None and several not in functions:
            for at, word in enumerate(write.words, write.address):
                await self._write(one, unit, RegisterWrite(write.table, at, (word,)))
            return
        if functions is not None and one not in functions:
            await self._write(several, unit, write)
            return
        if len(write.words) > 1 or (unit, one) in self._several_only:
            await self._write(several, unit, write)
            return
        try:
            await self._write(one, unit, write)
        except Excepted as error:
            if error.code != ILLEGAL_FUNCTION:
                raise
            await self._write(several, unit, write)
            self._several_only.add((unit, one))

    async def _write(self, code: int, unit: int, write: RegisterWrite) -> None:
        client, count, is_one = self._opened(), len(write.words), code in (5, 6)
        asked = f"a write of {write.table.value} {write.address}"
        is_bits = write.table in _BITS
        ask: Any = {
            5: client.write_coil,
            6: client.write_register,
            15: client.write_coils,
            16: client.write_registers,
        }[code]
        words: Any = [bool(word) for word in write.words] if is_bits else list(write.words)
        given = words[0] if is_one else words
        answer = await self._answer(ask(write.address, given, device_id=unit), code, asked)
        said = (list(answer.bits) if is_bits else list(answer.registers)) if is_one else answer.count
        if answer.address != write.address or said != (words if is_one else count):
            raise Garbled(f"{asked} was answered as another")

    def _opened(self) -> "AsyncModbusTcpClient | AsyncModbusSerialClient":
        if self._client is None or not self._client.connected:
            raise PlaceLost(f"{self._place}: the connection is closed")
        return self._client

    async def _answer(self, asking: Any, code: int, asked: str) -> Any:
        from pymodbus.exceptions import ConnectionException, ModbusIOException

        loop = asyncio.get_running_loop()
        if (wait_s := self._quiet_until_s - loop.time()) > 0:
            await asyncio.sleep(wait_s)  # of two writes that are asked for together
        self._is_asking = True
        try:
            answer = await asking
        except (ConnectionException, OSError) as error:
            raise PlaceLost(f"{self._place}: {_said(error)}") from None
        except ModbusIOException:
            if not self.is_open:
                raise PlaceLost(f"{self._place}: the connection was closed") from None
            raise NoAnswer(f"no answer within {self._timeout_s:g} s") from None
        finally:
            self._is_asking = False
            self._quiet_until_s = loop.time() + self.pause_s
        if answer.isError() and answer.function_code == code | 0x80:
            raise Excepted(answer.exception_code, asked)
        if answer.function_code != code:
            raise Garbled(f"{asked} was answered with function {answer.function_code}")
        return answer

    def _make(self) -> "AsyncModbusTcpClient | AsyncModbusSerialClient":
        from pymodbus.client import AsyncModbusSerialClient, AsyncModbusTcpClient

        # What it would log, the state of the drive says, and once.
        logging.getLogger("pymodbus.logging").setLevel(logging.CRITICAL + 1)
        client: AsyncModbusTcpClient | AsyncModbusSerialClient
        if isinstance(self._place, TcpPlace):
            client = AsyncModbusTcpClient(
                self._place.host,
                port=self._place.port,
                reconnect_delay=0,
                timeout=self._timeout_s,
                retries=0,
                trace_connect=self._connected,
            )
        else:
            bits, parity, stop = tuple(self._place.format)
            client = AsyncModbusSerialClient(
                self._place.path,
                baudrate=self._place.baud,
                bytesize=int(bits),
                parity=parity,
                stopbits=int(stop),
                reconnect_delay=0,
                timeout=self._timeout_s,
                retries=0,
                trace_connect=self._connected,
                trace_packet=self._packet,
            )
        client.set_max_no_responses(_NEVER)
        self._guard(client)
        if self._echo:
            self._drop_echoes(client, self._echo)
        return client

    def _drop_echoes(self, client: "AsyncModbusTcpClient | AsyncModbusSerialClient", echo: Echo) -> None:
        """Let what was sent and comes back not be an answer."""
        context: Any = client.ctx
        echo.reopened()
        self._echo_guard = EchoGuard(echo, context.data_received, str(self._place))
        context.data_received = self._echo_guard.received

    def _packet(self, is_sending: bool, data: bytes) -> bytes:
        """Note what goes out, on its way through pymodbus."""
        if is_sending and self._echo_guard:
            self._echo_guard.sent(data)
        return data

    def _guard(self, client: "AsyncModbusTcpClient | AsyncModbusSerialClient") -> None:
        """Let bytes that make no message end no transport: they are dropped, and the request times out."""
        receive: Any = client.ctx.callback_data

        def guarded(data: bytes, addr: Any = None) -> int:
            try:
                used: int = receive(data, addr=addr)
                return used
            except Exception:  # struct.error, IndexError and its own, by what came
                return len(data)

        client.ctx.callback_data = guarded  # type: ignore[method-assign]

    def _connected(self, is_connected: bool) -> None:
        """Note the loss of the connection; a request that waits knows at once."""
        client = self._client
        if is_connected or client is None:
            return
        from pymodbus.exceptions import ConnectionException

        waiting = client.ctx.response_future
        if self._is_asking and not waiting.done():
            waiting.set_exception(ConnectionException("the connection was closed"))
        self._lost()


def _sole_of_request(data: bytes) -> Sole | None:
    return sole_of_frame(data, lambda unit: False)


def _said(error: BaseException) -> str:
    """Words of an error of pymodbus, without its own head."""
    return str(error).removeprefix("Modbus Error: ").removeprefix("[Connection] ") or type(error).__name__


def _reason(error: OSError) -> str:
    return os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
