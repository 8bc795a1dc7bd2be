"""Everything that a configuration may name: profiles with their parameters, kinds of ports and bridges."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, Field, ValidationError

from hil.config.document import Finding
from hil.config.explain import StrictModel, findings_of, suggestion
from hil.config.yaml_text import document_from_yaml
from hil.vocab.axis_plan import AXIS_PARAMETERS, FULL_PARAMETERS, AxisPlan


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
    """Whether only whole numbers make sense."""

    def default(self, plant: str) -> float:
        """Value under this plant unless a device sets one."""
        return self.value if self.full is None or plant != "full" else self.full

    def refusal(self, value: float) -> tuple[str, str] | None:
        """Reason why the value cannot be used, and remedy; None for a good one."""
        if self.above is not None and value <= self.above:
            return f"{value:g} {self.unit} is too small", f"write more than {self.above:g}"
        if self.minimum is not None and value < self.minimum:
            return f"{value:g} {self.unit} is too small", f"write {self.minimum:g} or more"
        if self.maximum is not None and value > self.maximum:
            return f"{value:g} {self.unit} is too large", f"write {self.maximum:g} or less"
        if self.whole and not float(value).is_integer():
            return f"{value:g} is not a whole number", "write a whole number"
        return None


class HardwareVersion(StrictModel):
    """Version of the board. ``inputs_5V`` are the pins that take 5 V logic."""

    supply_min_V: float
    supply_max_V: float
    inputs_5V: list[str]


class ProfileInfo(StrictModel):
    """Kind of board, as its ``profile.yaml`` describes it."""

    name: str = Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")
    title: str
    firmware: str = Field(pattern=r"^[a-z_][a-z0-9_]*:[A-Za-z_][A-Za-z0-9_]*$")
    """Firmware as ``module:class``; the module is in the profile's folder."""
    law: str
    plant: Literal["simple", "full"]
    usb: Literal["native"] | None = None
    """Kind of USB; ``native``: the board's own processor is on the USB, without a UART in between."""
    baud: int | None = None
    """Speed of its UART, unless a device sets one; None: bytes take no time."""
    network_baud: int | None = None
    """Speed of its second UART; None: it has none."""
    greeting: str = ""
    """Text that the line for trying a port sends."""
    ready_after_s: float = 0.0
    """Time from power-up to the board's first answer."""
    hardware: dict[str, HardwareVersion] = Field(min_length=1)
    default_hardware: str
    axis: dict[str, AxisParameter]
    """Parameters by names that end in the unit."""
    registers: dict[str, int]


@dataclass(frozen=True)
class Catalogue:
    """Catalogue of an installation. ``ports`` has the options model of each kind of port."""

    profiles: Mapping[str, ProfileInfo]
    ports: Mapping[str, type[BaseModel]]
    bridges: Mapping[str, type[BaseModel]] = field(default_factory=dict)
    """Options model of each kind of bridge."""
    refused_motors: Callable[[Mapping[str, AxisPlan]], Mapping[str, str]] = lambda plans: {}
    """Motors, by device, that the core would not open, each with the reason: a message, a colon, a remedy."""


def profile_from_yaml(text: str, folder: Path) -> ProfileInfo:
    """Read a ``profile.yaml``; ``folder`` is where it stands, and the last part is the profile's name.

    Raises:
        ConfigError: with every problem of the text.
    """
    document = document_from_yaml(text, str(folder / "profile.yaml"))
    findings = document.findings
    try:
        info = ProfileInfo.model_validate(document.value)
    except ValidationError as error:
        raise document.error(findings + findings_of(error, ProfileInfo, (), document)) from None
    if info.name != folder.name:
        findings.append(Finding(("name",), "this is not its folder's name", f'write "{folder.name}"'))
    if info.default_hardware not in info.hardware:
        remedy = suggestion(info.default_hardware, info.hardware)
        findings.append(Finding(("default_hardware",), "there is no such version", remedy))
    if info.law not in AXIS_PARAMETERS:
        findings.append(
            Finding(("law",), "there is no such control law", suggestion(info.law, AXIS_PARAMETERS))
        )
    findings += [
        Finding(("axis",), f"{name} is missing", "write it with its value, unit, about and source")
        for name in AXIS_PARAMETERS.get(info.law, ()) + FULL_PARAMETERS * (info.plant == "full")
        if name not in info.axis
    ]
    for name, parameter in info.axis.items():
        for key, value in (("value", parameter.value), ("full", parameter.full)):
            if value is not None and (refusal := parameter.refusal(value)):
                findings.append(Finding(("axis", name, key), *refusal))
    if findings:
        raise document.error(findings)
    return info
