"""Commands of the sketch: a word and its numbers on a line, each answered by a line."""

import math
from collections.abc import Callable
from typing import NamedTuple

from device_profiles.uno.constants import CONSTANTS, MOST_COUNTS, TICK_US, BadConstant, Constants, counts_of
from device_profiles.uno.stepping import Stepping, Steps
from hil.firmware.arduino import print_float

MOST_STEPS = 2_000_000_000
RATES_Hz = (math.ceil(1e6 / (MOST_COUNTS * TICK_US)), 1_000_000 // TICK_US)
"""Smallest and largest rate that Timer2 counts, in whole steps a second."""
PINS = range(2, 14)


class Refused(Exception):
    """Error of a command that is not carried out: ``str(error)`` says why, and what to write."""


class Command(NamedTuple):
    """Row of the table of commands. ``numbers``: how many words may follow."""

    usage: str
    about: str
    numbers: range
    run: Callable[[Stepping, list[str]], Steps]


def carry_out(board: Stepping, words: list[str]) -> Steps:
    """Carry out a line that is not empty. Each ends what the sketch does by itself."""
    name, *given = words
    left = board.end_by_itself()
    if words == ["stop"] and left:
        board.say(f"stopped, {left} steps left")
        return
    try:
        command = TABLE.get(name)
        if command is None:
            raise Refused(f"there is no {name}; ? lists the commands")
        if len(given) not in command.numbers:
            raise Refused(f"write {command.usage}")
        yield from command.run(board, given)
    except (Refused, BadConstant) as error:
        board.say(f"error: {error}")


def _whole(text: str, low: int, high: int, what: str) -> int:
    digits = text.removeprefix("-").removeprefix("+") if text[:2] not in ("+-", "-+") else ""
    if not digits.isdecimal() or not low <= int(text) <= high:
        raise Refused(f"{what} is a whole number of {low} to {high}, not {text}")
    return int(text)


def _must_stand(board: Stepping) -> None:
    if board.is_moving:
        raise Refused("it moves; stop it, or wait for its end")


def _move(board: Stepping, given: list[str], *, swings: bool = False) -> Steps:
    _must_stand(board)
    steps = _whole(given[0], -MOST_STEPS, MOST_STEPS, "N")
    counts = board.counts
    if len(given) > 1:
        counts = counts_of(math.ceil(1e6 / _whole(given[1], *RATES_Hz, "RATE")))
    if steps == 0:
        raise Refused("0 steps are no move")
    board.begin(steps, counts, swings=swings)
    board.say(f"moving {steps} steps, {counts * TICK_US} us each")
    yield from ()


def _swing(board: Stepping, given: list[str]) -> Steps:
    yield from _move(board, given, swings=True)


def _stop(board: Stepping, given: list[str]) -> Steps:
    board.say(f"stopped, {board.stop()} steps left")
    yield from ()


def _set(board: Stepping, given: list[str]) -> Steps:
    _must_stand(board)
    name, text = given
    try:
        value = float(text)
    except ValueError:
        raise Refused(f"{text} is no number") from None
    yield from board.keep(board.constants.with_values({name: value}))


def _defaults(board: Stepping, given: list[str]) -> Steps:
    _must_stand(board)
    yield from board.keep(Constants())


def _show(board: Stepping, given: list[str]) -> Steps:
    for name, limits in CONSTANTS.items():
        board.say(f"{name} {print_float(board.constants.value(name), 0 if limits.is_whole else 4)}")
    board.print_boot()
    yield from ()


def _pin(board: Stepping, given: list[str]) -> Steps:
    number = _whole(given[0], PINS[0], PINS[-1], "P")
    pin = f"D{number}"
    if len(given) > 1:
        level = _whole(given[1], 0, 1, "a level")
        if pin in (board.step_pin, board.dir_pin):
            _must_stand(board)
        board.pins.write(pin, level)
    board.say(f"pin {number} is {board.pins.read(pin)}")
    yield from ()


def _help(board: Stepping, given: list[str]) -> Steps:
    for command in TABLE.values():
        board.say(f"{command.usage}: {command.about}")
    yield from ()


_COMMANDS = (
    Command("move N [RATE]", "N steps, negative with DIR low, at RATE steps a second", range(1, 3), _move),
    Command("swing N [RATE]", "there and back, a pause of 1 s between, until stop", range(1, 3), _swing),
    Command("stop", "no more steps", range(1), _stop),
    Command("set NAME VALUE", "a constant of the sketch, kept in the EEPROM", range(2, 3), _set),
    Command("show", "the constants, and the lines of boot", range(1), _show),
    Command("defaults", "the constants as they were at first", range(1), _defaults),
    Command("pin P [LEVEL]", "the level of pin 2 to 13; drives it to 0 or 1", range(1, 3), _pin),
    Command("?", "this list", range(1), _help),
)
TABLE = {command.usage.split()[0]: command for command in _COMMANDS}
