"""Numbers of a kind of board, with their units, limits and sources; its versions with their supplies."""

from hil.config.explain import StrictModel
from hil.vocab.parameters import plain


class AxisParameter(StrictModel):
    """Number that describes the motor, its driver or its load."""

    value: float
    full: float | None = None
    """Value of the full plant, where it differs."""
    unit: str
    about: str
    source: str
    minimum: float | None = None
    maximum: float | None = None
    above: float | None = None
    """Exclusive minimum, for a number that cannot be 0."""
    whole: bool = False
    """True if only whole numbers make sense."""

    def default(self, plant: str) -> float:
        """Value under this plant unless a device sets one."""
        return self.value if self.full is None or plant != "full" else self.full

    def refusal(self, value: float) -> tuple[str, str] | None:
        """Reason why the value cannot be used, and remedy; None for a good one."""
        if self.above is not None and value <= self.above:
            return f"{value:g} {self.unit} is too small", f"write more than {plain(self.above)}"
        if self.minimum is not None and value < self.minimum:
            return f"{value:g} {self.unit} is too small", f"write {plain(self.minimum)} or more"
        if self.maximum is not None and value > self.maximum:
            return f"{value:g} {self.unit} is too large", f"write {plain(self.maximum)} or less"
        if self.whole and not float(value).is_integer():
            return f"{value:g} is not a whole number", "write a whole number"
        return None


class HardwareVersion(StrictModel):
    """Version of the board. ``inputs_5V`` are the pins that take 5 V logic; of a board that names none nobody
    knows."""

    supply_min_V: float
    supply_max_V: float
    inputs_5V: list[str]
    outputs_V: float | None = None
    """High level of its outputs; None: it has none, or its processor's supply."""


ANY_SUPPLY = HardwareVersion.model_construct(supply_min_V=0.0, supply_max_V=1000.0, inputs_5V=[])
"""Version of a board whose profile has none."""
