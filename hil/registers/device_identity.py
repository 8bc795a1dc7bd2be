"""What a unit says that it is, function 43/14: the same at the door and on a line."""

from hil.registers import layout
from hil.registers.register_map import RegisterMap
from hil.wire.modbus.identification import Identification


def device_identity(of: RegisterMap, bench: str, revision: str) -> Identification:
    """Identification of the unit with a map, in a bench. ``revision``: of the program."""
    info = of.info
    return Identification(
        vendor_name="hil",
        product_code=info.profile,
        revision=revision,
        product_name=f"{'real' if info.is_real else 'simulated'} {info.profile}",
        user_application_name=f"{bench}/{info.name}",
        model_name=f"register map {layout.VERSION}, CRC {of.crc:08x}",
    )
