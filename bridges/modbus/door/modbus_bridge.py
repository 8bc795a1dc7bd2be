"""Door for Modbus: opens what its options say, and tells its status."""

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from importlib.metadata import version
from typing import Any, TypeVar

from bridges.modbus.door.door_options import Certificates, Options
from bridges.modbus.door.request_handler import DoorUnit, DoorUnits, RequestHandler
from bridges.modbus.door.rtu_server import RtuServer
from bridges.modbus.door.tcp_client import CONNECTIONS, TcpConnections
from bridges.modbus.protocol.identification import Identification
from bridges.modbus.registers import layout
from bridges.modbus.registers.registers_protocol import EXCEPTIONS, device_identity
from hil.net.fair_share import SHARE
from hil.net.listeners import address_shown, open_listeners
from hil.vocab.bridge_protocol import BridgeError, DoorPort
from hil.vocab.desk_protocol import Desk
from hil.vocab.ports import Port, PortError

log = logging.getLogger("hil")

Connections = TypeVar("Connections", bound=TcpConnections)

RISK = "every program that can reach it can move all axes"


class ModbusBridge:
    """Modbus bridge, a ``hil.vocab.bridge_protocol.Bridge``."""

    def __init__(self, options: Options, desk: Desk) -> None:
        self._options = options
        self._bench = desk.describe().bench
        self._units = DoorUnits(desk, options.units, options.word_order == "low_first")
        self._handler = RequestHandler(desk, self._units, self._identity)
        self._tcp: TcpConnections | None = None
        self._addresses = [options.listen]
        self._line_units = [
            DoorUnits(desk, line.units, options.word_order == "low_first") if line.units else self._units
            for line in options.rtu
        ]
        self._lines: list[RtuServer] = []

    def wanted_ports(self) -> Sequence[DoorPort]:
        return self._options.wanted_ports()

    def take_ports(self, ports: Sequence[Port]) -> None:
        self._lines = [
            RtuServer(port, line.baud, self._handler, units)
            for port, line, units in zip(ports, self._options.rtu, self._line_units, strict=True)
        ]

    async def open(self) -> None:
        tcp = self.connections(TcpConnections)
        listeners = await open_listeners(self._options.listen)
        self._addresses = [address_shown(each) for each in listeners]
        if self._options.is_open:
            log.warning("bridges.modbus: insecure: %s (%s)", RISK, ", ".join(self._addresses))
        tcp.listen(listeners)
        try:
            for line in self._lines:
                await line.open()
        except PortError as error:
            await self.close()
            raise BridgeError(f"rtu: {error}") from None

    def connections(self, made: Callable[[RequestHandler, Certificates | None], Connections]) -> Connections:
        """Make the units, and the connections of those who ask them; nobody is let in yet."""
        for units in {self._units, *self._line_units}:
            units.open()
        self._tcp = tcp = made(self._handler, self._options.tls)
        return tcp

    async def close(self) -> None:
        if self._tcp:
            await self._tcp.close()
        for line in self._lines:
            await line.close()
        await self._handler.close()

    async def devices_changed(self, names: Collection[str]) -> None:
        for units in {self._units, *self._line_units}:
            units.renew(names)

    def status(self) -> Mapping[str, Any]:
        tcp, handler = self._tcp, self._handler
        closed = dict(tcp.closed) if tcp else {}
        turned_away = tcp.turned_away if tcp else 0
        return {
            "root": "modbus+tls" if self._options.tls else "modbus+tcp",
            "listen": [*self._addresses, *(line.address for line in self._lines)],
            "connect": [],
            "links": tcp.count if tcp else 0,
            "commands": handler.carried_out,
            "rejected": handler.exceptions.total() + sum(closed.values()) + turned_away,
            "dropped": 0,
            "insecure": self._options.is_open,
            "risk": RISK,
            "requests": handler.requests,
            "exceptions": dict(sorted(handler.exceptions.items())),
            "closed": closed,
            "turned_away": turned_away,
            "units": self._units.shown(),
            "lines": {
                line.address: _line_status(line, units)
                for line, units in zip(self._lines, self._line_units, strict=True)
            },
        }

    def _identity(self, unit: DoorUnit) -> Identification:
        """Identification of a unit, function 43/14."""
        return device_identity(unit.registers.map, self._bench, version("hil-motion"))


