"""Options of the Modbus bridge."""

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from hil.net.endpoint import endpoint, is_loopback
from hil.net.listen_option import ADDRESS_SCHEMA, usual_at
from hil.vocab.bridge_protocol import DoorPort, OptionProblem
from hil.vocab.near_words import meant
from hil.wire.address_keys import SERIAL_FORMS, is_serial_address

if TYPE_CHECKING:
    from bridges.modbus.door.certificate_files import CertificateFiles

USUAL_PORT = 1502
"""Port that needs no rights, a thousand above that of Modbus."""
UNITS = range(1, 248)
"""Numbers of units; those above are reserved (MODBUS over Serial Line V1.02, 2.2)."""
UnitNumber = Annotated[int, Field(ge=UNITS[0], le=UNITS[-1])]
RoleName = Literal["viewer", "operator", "admin"]


class Certificates(BaseModel):
    """Certificates of Modbus/TCP Security: clients have to show one."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    certificate: Path = Field(description="This door's, PEM, with those between it and its authority.")
    key: Path = Field(description="Its private key.")
    clients: Path = Field(description="The authority that certificates of clients are from.")
    roles: dict[str, RoleName] = Field(
        default={},
        description=(
            "Roles by common name, before those in the certificates (extension 1.3.6.1.4.1.50316.802.1):"
            " viewer, operator or admin."
        ),
    )

    @property
    def files(self) -> "CertificateFiles":
        from bridges.modbus.door.certificate_files import CertificateFiles

        return CertificateFiles(self.certificate, self.key, self.clients)


class RtuLine(BaseModel):
    """Line of Modbus RTU: a pty, or a real serial port."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    path: str | None = Field(
        default=None,
        min_length=1,
        description="Path of a pty's symlink, relative to the bench's runtime directory.",
    )
    device: str | None = Field(
        default=None, description=f"A serial port instead: {SERIAL_FORMS.removeprefix('write ')}."
    )
    baud: int = Field(
        default=19200, ge=50, le=4_000_000, description="Speed, by which frames are told apart."
    )
    echo: bool | None = Field(
        default=None,
        description="Whether the serial port's adapter echoes what it sends: the echo is dropped; null:"
        " recognised by itself.",
    )
    units: dict[str, UnitNumber] | None = Field(
        default=None,
        min_length=1,
        description="Numbers of the units on this line; null: those of the door.",
    )

    def serial_options(self) -> dict[str, object]:
        """Options of its serial port."""
        return {"url": self.device, "baud": self.baud, "echo": self.echo}

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if (self.path is None) == (self.device is None):
            remedy = "write path: for a pty, device: for a serial port"
            raise PydanticCustomError("line", "a line has either a path or a device", {"remedy": remedy})
        if self.device is not None and not is_serial_address(self.device):
            raise PydanticCustomError(
                "serial_url", "this is no serial port", {"at": ("device",), "remedy": SERIAL_FORMS}
            )
        if self.path is not None and self.echo is not None:
            problem = {"at": ("echo",), "remedy": "leave it out: it is for a `device`"}
            raise PydanticCustomError("echo", "a pty has no adapter that could echo", problem)
        return self


class Options(BaseModel):
    """Options under ``bridges.modbus``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    listen: Annotated[str, usual_at(USUAL_PORT), ADDRESS_SCHEMA] = Field(
        default=f"127.0.0.1:{USUAL_PORT}",
        description=(
            'Address and port to listen at, as in `127.0.0.1:1502` or `"[::1]:1502"`; a port alone is of this'
            " computer, and port 0 any free one. Beyond this computer it needs `tls`, or `insecure: true`."
        ),
    )
    units: dict[str, UnitNumber] | None = Field(
        default=None,
        min_length=1,
        description=(
            "Numbers of units by axis, as in `{m1: 1, arm.elbow: 2}`; null: all axes in the order of the"
            " bench, from 1 on, and boards without a motor that have fields of their own."
        ),
    )
    rtu: list[RtuLine] = Field(default=[], max_length=32, description="Serial lines where it answers, too.")
    word_order: Literal["high_first", "low_first"] = Field(
        default="high_first", description="Order of the registers of a value that takes several."
    )
    tls: Certificates | None = Field(
        default=None, description="Certificates, both ways; without them every client is an operator."
    )
    insecure: bool = Field(
        default=False, description="Let other computers in without `tls`; log and status say so again."
    )

    @model_validator(mode="after")
    def _is_meant(self) -> Self:
        if not (self.insecure or self.tls or is_loopback(endpoint(self.listen)[0])):
            raise PydanticCustomError(
                "reached",
                "{listen} is reached from other computers, and Modbus has no users",
                {
                    "listen": self.listen,
                    "at": ("listen",),
                    "remedy": "listen on 127.0.0.1, add `tls` with certificates, or write `insecure: true`",
                },
            )
        return self

    @property
    def is_open(self) -> bool:
        """True if strangers are let in from other computers."""
        return not self.tls and not is_loopback(endpoint(self.listen)[0])

    def wanted_ports(self) -> Sequence[DoorPort]:
        """Ports of the lines."""
        return [
            DoorPort(f"modbus{at}", "serial", line.serial_options(), ("rtu", at, "device"))
            if line.device
            else DoorPort(f"modbus{at}", "pty", {"path": line.path}, ("rtu", at, "path"))
            for at, line in enumerate(self.rtu)
        ]

    def problems(self, axes: Collection[str]) -> Iterable[OptionProblem]:
        """Units of axes that are not there, and two of one number."""
        of_lines = ((("rtu", at, "units"), line.units) for at, line in enumerate(self.rtu))
        for path, units in ((("units",), self.units), *of_lines):
            taken: dict[int, str] = {}
            for axis, number in (units or {}).items():
                if (other := taken.setdefault(number, axis)) != axis:
                    message = f"unit {number} is {other} and {axis}"
                    yield OptionProblem((*path, axis), message, "give each a number of its own")
                if axis not in axes:
                    message = f"there is no axis {axis!r}"
                    yield OptionProblem((*path, axis), message, meant(axis, axes), at_key=True)

    def file_problems(self) -> Iterable[OptionProblem]:
        """Files of certificates that cannot be used."""
        if self.tls:
            from bridges.modbus.door import certificate_files

            for what, message, remedy in certificate_files.problems(self.tls.files):
                yield OptionProblem(("tls", what), message, remedy)
