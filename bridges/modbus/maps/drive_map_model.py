"""Model of a Modbus drive's map as it is written. The descriptions are the reference's text."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from bridges.modbus.protocol.identification import OBJECT_BYTES_MAX
from bridges.modbus.protocol.pdu import ADDRESSES, Table
from bridges.modbus.registers.drive_map import CONTROL, STATUS
from hil.config.explain import OR_NULL, DefaultsModel, StrictModel
from hil.vocab.drive_words import TAKEN, TOLD

MAP_VERSION = 1
"""Version of the format, ``modbus_map``."""
TABLES = {
    "input": Table.INPUT_REGISTERS,
    "holding": Table.HOLDING_REGISTERS,
    "discrete": Table.DISCRETE_INPUTS,
    "coil": Table.COILS,
}
"""Tables by their words in a map."""
_MOST_SCALE = 1e12
_PARAMETER_NAME = "^[A-Za-z][A-Za-z0-9_]{0,31}$"


def _version(value: int) -> int:
    if value != MAP_VERSION:
        remedy = f"write {MAP_VERSION}, the version that is known here"
        raise PydanticCustomError("version", "there is no such version of the format", {"remedy": remedy})
    return value


def _usable_scale(value: float) -> float:
    if not 1 / _MOST_SCALE <= abs(value) <= _MOST_SCALE:
        what = f"a scale of {value:g} fits no value" if value else "with a scale of 0 every value is 0"
        remedy = "write what one step of the register is worth, as in 0.01"
        raise PydanticCustomError("scale", what, {"remedy": remedy})
    return value


def _ascii(value: str) -> str:
    if not value.isascii() or not value.isprintable() or len(value) > OBJECT_BYTES_MAX:
        remedy = f"write at most {OBJECT_BYTES_MAX} printable characters of ASCII"
        raise PydanticCustomError("ascii", "function 43/14 cannot tell this text", {"remedy": remedy})
    return value


_Address = Annotated[int, Field(ge=0, le=ADDRESSES - 1)]
_Text = Annotated[str, AfterValidator(_ascii)]


class PlaceText(DefaultsModel):
    """Entry of a map: one table with an address, and what is there."""

    input: _Address | None = Field(default=None, description="Input register; the first is 0.")
    holding: _Address | None = Field(default=None, description="Holding register instead.")
    discrete: _Address | None = Field(default=None, description="Discrete input instead, of a bit.")
    coil: _Address | None = Field(default=None, description="Coil instead, of a bit.")
    type: Annotated[Literal["u16", "i16", "u32", "i32", "f32"], OR_NULL] = Field(
        default="u16",
        description="Of a value, which takes one register, or two where the type ends in 32.",
    )
    scale: Annotated[float, AfterValidator(_usable_scale), OR_NULL] = Field(
        default=1.0, description="The value is the register's number times this."
    )
    bit: Annotated[int, Field(ge=0, le=15)] | None = Field(
        default=None, description="Number of a bit of a register, 0 for the lowest."
    )

    on_write: Annotated[bool, OR_NULL] = Field(
        default=False,
        description="Of `start`, `stop` and `reset`: true if each write of 1 is a command and the bit clears"
        " itself; false: a command is given when the bit becomes 1.",
    )

    @property
    def tables(self) -> list[str]:
        """Words of the tables that are named."""
        return [word for word in TABLES if getattr(self, word) is not None]


Entry = PlaceText | None


def _entry(about: str) -> Entry:
    entry: Entry = Field(default=None, description=f"{about[0].upper()}{about[1:]}.")
    return entry


class StatusText(StrictModel):
    """Bits that the drive tells."""

    enabled: Entry = _entry(STATUS["enabled"])
    moving: Entry = _entry(STATUS["moving"])
    fault: Entry = _entry(STATUS["fault"])


class ControlText(StrictModel):
    """Bits that the drive takes."""

    enable: Entry = _entry(CONTROL["enable"])
    start: Entry = _entry(CONTROL["start"])
    stop: Entry = _entry(CONTROL["stop"])
    reset: Entry = _entry(CONTROL["reset"])
    follow: Entry = _entry(CONTROL["follow"])


class IdentityText(StrictModel):
    """Texts of what the drive says that it is."""

    vendor: _Text = Field(default="", description="Its maker.")
    product: _Text = Field(default="", description="Its type.")
    revision: _Text = Field(default="", description="Its version, a text.")


class MapText(StrictModel):
    """A whole map."""

    modbus_map: Annotated[int, AfterValidator(_version)] = Field(
        description=f"Version of the format: {MAP_VERSION}."
    )
    word_order: Literal["high_first", "low_first"] = Field(
        default="high_first", description="Which word of a value in two registers comes first."
    )
    identity: IdentityText = Field(
        default=IdentityText.model_construct(),
        description="Texts that function 43/14 tells: `vendor`, `product`, `revision`.",
    )
    position_deg: Entry = _entry(f"{TOLD['position_deg']}; needed")
    velocity_rpm: Entry = _entry(TOLD["velocity_rpm"])
    current_A: Entry = _entry(TOLD["current_A"])
    fault_code: Entry = _entry(TOLD["fault_code"])
    set_point_deg: Entry = _entry(f"{TAKEN['set_point_deg']}; needed")
    set_velocity_rpm: Entry = _entry(TAKEN["set_velocity_rpm"])
    acceleration_rpm_per_s: Entry = _entry(TAKEN["acceleration_rpm_per_s"])
    status: StatusText = Field(
        default=StatusText.model_construct(),
        description="Bits that the drive tells: `enabled`, `moving`, `fault`.",
    )
    control: ControlText | None = Field(
        default=None,
        description="Bits that the drive takes: `enable`, and `start` or `follow` or both, are needed;"
        " `stop`, `reset`.",
    )
    parameters: Mapping[Annotated[str, Field(pattern=_PARAMETER_NAME)], PlaceText] = Field(
        default={}, description="Fields of the axis that can be set, by name, as in `pKp`."
    )
