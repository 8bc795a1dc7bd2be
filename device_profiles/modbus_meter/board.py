"""Profile of the board without a motor."""

from device_profiles.modbus_meter import firmware
from hil.vocab.profile import Profile

PROFILE = Profile(firmware=firmware.ModbusMeter, uarts={}, verbs=firmware.VERBS)
