"""Reasons for which an SDO transfer ends early.

Source: CiA 301 version 4.2.0, 7.2.4.3.17, table 22.
"""

from enum import IntEnum


class AbortCode(IntEnum):
    """Code of an abort, as it is on the bus."""

    TOGGLE = 0x0503_0000
    TIMED_OUT = 0x0504_0000
    COMMAND = 0x0504_0001
    BLOCK_SIZE = 0x0504_0002
    SEQUENCE = 0x0504_0003
    CRC = 0x0504_0004
    MEMORY = 0x0504_0005
    ACCESS = 0x0601_0000
    WRITE_ONLY = 0x0601_0001
    READ_ONLY = 0x0601_0002
    NO_OBJECT = 0x0602_0000
    NOT_MAPPABLE = 0x0604_0041
    PDO_LENGTH = 0x0604_0042
    INCOMPATIBLE = 0x0604_0043
    INCOMPATIBLE_INSIDE = 0x0604_0047
    HARDWARE = 0x0606_0000
    LENGTH = 0x0607_0010
    TOO_LONG = 0x0607_0012
    TOO_SHORT = 0x0607_0013
    NO_SUBINDEX = 0x0609_0011
    VALUE = 0x0609_0030
    TOO_HIGH = 0x0609_0031
    TOO_LOW = 0x0609_0032
    MAXIMUM_BELOW_MINIMUM = 0x0609_0036
    NO_RESOURCE = 0x060A_0023
    GENERAL = 0x0800_0000
    NOT_STORED = 0x0800_0020
    LOCAL_CONTROL = 0x0800_0021
    NOT_NOW = 0x0800_0022
    NO_DICTIONARY = 0x0800_0023
    NO_DATA = 0x0800_0024


ABOUT = {
    AbortCode.TOGGLE: "the toggle bit did not change",
    AbortCode.TIMED_OUT: "the other side was silent for too long",
    AbortCode.COMMAND: "this command does not exist, or not here",
    AbortCode.BLOCK_SIZE: "a block has 1 to 127 segments",
    AbortCode.SEQUENCE: "this is no number of a segment of the block",
    AbortCode.CRC: "the CRC is wrong",
    AbortCode.MEMORY: "the device has no memory for it",
    AbortCode.ACCESS: "the object cannot be accessed so",
    AbortCode.WRITE_ONLY: "the object can only be written",
    AbortCode.READ_ONLY: "the object can only be read",
    AbortCode.NO_OBJECT: "there is no such object",
    AbortCode.NOT_MAPPABLE: "the object cannot be mapped into this PDO",
    AbortCode.PDO_LENGTH: "what is mapped is longer than a PDO",
    AbortCode.INCOMPATIBLE: "the value does not go with another parameter",
    AbortCode.INCOMPATIBLE_INSIDE: "the value does not go with the state of the device",
    AbortCode.HARDWARE: "the hardware has failed",
    AbortCode.LENGTH: "the length is not that of the object",
    AbortCode.TOO_LONG: "the value is too long for the object",
    AbortCode.TOO_SHORT: "the value is too short for the object",
    AbortCode.NO_SUBINDEX: "the object has no such sub-index",
    AbortCode.VALUE: "the object does not take this value",
    AbortCode.TOO_HIGH: "the value is too high",
    AbortCode.TOO_LOW: "the value is too low",
    AbortCode.MAXIMUM_BELOW_MINIMUM: "the maximum is less than the minimum",
    AbortCode.NO_RESOURCE: "there is no SDO connection",
    AbortCode.GENERAL: "it cannot be done",
    AbortCode.NOT_STORED: "the device does not take or store the value",
    AbortCode.LOCAL_CONTROL: "the device is under local control",
    AbortCode.NOT_NOW: "the device does not take the value in its present state",
    AbortCode.NO_DICTIONARY: "there is no object dictionary",
    AbortCode.NO_DATA: "there is no data",
}
"""What a code says, in words."""
