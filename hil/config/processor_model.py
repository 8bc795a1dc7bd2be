"""Model of what is around a board's processor. The descriptions are the reference's text."""

from collections.abc import Mapping

from pydantic import Field

from hil.config.explain import StrictModel
from hil.vocab.address import pin_of

MOST_V = 6.0
"""Absolute maximum of a pin, with VCC at its own. Source: DS40002061, 29.1."""


class FieldVoltage(StrictModel):
    """Voltage that follows a field: ``gain`` times the field, and ``offset_V``; with ``rc_s`` through an RC
    low-pass."""

    of: str = Field(description="A device, or one of its axes, and a field, as in `m1.current_a_A`.")
    gain: float = Field(default=1.0, ge=-1e6, le=1e6, description="Volts for one unit of the field.")
    offset_V: float = Field(
        default=0.0, ge=-MOST_V, le=MOST_V, description="Voltage where the field is 0, in V."
    )

    rc_s: float | None = Field(
        default=None,
        gt=0,
        le=1e6,
        description="Time constant of an RC low-pass between the two, in s; `of` is the mean voltage of a"
        " processor's pin then, as in `u2.d9_V`. null: none.",
    )

    @property
    def source(self) -> tuple[str, str]:
        """Axis and field."""
        return pin_of(self.of)


class DriverPins(StrictModel):
    """Pins at the driver of an RS485 line."""

    de: str = Field(description="The output that enables the driver, as in `D2`; it is high to send.")


Voltages = Mapping[str, float | FieldVoltage]


def measured(voltages: Voltages) -> dict[str, FieldVoltage]:
    """Voltages that follow a field, by their pins."""
    return {pin: each for pin, each in voltages.items() if isinstance(each, FieldVoltage)}
