"""Kind of the pins of a board of one's own: those of ``kind.py`` by the board's names for them."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

from hil.core.axis_kind import AxisKind
from hil.core.fields import FIELDS, INDEX, Field
from hil.core.kinds.pin_bank.kind import KIND, VOLTS

DIGITAL_PINS = 20
"""Number of pins of the chip that have a level; behind them are those that its converter alone has."""
FIRST_ANALOG, FIRST_CONVERTER_PIN = 14, 20
"""Numbers of PC0, channel 0 of the converter, and of ADC6."""
_ANALOG, _MEAN = ("A0", "a0_V"), ("D3", "d3_V")
"""A pin, and its field: they stand for all of their kind."""


def channel_of(number: int) -> int | None:
    """Channel of the converter that a pin is, by the chip's number for it; None: it is none."""
    return number - FIRST_ANALOG if number >= FIRST_ANALOG else None


@lru_cache
def named_kind(pins: tuple[tuple[str, int], ...]) -> AxisKind:
    """Kind of pins with names of their own, each with the chip's number for it. Only what they are the
    pins of is there."""
    digital = {name: number for name, number in pins if number < DIGITAL_PINS}
    analog = {name: channel for name, number in pins if (channel := channel_of(number)) is not None}
    usual = {
        name: index for name, index in KIND.fields.items() if FIELDS[name].unit != "V" or name == "vcc_V"
    }
    own = {made.name: (made, index) for name, number in pins for made, index in _fields(name, number)}
    return replace(
        KIND,
        inputs=digital,
        outputs=digital,
        analog=analog,
        means={voltage_field(name): number for name, number in pins if f"d{number}_V" in KIND.means},
        fields=usual | {name: index for name, (_, index) in own.items()},
        own_fields={name: made for name, (made, _) in own.items()},
        settable={"vcc_V": VOLTS, **{voltage_field(name): VOLTS for name in analog}},
    )


def voltage_field(pin: str) -> str:
    """Name of the field of the voltage at a pin."""
    return f"{pin.lower()}_V"


def _fields(pin: str, number: int) -> Iterator[tuple[Field, int]]:
    """Field of the voltage at a pin that has one, and its index in the table."""
    channel = channel_of(number)
    name = f"d{number}_V" if channel is None else f"a{channel}_V"
    if (index := INDEX.get(name)) is not None:
        usual, of = _MEAN if channel is None else _ANALOG
        meaning = FIELDS[of].meaning.replace(f"pin {usual}", f"pin {pin}")
        yield replace(FIELDS[name], name=voltage_field(pin), meaning=meaning), index
