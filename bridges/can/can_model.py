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


class CanNodeConfig(StrictModel):
    """A CANopen node: the interface card of an axis."""

    id: Annotated[int, Field(ge=1, le=127)] = Field(description="Its node id.")
    switches: SwitchesConfig = Field(
        default=SwitchesConfig.model_construct(),
        description="Switches for homing and limits, a mapping of `home`, `negative` and `positive`; each is"
        " a cam, as in `{from_deg: 10, to_deg: 20}`, or a pin, as in `{pin: D3, active: low}`.",
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
