"""Model of a segment's TMCL modules in a configuration."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from hil.config.explain import StrictModel
from tmcl_bus.frames import HOST, MODULES

TMCL = "tmcl"
"""Key of the modules of a segment, and name of a module behind its axis's."""
_Module = Annotated[int, Field(ge=MODULES.start, le=MODULES.stop - 1)]


class TmclConfig(StrictModel):
    """TMCL modules of a segment: interface cards of axes."""

    modules: Mapping[str, _Module] = Field(
        min_length=1,
        description="Addresses of the modules by axis, as in `{m1: 1, arm.elbow: 3}`. A module is a station"
        " of its own beside the board's UARTs, `m1.tmcl`; an axis has one.",
    )
    host: _Module = Field(default=HOST, description="Address to which they reply; no module has it.")
    response_ms: float = Field(
        default=1.0,
        ge=0,
        le=255,
        description="Time from the last bit of a request to the first one of the reply, in ms.",
    )
