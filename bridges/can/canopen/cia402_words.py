"""Statusword, controlword, states and modes of a drive, for both sides of the bus; and its transitions.

Source: CiA 402-2, 6.2: the masks of the states (table 30), the commands (table 28), the transitions 0 to 16;
IEC 61800-7-201:2015, power drive system finite state automaton.
"""

from collections.abc import Mapping
from enum import IntEnum

CONTROLWORD, STATUSWORD, MODE, MODE_DISPLAY, ERROR_CODE = 0x6040, 0x6041, 0x6060, 0x6061, 0x603F
TARGET_POSITION = 0x607A
"""Objects, by their indices."""

VOLTAGE_ENABLED, REMOTE, TARGET_REACHED, LIMIT_ACTIVE = 1 << 4, 1 << 9, 1 << 10, 1 << 11
"""Bits of the statusword."""
SET_POINT_TAKEN = STANDS = HOMING_ATTAINED = FOLLOWS_TARGET = 1 << 12
"""Bit 12: in profile position, profile velocity, homing, and the cyclic modes."""
FOLLOWING_ERROR = HOMING_ERROR = 1 << 13
"""Bit 13: in homing, and in all others."""
NEW_SET_POINT = START_HOMING = INTERPOLATES = 1 << 4
"""Bit 4 of the controlword: in profile position, in homing, and in interpolated position."""
CHANGE_AT_ONCE, RELATIVE, HALT, CHANGE_ON_SET_POINT = 1 << 5, 1 << 6, 1 << 8, 1 << 9
"""Bits of the controlword, all but halt of profile position."""
PROFILE_POSITION, PROFILE_VELOCITY, PROFILE_TORQUE, HOMING = 1, 3, 4, 6
INTERPOLATED_POSITION, CYCLIC_POSITION, CYCLIC_VELOCITY = 7, 8, 9
"""Modes of operation, as written to 6060h."""


def mode_bit(mode: int) -> int:
    """Bit of a mode in 6502h, supported drive modes."""
    return 1 << (mode - 1)


class DriveState(IntEnum):
    """State, by its bits in the statusword: 0 to 3, 5 and 6."""

    NOT_READY = 0x00
    SWITCH_ON_DISABLED = 0x40
    READY = 0x21
    SWITCHED_ON = 0x23
    OPERATION_ENABLED = 0x27
    QUICK_STOP = 0x07
    FAULT_REACTION = 0x0F
    FAULT = 0x08
    UNKNOWN = -1
    """None of these: a statusword outside of the standard."""

    @property
    def about(self) -> str:
        return _ABOUT[self]


_ABOUT = {
    DriveState.NOT_READY: "not ready to switch on",
    DriveState.SWITCH_ON_DISABLED: "switch on disabled",
    DriveState.READY: "ready to switch on",
    DriveState.SWITCHED_ON: "switched on",
    DriveState.OPERATION_ENABLED: "operation enabled",
    DriveState.QUICK_STOP: "quick stop active",
    DriveState.FAULT_REACTION: "fault reaction active",
    DriveState.FAULT: "fault",
    DriveState.UNKNOWN: "unknown",
}
STATE_BITS = 0x6F
_ANY_BIT_5 = (
    *(DriveState.NOT_READY, DriveState.SWITCH_ON_DISABLED, DriveState.FAULT_REACTION, DriveState.FAULT),
)
"""States that bit 5, quick stop, says nothing of."""
_BY_BITS = {int(state): state for state in DriveState} | {state | 0x20: state for state in _ANY_BIT_5}


def state_of(statusword: int) -> DriveState:
    """State that a statusword tells."""
    return _BY_BITS.get(statusword & STATE_BITS, DriveState.UNKNOWN)


def has_fault(statusword: int) -> bool:
    """True if the drive has a fault, or is on its way to that state."""
    return state_of(statusword) in (DriveState.FAULT, DriveState.FAULT_REACTION)


