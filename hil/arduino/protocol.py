"""The pluggable discovery and the pluggable monitor as state machines: a line in, messages out, no I/O.

A message is a dict, sent as JSON. A failed command is answered by a message of its own ``eventType`` with
``error`` and the reason; a line that is no command, or in the wrong form, by ``command_error``.
"""

import re
from collections.abc import Callable, Sequence
from enum import Enum, auto
from typing import Any, Protocol

Message = dict[str, Any]

PROTOCOL_VERSION = 1
PROTOCOL = "hil"
"""Protocol of the ports. Not ``serial``: for that one the IDE takes its own monitor, which refuses a pty."""
PROTOCOL_LABEL = "Virtual board (hil)"
VENDOR, ARCHITECTURE = "hil", "virtual"
"""Folders of the boards in ``hardware``; both stand before a board's name."""
BAUDS = (
    *(300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800),
    *(500000, 921600, 1000000, 2000000),
)
DEFAULT_BAUD = 115200
"""Default baud, as of ``hil serve``. A device without ``baud:`` takes any."""
_HELLO = re.compile(r'(\d{1,9}) "([^"]+)"')
_OPEN = re.compile(r"(\S+):(\d{1,5}) (\S.*)")


def board_port(address: str, bench: str, device: str, **more: str) -> Message:
    """Describe a device's port as the IDE shows it. Its properties are what ``boards.txt`` recognises a board
    by; its id is the same wherever the device's port is."""
    return {
        "address": address,
        "label": f"{bench}/{device}",
        "protocol": PROTOCOL,
        "protocolLabel": PROTOCOL_LABEL,
        "hardwareId": f"hil/{bench}/{device}",
        "properties": {"bench": bench, "device": device} | more,
    }


def board_port_1_8(port: Message) -> Message:
    """Describe the same port as the IDE 1.8 wants it, which knows a board by its whole name."""
    name = f"{VENDOR}:{ARCHITECTURE}:{port['properties']['profile']}"
    return port | {"identificationPrefs": {".": name}}


def _done(event: str, message: str = "OK", **more: Any) -> list[Message]:
    return [{"eventType": event, "message": message} | more]


def _failed(event: str, reason: str) -> list[Message]:
    return [{"eventType": event, "error": True, "message": reason}]


def _malformed(reason: str) -> list[Message]:
    return _failed("command_error", reason)


class _Dialogue:
    """Commands of both protocols: HELLO comes first where the client ``greets``, and QUIT always works."""

    def __init__(self, greets: bool = True) -> None:
        self.dead = False
        """True once QUIT has come: nothing more is answered."""
        self._greeted = not greets
        self._commands: dict[str, Callable[[str], list[Message]]] = {"HELLO": self._hello, "QUIT": self._quit}

    def command(self, line: str) -> list[Message]:
        """Answer one line of the client, without its end."""
        if self.dead:
            return []
        word, _, rest = line.strip().partition(" ")
        run = self._commands.get(word)
        if run is None:
            return _malformed(f"Unknown command {word}")
        if not self._greeted and word not in ("HELLO", "QUIT"):
            return _malformed(f"HELLO must come before {word}")
        return run(rest)

    def _hello(self, rest: str) -> list[Message]:
        if self._greeted:
            return _failed("hello", "HELLO was said already")
        if not _HELLO.fullmatch(rest):
            return _malformed('the form is HELLO <protocol version> "<user agent>"')
        self._greeted = True
        # One version exists. A client that knows none has to decide whether it goes on.
        return _done("hello", protocolVersion=PROTOCOL_VERSION)

    def _quit(self, rest: str) -> list[Message]:
        self.dead = True
        return _done("quit")


class _Mode(Enum):
    IDLE = auto()
    RUNNING = auto()
    SYNCING = auto()


