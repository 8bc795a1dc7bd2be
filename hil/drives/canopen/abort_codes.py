"""Words of SDO abort codes. CiA 301 V4.2.0, table 22."""

TOGGLE, NO_COMMAND, GENERAL = 0x0503_0000, 0x0504_0001, 0x0800_0000
NO_OBJECT, NO_SUBINDEX = 0x0602_0000, 0x0609_0011
ABORT_CODES = {
    TOGGLE: "toggle bit not alternated",
    0x0504_0000: "the transfer timed out",
    NO_COMMAND: "unknown command",
    0x0504_0002: "invalid block size",
    0x0504_0003: "invalid sequence number",
    0x0504_0004: "CRC error",
    0x0504_0005: "out of memory",
    0x0601_0000: "unsupported access",
    0x0601_0001: "it can only be written",
    0x0601_0002: "it can only be read",
    NO_OBJECT: "there is no such object",
    0x0604_0041: "it cannot be mapped",
    0x0604_0042: "the PDO would be too long",
    0x0604_0043: "incompatible parameters",
    0x0604_0047: "incompatible inside the device",
    0x0606_0000: "hardware error",
    0x0607_0010: "wrong length",
    0x0607_0012: "too long",
    0x0607_0013: "too short",
    NO_SUBINDEX: "there is no such sub-index",
    0x0609_0030: "invalid value",
    0x0609_0031: "the value is too high",
    0x0609_0032: "the value is too low",
    0x0609_0036: "the maximum is less than the minimum",
    0x060A_0023: "a resource is not there",
    GENERAL: "general error",
    0x0800_0020: "it cannot be stored or used",
    0x0800_0021: "local control keeps it from that",
    0x0800_0022: "not in this state of the device",
    0x0800_0023: "there is no object dictionary",
    0x0800_0024: "there is no data",
}


def abort_words(code: int) -> str:
    """Format a code with its words, as in ``06020000h (there is no such object)``."""
    return f"{code:08X}h ({ABORT_CODES.get(code, 'unknown')})"
