"""Menus of ``k``: gains of the two loops and the phase advance, kept in RAM.

Every choice is one byte. The main menu is left by any byte but its own; the loops' menus print themselves
again until q; the third one takes one edit. Spellings are the board's.
"""

from typing import NamedTuple

from device_profiles.mechaduino import text
from device_profiles.mechaduino.serial_usb import SerialUSB, Steps
from hil.vocab.firmware import Axis


class GainRow(NamedTuple):
    """Editable gain. ``row`` is the menu's text before the value."""

    letter: str
    row: str
    field: str
    empty_line_after: bool


class Menu(NamedTuple):
    title: str
    entries: tuple[GainRow, ...]


POSITION = Menu(
    "Edit position loop gains:",
    (
        GainRow("p", "p ----- pKp = ", "pKp", True),
        GainRow("i", "i ----- pKi = ", "pKi", True),
        GainRow("d", "d ----- pKd = ", "pKd", True),
        GainRow("l", "l----- LPF = ", "pLPF", True),
    ),
)
VELOCITY = Menu(
    "Edit velocity loop gains:",
    (
        GainRow("p", "p ----- vKp = ", "vKp", False),
        GainRow("i", "i ----- vKi = ", "vKi", False),
        GainRow("d", "d ----- vKd = ", "vKd", False),
        GainRow("l", "l ----- vLPF = ", "vLPF", True),
    ),
)
OTHER = Menu("Edit other parameters:", (GainRow("p", "p ----- PA = ", "PA", False),))


def edit_parameters(axis: Axis, serial: SerialUSB) -> Steps:
    """Run the main menu, once."""
    serial.println(*text.MAIN_EDIT_MENU)
    yield from serial.wait()
    match chr(serial.read()):
        case "p":
            yield from _edit_until_q(POSITION, axis, serial)
        case "v":
            yield from _edit_until_q(VELOCITY, axis, serial)
        case "o":
            _print_menu(OTHER, axis, serial)
            serial.println("")
            yield from serial.wait()
            yield from _edit(OTHER, serial.read(), axis, serial)


def _edit_until_q(menu: Menu, axis: Axis, serial: SerialUSB) -> Steps:
    while True:
        _print_menu(menu, axis, serial)
        serial.println("q ----- quit", "")
        yield from serial.wait()
        choice = serial.read()
        if choice == ord("q"):
            serial.println(*text.DONE)
            return
        yield from _edit(menu, choice, axis, serial)


def _print_menu(menu: Menu, axis: Axis, serial: SerialUSB) -> None:
    serial.println(menu.title, "")
    for entry in menu.entries:
        serial.print(entry.row)
        serial.print_float(axis.get(entry.field), 10)
        serial.println("")


def _edit(menu: Menu, choice: int, axis: Axis, serial: SerialUSB) -> Steps:
    for entry in menu.entries:
        if choice == ord(entry.letter):
            serial.println(f"{entry.field} = ?")
            axis.set(entry.field, (yield from serial.ask_float()))
            serial.print(f"new {entry.field} = ")
            serial.print_float(axis.get(entry.field), 10)
            serial.println(*([""] * (1 + entry.empty_line_after)))