class Discovery(_Dialogue):
    """Discovery protocol. ``find`` answers the present ports; its OSError is reported to the client. The IDE
    1.8 does not greet: it has START_SYNC, STOP and the events alone."""

    def __init__(self, find: Callable[[], Sequence[Message]], greets: bool = True) -> None:
        super().__init__(greets)
        self._find = find
        self._mode = _Mode.IDLE
        self._known: dict[str, Message] = {}
        self._commands |= {
            "START": self._start,
            "STOP": self._stop,
            "LIST": self._list,
            "START_SYNC": self._start_sync,
        }

    @property
    def syncing(self) -> bool:
        """True while the client wants to be told of changes: call ``found`` then."""
        return self._mode is _Mode.SYNCING and not self.dead

    def found(self, ports: Sequence[Message]) -> list[Message]:
        """Make the events that lead from what the client knows to ``ports``. A port whose description has
        changed is added again, which replaces it."""
        if not self.syncing:
            return []
        now = {port["address"]: port for port in ports}
        gone = [address for address in self._known if address not in now]
        fresh = [port for address, port in now.items() if self._known.get(address) != port]
        self._known = now
        return [
            *({"eventType": "remove", "port": {"address": a, "protocol": PROTOCOL}} for a in gone),
            *({"eventType": "add", "port": port} for port in fresh),
        ]

    def _start(self, rest: str) -> list[Message]:
        if self._mode is not _Mode.IDLE:
            return _failed("start", "the discovery is started already")
        self._mode = _Mode.RUNNING
        return _done("start")

    def _stop(self, rest: str) -> list[Message]:
        if self._mode is _Mode.IDLE:
            return _failed("stop", "the discovery is not started")
        self._mode = _Mode.IDLE
        self._known = {}
        return _done("stop")

    def _list(self, rest: str) -> list[Message]:
        if self._mode is not _Mode.RUNNING:
            return _failed("list", "LIST needs START before it, and not START_SYNC")
        try:
            return [{"eventType": "list", "ports": list(self._find())}]
        except OSError as error:
            return _failed("list", str(error))

    def _start_sync(self, rest: str) -> list[Message]:
        # Some editions of the specification want START before it; the clients do without.
        if self._mode is _Mode.SYNCING:
            return _failed("start_sync", "START_SYNC was said already")
        try:
            ports = self._find()
        except OSError as error:
            return _failed("start_sync", str(error))
        self._mode = _Mode.SYNCING
        return _done("start_sync") + self.found(ports)


class MonitorLink(Protocol):
    """Monitor's way to port and client. Every method may raise OSError: ``str(error)`` says why."""

    def open(self, client: tuple[str, int], address: str, baud: int) -> None:
        """Open the board's port and connect to the client, which listens; then copy both ways."""

    def set_baud(self, baud: int) -> None:
        """Set the baud of the open port."""

    def close(self) -> None:
        """Close both ends."""


class Monitor(_Dialogue):
    """Monitor protocol of one port at a time. ``lost``: the port or the client has gone by itself."""

    def __init__(self, link: MonitorLink) -> None:
        super().__init__()
        self._link = link
        self._baud = DEFAULT_BAUD
        self._is_open = False
        self._commands |= {
            "DESCRIBE": self._describe,
            "CONFIGURE": self._configure,
            "OPEN": self._open,
            "CLOSE": self._close,
        }

    def lost(self, reason: str) -> list[Message]:
        if not self._is_open:
            return []
        self._is_open = False
        self._link.close()
        return _done("port_closed", reason)

    def _describe(self, rest: str) -> list[Message]:
        bauds = [str(baud) for baud in BAUDS]
        # The specification says "values"; the sources of arduino-cli 1 and of its monitors say "value".
        baudrate = {"label": "Baudrate", "type": "enum", "values": bauds, "value": bauds}
        parameters = {"baudrate": baudrate | {"selected": str(self._baud)}}
        port = {"protocol": PROTOCOL, "configuration_parameters": parameters}
        return _done("describe", port_description=port)

    def _configure(self, rest: str) -> list[Message]:
        name, _, value = rest.partition(" ")
        if not name or not value:
            return _malformed("the form is CONFIGURE <parameter name> <value>")
        if name != "baudrate":
            return _failed("configure", f"there is no parameter {name}")
        if value not in map(str, BAUDS):
            return _failed("configure", f"invalid value for parameter baudrate: {value}")
        try:
            if self._is_open:
                self._link.set_baud(int(value))
        except OSError as error:
            return _failed("configure", str(error))
        self._baud = int(value)
        return _done("configure")

    def _open(self, rest: str) -> list[Message]:
        form = _OPEN.fullmatch(rest)
        if form is None:
            return _malformed("the form is OPEN <host>:<port number> <board's port>")
        if self._is_open:
            return _failed("open", "a port is open already")
        host, number, address = form.groups()
        try:
            self._link.open((host.strip("[]"), int(number)), address, self._baud)
        except OSError as error:
            return _failed("open", str(error))
        self._is_open = True
        return _done("open")

    def _close(self, rest: str) -> list[Message]:
        return _done("close") if self.lost("") else _failed("close", "port already closed")

    def _quit(self, rest: str) -> list[Message]:
        self.lost("")
        return super()._quit(rest)
