"""Needs of a Modbus node of a unit: the registers of one axis, their state; identity, exceptions."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from bridges.modbus.protocol.identification import Identification
from bridges.modbus.protocol.pdu import Code, Refused, Span, Write
from bridges.modbus.registers.cells import Cell, Halves
from bridges.modbus.registers.map_parts import USUAL, Manners
from bridges.modbus.registers.register_map import Wanted
from bridges.modbus.registers.register_unit import VerbStage
from hil.vocab.desk_protocol import AxisLook, DeviceInfo
from hil.vocab.verbs import VerbRefused

EXCEPTIONS = {
    "no_device": Code.GATEWAY_TARGET_FAILED,
    "no_place": Code.ILLEGAL_DATA_ADDRESS,
    "no_verb": Code.ILLEGAL_DATA_ADDRESS,
    "no_parameter": Code.ILLEGAL_DATA_ADDRESS,
    "no_run": Code.ILLEGAL_DATA_ADDRESS,
    "bad_request": Code.ILLEGAL_DATA_VALUE,
    "bad_parameter": Code.ILLEGAL_DATA_VALUE,
    "bad_run": Code.ILLEGAL_DATA_VALUE,
    "bad_config": Code.ILLEGAL_DATA_VALUE,
    "not_now": Code.SERVER_DEVICE_BUSY,
    "busy": Code.SERVER_DEVICE_BUSY,
    "leased": Code.SERVER_DEVICE_BUSY,
    "cannot": Code.SERVER_DEVICE_FAILURE,
    "failed": Code.SERVER_DEVICE_FAILURE,
    "forbidden": Code.ILLEGAL_FUNCTION,
}
"""Exceptions by the codes of refusals. Modbus/TCP Security refuses by role with 01 (R-29)."""


_CAUSES = {"not_now": "busy", "busy": "busy", "leased": "busy", "bad_parameter": "value"}
"""Causes of a drive's own exceptions by the codes of refusals."""


def code_and_reason(error: Refused | VerbRefused, manners: Manners = USUAL) -> tuple[int, str]:
    """Exception of a refusal, and the reason in words. ``manners``: the unit's, which may have codes of its
    own."""
    if isinstance(error, Refused):
        return error.code, str(error)
    if (code := manners.codes.get(_CAUSES.get(error.code, ""))) is not None:
        return code, f"{error.code}: {error}"
    return EXCEPTIONS.get(error.code, Code.SERVER_DEVICE_FAILURE), f"{error.code}: {error}"


class UnitMap(Protocol):
    """Map of a unit, for people and programs: what is where."""

    @property
    def info(self) -> DeviceInfo: ...

    @property
    def cells(self) -> Sequence[Cell]:
        """Registers and bits, in the order of tables and addresses."""

    @property
    def notes(self) -> Sequence[str]:
        """Things that are left out of it, with the reason."""

    @property
    def version(self) -> int:
        """Version of its layout or of its format."""

    @property
    def crc(self) -> int:
        """CRC-32 of the map, which is another when anything in it is."""

    @property
    def identity(self) -> Mapping[str, str]:
        """Texts of what the unit says that it is: vendor, product, revision; those that are not its own are
        left out."""


class Registers(Protocol):
    """Registers of an axis, as ``RegisterUnit``: it answers values, and what a write asks of the
    axis. The owner of the axis carries that out, and tells it the result."""

    @property
    def map(self) -> UnitMap: ...

    @property
    def manners(self) -> Manners:
        """Manners of the unit on its line."""

    @property
    def looks_before_writes(self) -> bool:
        """True if what a write means depends on the state of the axis."""

    def needs_look(self, span: Span) -> bool:
        """True if registers or bits of a span have the present state of the axis."""

    def read(self, span: Span, look: AxisLook | None, halves: Mapping[int, int]) -> Sequence[int]:
        """Read registers or bits. ``look``: the axis now, if ``needs_look``. Raises Refused."""

    def check(self, span: Span) -> None:
        """Check that all of a span is there. Raises Refused."""

    def write(self, write: Write, halves: Halves, look: AxisLook | None = None) -> list[Wanted]:
        """Take registers or coils; answers what is to be done. ``look``: the axis now, if
        ``looks_before_writes``. Raises Refused: nothing was taken."""

    def note(self, wanted: Wanted, stage: VerbStage) -> None:
        """Note how a verb does that a write started."""


def device_identity(of: UnitMap, bench: str, revision: str) -> Identification:
    """Identification of the unit with a map, in a bench. ``revision``: of the program. A map has texts of
    its own instead."""
    info, own = of.info, of.identity
    return Identification(
        vendor_name=own.get("vendor", "hil"),
        product_code=own.get("product", info.profile),
        revision=own.get("revision", revision),
        product_name=f"{'real' if info.is_real else 'simulated'} {info.profile}",
        user_application_name=f"{bench}/{info.name}",
        model_name=f"register map {of.version}, CRC {of.crc:08x}",
    )