class DriveCommand(IntEnum):
    """Command of a controlword, by the bits that a master sends: 0 to 3, and a rising bit 7."""

    DISABLE_VOLTAGE = 0x00
    QUICK_STOP = 0x02
    SHUTDOWN = 0x06
    SWITCH_ON = 0x07
    ENABLE = 0x0F
    RESET = 0x80


def command_of(word: int) -> DriveCommand:
    """Command that the bits 0 to 3 of a controlword are."""
    if not word & 0x02:
        return DriveCommand.DISABLE_VOLTAGE
    if not word & 0x04:
        return DriveCommand.QUICK_STOP
    if not word & 0x01:
        return DriveCommand.SHUTDOWN
    return DriveCommand.ENABLE if word & 0x08 else DriveCommand.SWITCH_ON


_TOWARDS_ENABLED = {
    DriveState.SWITCH_ON_DISABLED: DriveCommand.SHUTDOWN,
    DriveState.READY: DriveCommand.SWITCH_ON,
    DriveState.SWITCHED_ON: DriveCommand.ENABLE,
    DriveState.QUICK_STOP: DriveCommand.ENABLE,
    DriveState.OPERATION_ENABLED: DriveCommand.ENABLE,
}


def towards_enabled(state: DriveState) -> DriveCommand | None:
    """Controlword of the next step to ``OPERATION_ENABLED``; None: it goes on by itself, or has a fault,
    which is cleared on purpose only."""
    return _TOWARDS_ENABLED.get(state)


TRANSITIONS: Mapping[DriveState, Mapping[DriveCommand, int]] = {
    DriveState.SWITCH_ON_DISABLED: {DriveCommand.SHUTDOWN: 2},
    DriveState.READY: {
        DriveCommand.SWITCH_ON: 3,
        DriveCommand.ENABLE: 3,  # 4 follows at once
        DriveCommand.DISABLE_VOLTAGE: 7,
        DriveCommand.QUICK_STOP: 7,
    },
    DriveState.SWITCHED_ON: {
        DriveCommand.ENABLE: 4,
        DriveCommand.SHUTDOWN: 6,
        DriveCommand.DISABLE_VOLTAGE: 10,
        DriveCommand.QUICK_STOP: 10,
    },
    DriveState.OPERATION_ENABLED: {
        DriveCommand.SWITCH_ON: 5,
        DriveCommand.SHUTDOWN: 8,
        DriveCommand.DISABLE_VOLTAGE: 9,
        DriveCommand.QUICK_STOP: 11,
    },
    DriveState.QUICK_STOP: {DriveCommand.DISABLE_VOLTAGE: 12, DriveCommand.ENABLE: 16},
    DriveState.FAULT: {DriveCommand.RESET: 15},
}
"""Numbers of the transitions that a master asks for."""

LEADS_TO: Mapping[int, DriveState] = {
    1: DriveState.SWITCH_ON_DISABLED,
    2: DriveState.READY,
    3: DriveState.SWITCHED_ON,
    4: DriveState.OPERATION_ENABLED,
    5: DriveState.SWITCHED_ON,
    6: DriveState.READY,
    7: DriveState.SWITCH_ON_DISABLED,
    8: DriveState.READY,
    9: DriveState.SWITCH_ON_DISABLED,
    10: DriveState.SWITCH_ON_DISABLED,
    11: DriveState.QUICK_STOP,
    12: DriveState.SWITCH_ON_DISABLED,
    13: DriveState.FAULT_REACTION,
    14: DriveState.FAULT,
    15: DriveState.SWITCH_ON_DISABLED,
    16: DriveState.OPERATION_ENABLED,
}
"""States in which the transitions end; 1, 13 and 14 are the drive's own, 0 is the power-up."""

UNDER_POWER = frozenset({DriveState.OPERATION_ENABLED, DriveState.QUICK_STOP, DriveState.FAULT_REACTION})
"""States in which the axis may move."""
