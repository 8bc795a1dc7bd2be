"""Transitions of a drive's state machine: which one a command asks for, and where it leads.

Source: IEC 61800-7-201:2015, power drive system finite state automaton; CiA 402-2.
"""

from collections.abc import Mapping

from bridges.can.canopen.cia402_words import DriveCommand, DriveState

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
