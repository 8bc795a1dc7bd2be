"""EEPROM of the board: the sketch's constants, a line for each that somebody has set."""

from contextlib import suppress

from device_profiles.uno.constants import CONSTANTS, BadConstant, Constants

SECTION = "eeprom"
MEMORY_VERSION = b"step/dir 1"


def packed(constants: Constants) -> bytes:
    """Pack constants for the EEPROM."""
    lines = [f"{name} {constants.value(name)!r}".encode() for name in CONSTANTS]
    return b"\n".join([MEMORY_VERSION, *lines])


def read_constants(data: bytes | None) -> Constants:
    """Read constants; those that are missing, or of another sketch, are the manual's."""
    usual = Constants()
    version, *lines = (data or b"").split(b"\n")
    if version != MEMORY_VERSION:
        return usual
    values = {}
    for line in lines:
        with suppress(ValueError):
            name, value = line.decode("ascii").split(" ")
            values[name] = float(value)
    try:
        return usual.with_values(values)
    except BadConstant:
        return usual
