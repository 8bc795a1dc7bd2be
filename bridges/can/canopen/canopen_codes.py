"""Words of CANopen's codes: NMT, emergencies.

Source: CiA 301, 7.2.7.1 (emergencies), 7.2.8 (NMT); CiA 402-2 for those of drives.
"""

from enum import IntEnum


class NmtState(IntEnum):
    """State of network management, by its number in a heartbeat."""

    INITIALISING = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


class NmtCommand(IntEnum):
    """Command of a master to the network management of nodes."""

    START = 0x01
    STOP = 0x02
    PRE_OPERATIONAL = 0x80
    RESET = 0x81
    RESET_COMMUNICATION = 0x82


NMT_COMMANDS: dict[int, str] = {
    NmtCommand.START: "start",
    NmtCommand.STOP: "stop",
    NmtCommand.PRE_OPERATIONAL: "enter pre-operational",
    NmtCommand.RESET: "reset",
    NmtCommand.RESET_COMMUNICATION: "reset communication",
}
NMT_STATES: dict[int, str] = {
    NmtState.INITIALISING: "boot-up",
    NmtState.STOPPED: "stopped",
    NmtState.OPERATIONAL: "operational",
    NmtState.PRE_OPERATIONAL: "pre-operational",
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
