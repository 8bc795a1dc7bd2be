"""Words of CANopen's codes: NMT, SDO aborts, emergencies.

Source: CiA 301, 7.2.4.3.17 (aborts), 7.2.7.1 (emergencies), 7.2.8 (NMT); CiA 402-2 for those of drives.
"""

NMT_COMMANDS = {
    0x01: "start",
    0x02: "stop",
    0x80: "enter pre-operational",
    0x81: "reset",
    0x82: "reset communication",
}
NMT_STATES = {0: "boot-up", 4: "stopped", 5: "operational", 127: "pre-operational"}
ABORTS = {
    0x0503_0000: "the toggle bit did not alternate",
    0x0504_0000: "it took too long",
    0x0504_0001: "this command is unknown",
    0x0504_0002: "this block size cannot be",
    0x0504_0003: "this sequence number cannot be",
    0x0504_0004: "the CRC is wrong",
    0x0504_0005: "out of memory",
    0x0601_0000: "this access is not supported",
    0x0601_0001: "it can only be written",
    0x0601_0002: "it can only be read",
    0x0602_0000: "there is no such object",
    0x0604_0041: "it cannot be mapped to a PDO",
    0x0604_0042: "more is mapped than a PDO can have",
    0x0604_0043: "it does not fit other parameters",
    0x0604_0047: "it does not fit inside the device",
    0x0606_0000: "the hardware has failed",
    0x0607_0010: "the length is wrong",
    0x0607_0012: "it is too long",
    0x0607_0013: "it is too short",
    0x0609_0011: "there is no such sub-index",
    0x0609_0030: "this value cannot be",
    0x0609_0031: "the value is too high",
    0x0609_0032: "the value is too low",
    0x0609_0036: "the maximum is below the minimum",
    0x060A_0023: "what it needs is not there",
    0x0800_0000: "an error that has no code",
    0x0800_0020: "it cannot be transferred or kept",
    0x0800_0021: "it cannot be transferred or kept: the device is controlled locally",
    0x0800_0022: "it cannot be transferred or kept in this state",
    0x0800_0023: "there is no object dictionary",
    0x0800_0024: "there is no data",
}
EMERGENCIES = {
    0x0000: "no error any more",
    0x1000: "error",
    0x2000: "current",
    0x2100: "current at the input",
    0x2200: "current in the device",
    0x2300: "current at the output",
    0x2310: "continuous overcurrent",
    0x2320: "short circuit",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3200: "voltage in the device",
    0x3210: "DC link overvoltage",
    0x3220: "DC link undervoltage",
    0x3300: "voltage at the output",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4200: "temperature of the device",
    0x4210: "the device is too hot",
    0x4300: "temperature of the drive",
    0x4310: "the drive is too hot",
    0x5000: "hardware",
    0x5500: "memory",
    0x6000: "software",
    0x6100: "software of the device",
    0x6200: "software of the user",
    0x6300: "data",
    0x7000: "additional modules",
    0x7100: "power",
    0x7121: "the motor is blocked",
    0x7300: "sensor",
    0x7305: "encoder",
    0x7500: "communication of a module",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "CAN overrun, frames were lost",
    0x8120: "error-passive",
    0x8130: "life guarding or heartbeat was lost",
    0x8140: "back from bus-off",
    0x8150: "another node has this identifier",
    0x8200: "protocol",
    0x8210: "a PDO was too short",
    0x8220: "a PDO was too long",
    0x8230: "a multiplexed PDO was not processed",
    0x8240: "a SYNC of a wrong length",
    0x8250: "an RPDO did not come in time",
    0x8400: "velocity control",
    0x8500: "position control",
    0x8600: "positioning",
    0x8611: "following error",
    0x8612: "a reference limit",
    0x9000: "external error",
    0xF000: "additional functions",
    0xFF00: "of the device itself",
}
ERROR_REGISTER = (
    *("generic", "current", "voltage", "temperature", "communication", "profile", "reserved", "manufacturer"),
)
"""Bits of 1001h, from the lowest."""


def emergency_words(code: int) -> str:
    """Say an emergency's code, or what kind of error it is if only that is known."""
    for known in (code, code & 0xFFF0, code & 0xFF00, code & 0xF000):
        if known in EMERGENCIES and (known or not code):
            return EMERGENCIES[known]
    return "an error"
