# cython: language_level=3, embedsignature=False
"""The CRC of Modbus RTU; its stub says what it is. In Python it takes longer than all else of a frame."""

from libc.stdint cimport uint8_t, uint16_t

cdef uint16_t[256] CRCS


cdef void fill() noexcept:
    cdef uint16_t crc
    cdef int byte, bit
    for byte in range(256):
        crc = byte
        for bit in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
        CRCS[byte] = crc


fill()


def crc16(bytes data not None):
    cdef const uint8_t *at = data
    cdef Py_ssize_t i
    cdef uint16_t crc = 0xFFFF
    for i in range(len(data)):
        crc = crc >> 8 ^ CRCS[(crc ^ at[i]) & 0xFF]
    return crc
