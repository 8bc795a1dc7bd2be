"""Interfaces of a kind of board: numbers of its serial interfaces, its identity on a USB."""

from pydantic import Field

from hil.config.explain import StrictModel

_USB_TEXT = r"^[ -~]{1,60}$"


class UartNumbers(StrictModel):
    """Numbers of a serial interface."""

    baud: int | None = Field(default=None, ge=50, le=4_000_000)
    """Speed, unless a device sets one; None: bytes take no time, as over USB."""
    send_buffer_bytes: int | None = Field(default=None, ge=0, le=1 << 20)
    """Bytes that wait to be sent without holding the main program; None: 64 of the first, none of others,
    which are made in software."""
    receive_buffer_bytes: int | None = Field(default=None, ge=1, le=1 << 20)
    """Bytes that wait for the main program to read them; what comes beyond is lost, an overrun. None: 64, as
    of an Arduino. Of one without a baud all wait: the host is held up, as over USB."""


class UsbDeviceInfo(StrictModel):
    """Identity of a board on the USB. The ids are the real board's, which it must have from their owner."""

    vendor_id: int = Field(ge=1, le=0xFFFF)
    product_id: int = Field(ge=0, le=0xFFFF)
    manufacturer: str = Field(pattern=_USB_TEXT)
    product: str = Field(pattern=_USB_TEXT)
