"""Model of what a board's flash starts with."""

from typing import Annotated

from pydantic import AfterValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from hil.config.explain import StrictModel, suggestion
from hil.config.path_values import usable_path

BUILT_IN_TABLES = ("stored", "identity", "empty")
_TABLE_FILE_PATTERN = "[./]"


def _table(value: str) -> str:
    if value in BUILT_IN_TABLES:
        return value
    if "/" not in value and "." not in value:
        raise PydanticCustomError(
            "table",
            "there is no such table",
            {"remedy": suggestion(value, BUILT_IN_TABLES) + "; a file is written with its folder, as in ./x"},
        )
    usable: str = usable_path(value)
    return usable


_Table = Annotated[
    str,
    AfterValidator(_table),
    WithJsonSchema(
        {"anyOf": [{"enum": list(BUILT_IN_TABLES)}, {"type": "string", "pattern": _TABLE_FILE_PATTERN}]}
    ),
]


class FlashConfig(StrictModel):
    """Content of the board's flash when the bench starts for the first time."""

    table: _Table = Field(
        default="stored",
        description="The encoder's look-up table: `stored` is what the last calibration left in the state"
        " directory; `identity` is that of a perfect encoder, angle = count * 360 / 16384; `empty` is a"
        " board that was never calibrated, all zeros; else the path of a file.",
    )
    address: int = Field(
        default=0xB900,
        ge=0,
        le=0x2FF00,
        multiple_of=256,
        description="Where the look-up table is in the board's flash, as the calibration prints it. It"
        " depends on how the firmware was linked.",
    )
