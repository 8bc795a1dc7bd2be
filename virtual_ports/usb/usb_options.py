"""Options of the usb port."""

from pydantic import BaseModel, ConfigDict, Field


class Options(BaseModel):
    """A USB device of this computer, by its kernel's virtual controller (the module vhci-hcd): a /dev/ttyACM
    that every program lists."""

    model_config = ConfigDict(strict=True, extra="forbid")

    serial_number: str | None = Field(
        default=None,
        pattern=r"^[0-9A-Za-z._-]{1,64}$",
        description="Serial number of the device, part of its name in /dev/serial/by-id; null takes the "
        "names of bench and device, as `demo.m1`.",
    )
    path: str | None = Field(
        default=None,
        min_length=1,
        description="Path of a symlink to the /dev/ttyACM, relative to the bench's runtime directory; null "
        "takes the device's name there.",
    )
