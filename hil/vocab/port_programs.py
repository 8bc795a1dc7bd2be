"""Programs at ports: which kinds of program can use which kind of port, why others cannot, and what helps.

The one table of it: commands, reference and how-tos are made from it, or compared with it. A kind of port
that somebody else wrote has no row. A pty has no modem lines: the kernel answers ENOTTY to TIOCMGET.

Sources: the programs named here, tried at ports of each kind; of the Arduino IDE 2 and arduino-cli the
sources of their monitor alone (go.bug.st/serial, ``nativeOpen``).
"""

import re
from collections.abc import Iterator, Mapping
from typing import Literal, NamedTuple

Verdict = Literal["yes", "some", "help", "no"]

VERDICTS: Mapping[Verdict, str] = {
    "yes": "all of these programs can use the port as it is.",
    "some": "some of these programs can use it, or all of them for a part of what they do.",
    "help": "they can use it with help, such as `hil with-lines` or `hil arduino install`.",
    "no": "none of them can. Take another kind of port.",
}

PROGRAMS: Mapping[str, str] = {
    "terminals": "Terminal programs (picocom, minicom, tio, screen, PuTTY), and others that open a port and"
    " leave its modem lines alone.",
    "port lists": "Lists of ports: those of pyserial (`list_ports`), jssc, libserialport and udev.",
    "DTR/RTS": "Programs that set or read modem lines after opening: esptool, GTKTerm, CuteCom and others"
    " with QtSerialPort.",
    "IDE 1.8": "The Arduino IDE 1.8, from 1.8.9 on: list of ports, serial monitor and plotter.",
    "IDE 2": "The Arduino IDE 2 and arduino-cli: the same.",
    "ser2net": "Servers of adapters that open the port: ser2net, sredird.",
}
"""Kinds of program by their short names."""


class Use(NamedTuple):
    """Use that one kind of program can make of one kind of port. ``why`` and ``help`` are empty where
    nothing is missing."""

    verdict: Verdict
    why: str = ""
    help: str = ""


class PortUse(NamedTuple):
    """Row of a kind of port. ``label``: as users write it; ``uses``: by the names of ``PROGRAMS``.
    ``is_held``: hil itself has its address open, and clients are at the other end."""

    label: str
    uses: Mapping[str, Use]
    is_held: bool = False

    def shortfalls(self) -> Iterator[tuple[str, Use]]:
        """Programs for which something is missing, each with what, and what helps."""
        return ((name, each) for name, each in self.uses.items() if each.verdict != "yes")


_YES = Use("yes")
_USB = "`kind: usb`"
_INSTALL = f"`hil arduino install`, or {_USB}"
_PTY_INSTEAD = f"`port: pty` and `hil arduino install`, or {_USB}"
_PATHS_ALONE = "it opens paths alone"
_NO_LIST = Use("no", "a socket is in no list of serial ports", _USB)
_CONNECTS = Use(
    "some", "ser2net connects to it, sredird opens paths alone", "clients reach the socket without it"
)
_PTY: Mapping[str, Use] = {
    "terminals": _YES,
    "port lists": Use("no", "none has paths of this kind", f"`path: /dev/ttyACM9`, or {_USB}"),
    "DTR/RTS": Use("help", "a pty has no modem lines", f"`hil with-lines PROGRAM`, or {_USB}"),
    "IDE 1.8": Use("help", "its own list has the kernel's devices alone", _INSTALL),
    "IDE 2": Use("help", "its own monitor refuses a port without modem lines", _INSTALL),
    "ser2net": Use(
        "some",
        "raw they work; for RFC 2217 they set modem lines, and a pty has none",
        "`hil with-lines ser2net`, or `port: rfc2217` in place of the server",
    ),
}

PORT_USES: Mapping[str, PortUse] = {
    "pty": PortUse("pty", _PTY),
    "pty_in_dev": PortUse(
        "pty /dev/ttyACM9",
        {
            **_PTY,
            "port lists": Use(
                "some", "those of pyserial and jssc have it; udev's and libserialport's do not", _USB
            ),
        },
    ),
    "usb": PortUse("usb", dict.fromkeys(PROGRAMS, _YES)),
    "tcp": PortUse(
        "tcp",
        {
            "terminals": Use(
                "some",
                "nc, telnet, PuTTY (raw) and pyserial (`socket://`) open it; others open paths alone",
                "`hil monitor`, or `socat pty,raw,echo=0,link=PATH tcp:HOST:PORT`",
            ),
            "port lists": _NO_LIST,
            "DTR/RTS": Use("no", "it carries bytes alone", f"`port: rfc2217`, or {_USB}"),
            "IDE 1.8": Use("no", _PATHS_ALONE, _PTY_INSTEAD),
            "IDE 2": Use("help", f"for itself {_PATHS_ALONE}", _INSTALL),
            "ser2net": _CONNECTS,
        },
    ),
    "rfc2217": PortUse(
        "rfc2217",
        {
            "terminals": Use(
                "some",
                "telnet, PuTTY (telnet) and pyserial (`rfc2217://`) open it; others open paths alone",
                f"`port: pty`, or {_USB}",
            ),
            "port lists": _NO_LIST,
            "DTR/RTS": Use(
                "some",
                "those with pyserial, as esptool, open `rfc2217://HOST:PORT`; others open paths alone",
                _USB,
            ),
            "IDE 1.8": Use("no", _PATHS_ALONE, _PTY_INSTEAD),
            "IDE 2": Use(
                "no",
                "neither it nor hil's monitor for it speaks RFC 2217",
                _PTY_INSTEAD,
            ),
            "ser2net": _CONNECTS,
        },
    ),
    "serial": PortUse("serial", dict.fromkeys(PROGRAMS, _YES), is_held=True),
}
"""Uses by kind of port; ``pty_in_dev`` is a pty whose ``path:`` has the name of an adapter or a board."""

_NAMES_IN_LISTS = re.compile(r"/dev/tty(ACM|USB)\d")


def port_use(kind: str | None, address: str | None) -> PortUse | None:
    """Row of the port of this kind at this address; None: there is none."""
    if kind == "pty" and address and _NAMES_IN_LISTS.match(address):
        kind = "pty_in_dev"
    return PORT_USES.get(kind or "")


def is_held(kind: str | None) -> bool:
    """True if hil itself has such a port's address open."""
    use = port_use(kind, None)
    return use is not None and use.is_held
