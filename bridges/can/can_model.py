"""Model of the CAN buses in a configuration. The descriptions are the reference's text."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from hil.config.explain import OR_NULL, DefaultsModel, StrictModel
from hil.config.port_model import Name, PortConfig
from hil.vocab.address import owner_of


class UnitsConfig(StrictModel):
    """Units of a real CANopen drive; what is left out is as the drive says."""

    position_per_turn: float | None = Field(
        default=None,
        gt=0,
        le=1e12,
        description="Its units of position (6064h, 607Ah) of a turn of the shaft; null: as its 60A8h, 6092h"
        " or 608Fh say.",
    )
    velocity_per_rpm: float | None = Field(
        default=None,
        gt=0,
        le=1e12,
        description="Its units of speed (606Ch, 6081h) of one RPM; null: as its 60A9h says, or else units of"
        " position in a second.",
    )
    acceleration_per_rpm_per_s: float | None = Field(
        default=None,
        gt=0,
        le=1e12,
        description="Its units of acceleration (6083h, 6084h) of one RPM in a second; null: as its 60AAh"
        " says, or else units of speed in a second.",
    )


LEAST_BIT_RATE, MOST_BIT_RATE = 10_000, 1_000_000
"""Bits per second."""
_Angle = Annotated[float, Field(ge=-1e9, le=1e9)]


class SwitchConfig(DefaultsModel):
    """A switch of a drive: a cam on the shaft, or a pin of the board."""

    from_deg: _Angle | None = Field(
        default=None, description="The cam's beginning, with `to_deg`, by the angle of the shaft, in degrees."
    )
    to_deg: _Angle | None = Field(default=None, description="The cam's end, beyond `from_deg`.")
    below_deg: _Angle | None = Field(
        default=None, description="A cam from there to the left: the switch is active below this angle."
    )
    above_deg: _Angle | None = Field(
        default=None, description="A cam from there to the right: the switch is active above this angle."
    )
    switch: str | None = Field(
        default=None,
        description="In place of a cam: one of the bench's `switches` at this axis, by its name, with its"
        " hysteresis and bounces; it needs no pin.",
    )
    pin: str | None = Field(
        default=None, description="In place of a cam: an input of the axis at which the switch is, as `D3`."
    )
    active: Annotated[Literal["high", "low"], OR_NULL] = Field(
        default="high", description="Level of the pin at which the switch is active."
    )


class SwitchesConfig(StrictModel):
    """Switches of a drive."""

    home: SwitchConfig | None = Field(default=None, description="The home switch.")
    negative: SwitchConfig | None = Field(
        default=None, description="The limit switch at the end of smaller angles."
    )
    positive: SwitchConfig | None = Field(
        default=None, description="The limit switch at the end of larger angles."
    )


class _OrPath:
    """Mark of a file in place of which a configuration has its path."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"type": "string"}, handler(schema)]}


class _OrValue:
    """Mark of a line in place of which a first value alone may stand."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"type": "number"}, {"type": "string"}, handler(schema)]}


def _line(value: Any) -> Any:
    """Read ``8192`` as ``{value: 8192}``."""
    return {"value": value} if isinstance(value, int | float | str) else value


class EdsFileConfig(StrictModel):
    """A maker's data sheet, with its text: as a log has it."""

    name: str = Field(description="Its path, as the configuration has it.")
    text: str = Field(description="Its text.")


class ObjectLineConfig(StrictModel):
    """A line about an object of a maker's drive: its first value, or what it tells."""

    value: float | str | None = Field(
        default=None, description="First value in place of the file's; `6081h: 8192` is the same in short."
    )
    field: str | None = Field(
        default=None,
        description="Field of the axis that the object tells, as `current_A`; writes do nothing.",
    )
    like: str | None = Field(
        default=None,
        description="In place of a field: an object of CiA 402 that this one is another name of, as `607Ah`,"
        " also where the file has it not.",
    )
    scale: float = Field(
        default=1.0,
        description="Units of the object in one of the field or of the other object, and never none:"
        " `scale: 1000` tells `current_A` in mA.",
    )


class CanNodeConfig(StrictModel):
    """A CANopen node: the interface card of an axis."""

    id: Annotated[int, Field(ge=1, le=127)] = Field(description="Its node id.")
    switches: SwitchesConfig = Field(
        default=SwitchesConfig.model_construct(),
        description="Switches for homing and limits, a mapping of `home`, `negative` and `positive`; each is"
        " a cam, as in `{from_deg: 10, to_deg: 20}`, or a pin, as in `{pin: D3, active: low}`.",
    )
    eds: Annotated[EdsFileConfig, _OrPath()] | None = Field(
        default=None,
        description="A maker's data sheet (EDS or DCF), by its path from the configuration on: the node has"
        " the objects, PDOs and modes of that drive; null: those of hil's own.",
    )
    units: UnitsConfig | None = Field(
        default=None,
        description="With `eds`: units of that drive, where its file does not say them; a turn is one of the"
        " motor.",
    )
    objects: Mapping[str, Annotated[ObjectLineConfig, BeforeValidator(_line), _OrValue()]] = Field(
        default={},
        description="With `eds`: lines about objects, by index and sub-index, as in `6081h` or `607Dh:1`: a"
        " first value in place of the file's, or a mapping of what the object tells.",
    )


class CanTapConfig(StrictModel):
    """An slcan adapter, at which a program outside reaches the bus."""

    port: PortConfig = Field(description="Its port, as a device's `port`.")


class _OrId:
    """Mark of a node in place of which its id alone may stand."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"anyOf": [{"type": "integer", "minimum": 1, "maximum": 127}, handler(schema)]}


def _node(value: Any) -> Any:
    """Read ``5`` as ``{id: 5}``."""
    return {"id": value} if isinstance(value, int) and not isinstance(value, bool) else value


class CanConfig(StrictModel):
    """A CAN bus and what is on it."""

    bit_rate: int = Field(
        default=500_000,
        ge=LEAST_BIT_RATE,
        le=MOST_BIT_RATE,
        description="Bits per second on this bus.",
    )
    nodes: Mapping[str, Annotated[CanNodeConfig, BeforeValidator(_node), _OrId()]] = Field(
        default={},
        description="Axes on this bus as CANopen drives, by axis: the node id, as in `{m1: 5}`, or a mapping"
        " of `id` and `switches`. A node is `m1.canopen`; an axis has one.",
    )
    taps: Mapping[Name, CanTapConfig] = Field(
        default={},
        description="slcan adapters on this bus, by their names: `can0.slcan0`.",
    )
    duplicate_ids: bool = Field(
        default=False, description="Nodes may share an id, to test a master's reaction."
    )

    def members(self) -> tuple[str, ...]:
        """Devices with a node on it."""
        return tuple(dict.fromkeys(owner_of(axis) for axis in self.nodes))
