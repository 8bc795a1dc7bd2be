"""Reasons for which an SDO transfer ends early.

Source: CiA 301 version 4.2.0, 7.2.4.3.17, table 22.
"""

from collections.abc import Mapping
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


ABORTS: Mapping[int, str] = {
    AbortCode.TOGGLE: "the toggle bit did not alternate",
    AbortCode.TIMED_OUT: "it took too long",
    AbortCode.COMMAND: "this command is unknown",
    AbortCode.BLOCK_SIZE: "this block size cannot be",
    AbortCode.SEQUENCE: "this sequence number cannot be",
    AbortCode.CRC: "the CRC is wrong",
    AbortCode.MEMORY: "out of memory",
    AbortCode.ACCESS: "this access is not supported",
    AbortCode.WRITE_ONLY: "it can only be written",
    AbortCode.READ_ONLY: "it can only be read",
    AbortCode.NO_OBJECT: "there is no such object",
    AbortCode.NOT_MAPPABLE: "it cannot be mapped to a PDO",
    AbortCode.PDO_LENGTH: "more is mapped than a PDO can have",
    AbortCode.INCOMPATIBLE: "it does not fit other parameters",
    AbortCode.INCOMPATIBLE_INSIDE: "it does not fit inside the device",
    AbortCode.HARDWARE: "the hardware has failed",
    AbortCode.LENGTH: "the length is wrong",
    AbortCode.TOO_LONG: "it is too long",
    AbortCode.TOO_SHORT: "it is too short",
    AbortCode.NO_SUBINDEX: "there is no such sub-index",
    AbortCode.VALUE: "this value cannot be",
    AbortCode.TOO_HIGH: "the value is too high",
    AbortCode.TOO_LOW: "the value is too low",
    AbortCode.MAXIMUM_BELOW_MINIMUM: "the maximum is below the minimum",
    AbortCode.NO_RESOURCE: "what it needs is not there",
    AbortCode.GENERAL: "an error that has no code",
    AbortCode.NOT_STORED: "it cannot be transferred or kept",
    AbortCode.LOCAL_CONTROL: "it cannot be transferred or kept: the device is controlled locally",
    AbortCode.NOT_NOW: "it cannot be transferred or kept in this state",
    AbortCode.NO_DICTIONARY: "there is no object dictionary",
    AbortCode.NO_DATA: "there is no data",
}
"""Text of an abort code, for captures and errors."""
