"""Identification of a unit, function 43/14: the same at the door and on a line."""

from bridges.modbus.protocol.identification import Identification
from bridges.modbus.registers.registers_protocol import UnitMap


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
