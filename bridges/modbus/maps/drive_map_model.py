"""Model of a Modbus drive's map as it is written. The descriptions are the reference's text."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, SerializerFunctionWrapHandler, model_serializer
from pydantic_core import PydanticCustomError

from bridges.modbus.maps.map_row_models import (
    AS_TUPLE,
    BlockText,
    ByValueText,
    CellText,
    ModeText,
    MovesText,
    PartName,
    PlaceText,
    ProtocolText,
    ReservedText,
    StateRowText,
)
from bridges.modbus.protocol.identification import OBJECT_BYTES_MAX
from bridges.modbus.registers.drive_map import CONTROL, STATUS
from hil.config.explain import StrictModel
from hil.vocab.drive_words import MORE_TAKEN, MORE_TOLD, TAKEN, TOLD

MAP_VERSION = 1
"""Version of the format, ``modbus_map``, of maps with values and bits alone."""
NEW_PARTS = ("cells", "commands", "mode", "states", "blocks", "moves", "reserved", "protocol")
NEW_VALUES = (*MORE_TOLD, *MORE_TAKEN)
"""Keys that version 2 has alone."""
LATEST_VERSION = 2
"""Version with all keys."""
_PARAMETER_NAME = "^[A-Za-z][A-Za-z0-9_]{0,31}$"


def _version(value: int) -> int:
    if value not in (MAP_VERSION, LATEST_VERSION):
        remedy = f"write {MAP_VERSION} or {LATEST_VERSION}, the versions that are known here"
        raise PydanticCustomError("version", "there is no such version of the format", {"remedy": remedy})
    return value


def _ascii(value: str) -> str:
    if not value.isascii() or not value.isprintable() or len(value) > OBJECT_BYTES_MAX:
        remedy = f"write at most {OBJECT_BYTES_MAX} printable characters of ASCII"
        raise PydanticCustomError("ascii", "function 43/14 cannot tell this text", {"remedy": remedy})
    return value


_Text = Annotated[str, AfterValidator(_ascii)]
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

    @model_serializer(mode="wrap")
    def _of_its_version(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Dump without keys of version 2 where the map is of version 1, as a log of it always was."""
        dumped: dict[str, Any] = handler(self)
        if self.modbus_map != MAP_VERSION:
            return dumped
        return {key: each for key, each in dumped.items() if key not in (*NEW_VALUES, *NEW_PARTS)}

    modbus_map: Annotated[int, AfterValidator(_version)] = Field(
        description=f"Version of the format: {MAP_VERSION}, or {LATEST_VERSION} for the keys that say so."
    )
    word_order: Literal["high_first", "low_first"] = Field(
        default="high_first", description="Which word of a value in two registers comes first."
    )
    identity: IdentityText = Field(
        default=IdentityText.model_construct(),
        description="Texts that function 43/14 tells: `vendor`, `product`, `revision`.",
    )
    position_deg: Entry = _entry(f"{TOLD['position_deg']}; needed with `modbus_map: 1`")
    velocity_rpm: Entry = _entry(TOLD["velocity_rpm"])
    current_A: Entry = _entry(TOLD["current_A"])
    fault_code: Entry = _entry(TOLD["fault_code"])
    set_point_deg: Entry = _entry(f"{TAKEN['set_point_deg']}; needed with `modbus_map: 1`")
    set_velocity_rpm: Entry = _entry(TAKEN["set_velocity_rpm"])
    acceleration_rpm_per_s: Entry = _entry(TAKEN["acceleration_rpm_per_s"])
    status: StatusText = Field(
        default=StatusText.model_construct(),
        description="Bits that the drive tells: `enabled`, `moving`, `fault`.",
    )
    control: ControlText | None = Field(
        default=None,
        description="Bits that the drive takes: `enable`, and `start` or `follow` or both, are needed with"
        " `modbus_map: 1`; `stop`, `reset`.",
    )
    parameters: Mapping[Annotated[str, Field(pattern=_PARAMETER_NAME)], PlaceText] = Field(
        default={}, description="Fields of the axis that can be set, by name, as in `pKp`."
    )
    commanded_deg: Entry = _entry(MORE_TOLD["commanded_deg"])
    following_error_deg: Entry = _entry(MORE_TOLD["following_error_deg"])
    turns: Entry = _entry(MORE_TOLD["turns"])
    angle_deg: Entry = _entry(MORE_TOLD["angle_deg"])
    speed_rpm: Entry = _entry(MORE_TOLD["speed_rpm"])
    ordered_rpm: Entry = _entry(MORE_TOLD["ordered_rpm"])
    deceleration_rpm_per_s: Entry = _entry(MORE_TAKEN["deceleration_rpm_per_s"])
    run_velocity_rpm: Entry = _entry(MORE_TAKEN["run_velocity_rpm"])
    homing_method: Entry = _entry(MORE_TAKEN["homing_method"])
    homing_velocity_rpm: Entry = _entry(MORE_TAKEN["homing_velocity_rpm"])
    homing_slow_rpm: Entry = _entry(MORE_TAKEN["homing_slow_rpm"])
    cells: Mapping[PartName, CellText] = Field(
        default={},
        description="Plain cells by name: constants, and what a master keeps there. It needs `modbus_map: 2`,"
        " as all keys below.",
    )
    commands: Mapping[PartName, ByValueText] = Field(
        default={}, description="Registers of which each value is a command, by name."
    )
    mode: ModeText | None = Field(default=None, description="Register whose values choose what `start` does.")
    states: Mapping[PartName, StateRowText] = Field(
        default={}, description="Registers whose value says the state, by name."
    )
    blocks: Mapping[PartName, BlockText] = Field(
        default={},
        description="Blocks that are read or written as a whole, from their first register on; they may"
        " overlap.",
    )
    moves: MovesText | None = Field(default=None, description="Table of moves, one row behind the other.")
    reserved: Annotated[tuple[ReservedText, ...], AS_TUPLE] = Field(
        default=(),
        description="Registers that are nobody's, and answer: they read as zero, and a write does nothing.",
    )
    protocol: ProtocolText = Field(
        default=ProtocolText.model_construct(), description="Manners of the drive on the line."
    )
