"""Model of a field of a board's own. Apart from its checks: most boards have none, and do not wait for it."""

from typing import Literal

from pydantic import Field

from hil.config.explain import StrictModel
from hil.vocab.own_fields import MOST, WHOLE, OwnField


class FieldInfo(StrictModel):
    """Field of a board's own: a relay, a temperature, a counter."""

    about: str
    """Meaning, as in "temperature at the thermocouple"."""
    type: Literal["number", "whole", "switch"] = "number"
    """Type: a number, a whole number, or a switch, which is 0 or 1."""
    unit: str = Field(default="", max_length=16)
    minimum: float | None = Field(default=None, ge=-MOST, le=MOST)
    maximum: float | None = Field(default=None, ge=-MOST, le=MOST)
    value: float = 0.0
    """Value at power-up; of an input, from the bench's start on."""
    input: bool = False
    """True if it is the world around the board, which is set from outside, and not by the firmware."""

    def made(self, name: str, start: float | None = None) -> OwnField:
        """Make the field. ``start``: its first value, where a device has another one."""
        bounds = (0.0, 1.0) if self.type == "switch" else (-MOST, MOST)
        low = bounds[0] if self.minimum is None else self.minimum
        high = bounds[1] if self.maximum is None else self.maximum
        return OwnField(
            name,
            self._type(),
            self.unit,
            self.about,
            low,
            high,
            self.value if start is None else start,
            self.input,
        )

    def _type(self) -> str:
        if self.type == "number":
            return "f64"
        limits = [each for each in (self.minimum, self.maximum) if each is not None]
        return "i32" if all(WHOLE.start <= each < WHOLE.stop for each in limits) else "i64"
