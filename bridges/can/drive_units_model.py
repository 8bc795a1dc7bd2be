"""Keys of a real CANopen drive: what its numbers are, where it does not say so itself."""

from pydantic import Field

from hil.config.explain import StrictModel


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
