"""Words of emergency messages (EMCY) of a drive. CiA 301, table 26; CiA 402-2, error codes 603Fh."""

from typing import NamedTuple

_CLASSES = {
    0x10: "generic error",
    0x20: "current",
    0x21: "current on the input side",
    0x22: "current inside the device",
    0x23: "current on the output side",
    0x30: "voltage",
    0x31: "mains voltage",
    0x32: "voltage inside the device",
    0x33: "output voltage",
    0x40: "temperature",
    0x41: "ambient temperature",
    0x42: "temperature of the device",
    0x43: "temperature of the drive",
    0x44: "temperature of the supply",
    0x50: "hardware of the device",
    0x60: "software of the device",
    0x61: "software inside the device",
    0x62: "user's software",
    0x63: "data record",
    0x70: "additional module",
    0x71: "power stage or motor",
    0x73: "sensor",
    0x75: "communication of a module",
    0x80: "monitoring",
    0x81: "communication",
    0x82: "protocol",
    0x83: "torque control",
    0x84: "speed control",
    0x85: "position control",
    0x86: "positioning controller",
    0x90: "external error",
    0xF0: "additional functions",
    0xFF: "specific to the device",
}
_CODES = {
    0x2310: "continuous over-current",
    0x2320: "short circuit or earth leakage on the output side",
    0x3110: "mains over-voltage",
    0x3120: "mains under-voltage",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x4210: "excess temperature of the device",
    0x4310: "excess temperature of the drive",
    0x5441: "emergency stop",
    0x7121: "motor blocked",
    0x7122: "motor error or malfunction of the commutation",
    0x7305: "incremental sensor",
    0x7320: "position sensor",
    0x8110: "CAN overrun, frames were lost",
    0x8120: "CAN controller in error passive",
    0x8130: "heartbeat or life guarding of the master is missing",
    0x8140: "it has recovered from bus-off",
    0x8150: "collision of identifiers",
    0x8210: "a PDO was too short",
    0x8220: "a PDO was too long",
    0x8240: "a SYNC had an unexpected length",
    0x8250: "a PDO did not come in time",
    0x8400: "speed control",
    0x8500: "position control",
    0x8611: "following error",
    0x8612: "reference limit: a limit of the position was passed",
}


def error_words(code: int) -> str:
    """Format an error code of EMCY or 603Fh with its words, as in ``8611h (following error)``."""
    words = _CODES.get(code) or _CLASSES.get(code >> 8) or _CLASSES.get(code >> 8 & 0xF0, "unknown")
    return f"{code:04X}h ({words})"


class Emergency(NamedTuple):
    """Emergency message. ``code`` 0: the errors are over."""

    code: int
    register: int
    manufacturer: bytes

    def __str__(self) -> str:
        own = f", maker's bytes {self.manufacturer.hex(' ')}" if any(self.manufacturer) else ""
        return f"{error_words(self.code)}{own}"


def emergency_of(data: bytes) -> Emergency | None:
    """Read a message; None: it is none."""
    if len(data) != 8:
        return None
    return Emergency(int.from_bytes(data[:2], "little"), data[2], data[3:])
