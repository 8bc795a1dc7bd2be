"""Profile of the drive: as a twin it is hil's closed-loop servo, whose verbs its module uses."""

from device_profiles.canopen_drive.board import PROFILE

__all__ = ["PROFILE"]
