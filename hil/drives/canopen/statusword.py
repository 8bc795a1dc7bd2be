"""State machine of a CiA 402 drive: what its statusword says, and which controlword leads on.

Source: CiA 402-2, 6.2: the masks of the states (table 30), the commands (table 28), the transitions 0 to 16.
"""

from enum import StrEnum

TARGET_REACHED, SET_POINT_TAKEN, FOLLOWING_ERROR = 1 << 10, 1 << 12, 1 << 13
REMOTE, LIMIT_ACTIVE, WARNING = 1 << 9, 1 << 11, 1 << 7
SHUTDOWN, SWITCH_ON, ENABLE_OPERATION = 0x06, 0x07, 0x0F
DISABLE_VOLTAGE, QUICK_STOP, FAULT_RESET = 0x00, 0x02, 0x80
NEW_SET_POINT, CHANGE_AT_ONCE, HALT = 1 << 4, 1 << 5, 1 << 8
PROFILE_POSITION, HOMING, CYCLIC_POSITION = 1, 6, 8
"""Modes of operation, as written to 6060h."""


def mode_bit(mode: int) -> int:
    """Bit of a mode in 6502h, supported drive modes."""
    return 1 << (mode - 1)


class MachineState(StrEnum):
    """State of the drive's state machine."""

    NOT_READY = "not ready to switch on"
    SWITCH_ON_DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    FAULT_REACTION = "fault reaction active"
    FAULT = "fault"
    UNKNOWN = "unknown"


_PATTERNS = (
    (0x4F, 0x00, MachineState.NOT_READY),
    (0x4F, 0x40, MachineState.SWITCH_ON_DISABLED),
    (0x6F, 0x21, MachineState.READY),
    (0x6F, 0x23, MachineState.SWITCHED_ON),
    (0x6F, 0x27, MachineState.ENABLED),
    (0x6F, 0x07, MachineState.QUICK_STOP),
    (0x4F, 0x0F, MachineState.FAULT_REACTION),
    (0x4F, 0x08, MachineState.FAULT),
)


def state_of(statusword: int) -> MachineState:
    """State that a statusword tells."""
    return next((state for mask, bits, state in _PATTERNS if statusword & mask == bits), MachineState.UNKNOWN)


_TOWARDS_ENABLED = {
    MachineState.SWITCH_ON_DISABLED: SHUTDOWN,
    MachineState.READY: SWITCH_ON,
    MachineState.SWITCHED_ON: ENABLE_OPERATION,
    MachineState.QUICK_STOP: ENABLE_OPERATION,
    MachineState.ENABLED: ENABLE_OPERATION,
}


def towards_enabled(state: MachineState) -> int | None:
    """Controlword of the next step to ``ENABLED``; None: it goes on by itself, or has a fault, which is
    cleared on purpose only."""
    return _TOWARDS_ENABLED.get(state)


def has_fault(statusword: int) -> bool:
    """True if the drive has a fault, or is on its way to that state."""
    return state_of(statusword) in (MachineState.FAULT, MachineState.FAULT_REACTION)
