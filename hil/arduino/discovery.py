"""``hil arduino-discovery``: tells the IDE which ports the running benches have.

The IDE 1.8 opens a port by its address with the serial monitor that it has: it is told of terminals alone.
"""

import select
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

from hil.arduino.protocol import Discovery, Message, board_port, board_port_1_8
from hil.arduino.stdio import InputLines, send
from hil.host.trust import refuse_address
from hil.net.benches_here import find_in
from hil.net.control_client import ControlError, ask, listener
from hil.vocab.port_programs import port_use

SYNC_LOOK_S = 1.0
_ANSWER_S = 1.0
"""Maximum wait for a daemon: a stopped or overloaded one must not hold up the others."""


class Benches:
    """Ports of the benches below ``bases``: the user's own, and those of services. ``is_named``: the user
    said where they are. ``for_1_8``: as the IDE 1.8 wants them."""

    def __init__(self, bases: Sequence[Path], is_named: bool = False, for_1_8: bool = False) -> None:
        self._bases, self._is_named, self._for_1_8 = bases, is_named, for_1_8
        self._last: dict[Path, list[Message]] = {}

    def ports(self) -> list[Message]:
        """List the ports that exist now. A daemon that does not answer keeps the ports it had."""
        now: dict[Path, list[Message]] = {}
        for here in find_in(self._bases, self._is_named).benches:
            path = here.socket
            try:
                now[path] = _ports(ask(path, "list", timeout_s=_ANSWER_S), here.owner)
            except ControlError:  # the protocol has no word for one bench of several: `hil list` says why
                with suppress(OSError):
                    if path in self._last and listener(path):
                        now[path] = self._last[path]
        self._last = now
        found = [port for ports in now.values() for port in ports]
        if self._for_1_8:
            return [board_port_1_8(port) for port in found if port["address"].startswith("/")]
        return found


def _ports(listed: dict[str, Any], owner: int) -> list[Message]:
    bench = listed["bench"]
    return [
        board_port(row["address"], bench, row["device"], profile=row["profile"], hardware=row["hardware"])
        for row in listed["devices"]
        if row["address"] and _is_usable(row) and not refuse_address(row["address"], owner)
    ]


def _is_usable(row: dict[str, Any]) -> bool:
    """True if hil's monitor for the IDE can open the port. One that hil holds itself is nobody else's."""
    use = port_use(row["port"], row["address"])
    return use is None or (not use.is_held and use.uses["IDE 2"].verdict != "no")


def discover(
    bases: Sequence[Path], commands_fd: int, out: TextIO, *, is_named: bool = False, for_1_8: bool = False
) -> None:
    """Serve one client, until QUIT or the end of its commands; the IDE 1.8 says no HELLO before them."""
    benches = Benches(bases, is_named, for_1_8)
    discovery, commands = Discovery(benches.ports, greets=not for_1_8), InputLines(commands_fd)
    with suppress(BrokenPipeError):  # the client has gone without QUIT
        while not (discovery.dead or commands.ended):
            readable, _, _ = select.select([commands.fd], [], [], SYNC_LOOK_S if discovery.syncing else None)
            if not readable:
                send(discovery.found(benches.ports()), out)
                continue
            for line in commands.read():
                send(discovery.command(line), out)