def _line_status(line: RtuServer, units: DoorUnits) -> dict[str, Any]:
    echo = {"echo": line.echo.as_dict()} if line.echo else {}
    return {**line.counters(), **echo, "units": units.shown()}


def reference() -> str:
    """Part of the reference about requests, exceptions and the register map's blocks."""
    refusals = "".join(f"| `{code}` | {number:02} |\n" for code, number in EXCEPTIONS.items())
    status = "".join(f"| {bit} | `{name}` | {about} |\n" for bit, (name, about) in enumerate(layout.STATUS))
    control = ", ".join(f"{bit} `{name}`" for bit, name in enumerate(layout.CONTROL))
    blocks = "".join(f"| {' | '.join(row)} |\n" for row in _BLOCKS)
    return (
        "## The Modbus bridge\n\n"
        "Functions 1 to 6, 15, 16, 22, 23 and 43/14, on serial lines 8 and 17 as well. At most"
        f" {CONNECTIONS} connections at a time, of which silent ones give way. Several clients have turns,"
        f" and together at most {SHARE:.0%} of the event loop's time. Requests of a connection are"
        " answered in their order. A connection whose framing is lost is closed. All registers of one read"
        " are of one moment.\n\n"
        f"`hil modbus map DEVICE` prints a device's map. Version {layout.VERSION} has these blocks:\n\n"
        f"| table | from | what it is |\n|---|---|---|\n{blocks}\n"
        "Values that take several registers have the high word first, or with `word_order: low_first` the"
        " low one. A register of one that is written alone waits for the others of it, which the same client"
        " writes; until then the value is the one before. A parameter is left out by NaN, or 80000000h of an"
        " i32; a choice is its number, from 0 on. A write that is refused is not taken at all; of one that"
        " asks for several things those before the refused one are done.\n\n"
        f"Control word: a bit that becomes 1 starts a verb with its defaults, one at a time: {control}.\n\n"
        f"| status bit | name | meaning |\n|---|---|---|\n{status}\n"
        f"| refusal | exception |\n|---|---|\n{refusals}\n"
        "A drive with a map of its own (`map` of a device) has that in place of these blocks.\n\n"
        "A unit that there is not is exception 10, one whose device a reload has taken away 11.\n"
    )


_BLOCKS = (
    ("input registers", "0", "what all kinds have: version, status, position and more"),
    ("input registers", f"{layout.FIELDS_AT}", "fields of the axis, at their place in the binary layout"),
    ("holding registers", f"{layout.CONTROL_AT}", "control word"),
    (
        "holding registers",
        f"{layout.COMMAND_AT}",
        "1 + number of a verb, then its parameters: one write starts it",
    ),
    ("holding registers", f"{layout.FIELDS_AT}", "fields that can be set, numbered as the input registers"),
    (
        "holding registers",
        f"{layout.PARAMETERS_AT}",
        f"parameters of verb n, from {layout.PARAMETERS_AT} + {layout.PER_VERB} n on, two registers each",
    ),
    (
        "coils",
        f"{layout.STARTS_AT}",
        "1 starts verb n; reads 1 until its motion has ended; 0 clears done and refused",
    ),
    ("coils", f"{layout.RESET_AT}", "reset"),
    ("coils", f"{layout.INPUTS_AT}", "pins that can be driven"),
    ("discrete inputs", f"{layout.DONE_AT}", "verb n has been done, and its motion has ended"),
    ("discrete inputs", f"{layout.PINS_AT}", "pins"),
    ("discrete inputs", f"{layout.STATUS_AT}", "bits of the status word"),
    ("discrete inputs", f"{layout.REFUSED_AT}", "verb n was refused, or something else ended its motion"),
)
