# cython: language_level=3, embedsignature=False
"""The packet codec's binding; device_profiles/sac/packet.py says what it does."""

from cpython.bytes cimport PyBytes_AS_STRING, PyBytes_FromStringAndSize
from libc.stdint cimport int64_t, uint8_t, uint64_t
from libc.string cimport memset

from hil.vocab.framing import BurstItems


cdef extern from "native/packet.h":
    enum:
        PACKET_DATA_MAX
        PACKET_FRAME
        PACKET_GOOD
        PACKET_TO_ALL
    ctypedef struct packet_item:
        int kind
        int len
        uint8_t crc
        uint8_t *raw
    ctypedef struct packet_decoder:
        int state
        int len
        uint8_t *raw
    uint8_t packet_crc8(const uint8_t *data, size_t len)
    bint packet_take(packet_decoder *d, const uint8_t *piece, size_t len, size_t *used, packet_item *item)
    size_t packet_encode(uint8_t *out, uint8_t destination, uint8_t origin, const uint8_t *data, size_t len, int has_crc)

DATA_MAX = PACKET_DATA_MAX
FRAME_BYTES = PACKET_FRAME
FAULTS = ("", "noise", "cut", "address", "no ETX", "too long", "no NUL")


cdef class Packet:
    cdef readonly int destination, origin, crc
    cdef readonly bytes data
    cdef readonly uint64_t end
    cdef readonly int64_t at_ns

    def __init__(self, int destination, int origin, bytes data not None, int crc, uint64_t end):
        self.destination, self.origin, self.data, self.crc, self.end = destination, origin, data, crc, end

    @property
    def is_packet(self):
        return True

    @property
    def fault(self):
        return "" if self.is_good else "CRC"

    @property
    def is_good(self):
        return self.crc == 0 or self.crc == packet_crc8(<const uint8_t *>PyBytes_AS_STRING(self.data), len(self.data))

    @property
    def raw(self):
        cdef bytes crc = bytes((self.crc,)) if self.crc else b""
        return b"\2%c%c%b\3%b\0" % (self.destination, self.origin, self.data, crc)

    def _key(self):
        return (self.destination, self.origin, self.data, self.crc, self.end)

    def __eq__(self, other):
        return isinstance(other, Packet) and self._key() == other._key()

    def __hash__(self):
        return hash(self.data) ^ <Py_hash_t>self.end

    def __repr__(self):
        return "Packet(destination=%r, origin=%r, data=%r, crc=%r, end=%r)" % self._key()


cdef class Malformed:
    cdef readonly str fault
    cdef readonly bytes raw
    cdef readonly uint64_t end
    cdef readonly int64_t at_ns

    def __init__(self, str fault not None, bytes raw not None, uint64_t end):
        self.fault, self.raw, self.end = fault, raw, end

    @property
    def is_packet(self):
        return False

    @property
    def origin(self):
        return None

    def _key(self):
        return (self.fault, self.raw, self.end)

    def __eq__(self, other):
        return isinstance(other, Malformed) and self._key() == other._key()

    def __hash__(self):
        return hash(self._key())

    def __repr__(self):
        return "Malformed(fault=%r, raw=%r, end=%r)" % self._key()


cdef class PacketDecoder:
    cdef packet_decoder state
    cdef uint64_t fed
    cdef int64_t at_ns

    def __cinit__(self):
        memset(&self.state, 0, sizeof(packet_decoder))

    @property
    def pending(self):
        return PyBytes_FromStringAndSize(<char *>self.state.raw, self.state.len)

    @property
    def is_whole(self):
        return self.state.len == 0

    def copy(self):
        cdef PacketDecoder other = PacketDecoder.__new__(PacketDecoder)
        other.state = self.state
        other.fed = self.fed
        return other

    def burst(self, data not None, int64_t start_ns, int baud):
        cdef bint is_whole = self.state.len == 0
        cdef set addresses
        self.at_ns = start_ns
        cdef list items = self.feed(data)
        if not is_whole or self.state.len:
            return BurstItems(items, None)
        addresses = set()
        for item in items:
            if isinstance(item, Packet):
                if (<Packet>item).destination == PACKET_TO_ALL:
                    return BurstItems(items, None, True)
                addresses.add((<Packet>item).destination)
        return BurstItems(items, addresses)

    def characters(self, data not None, times_ns, int baud):
        self.at_ns = times_ns[0] if times_ns else 0
        return BurstItems(self.feed(data), None)

    def silence(self, int64_t now_ns):
        return ()

    def feed(self, data not None):
        cdef const uint8_t[::1] view = data
        cdef size_t left = view.shape[0], used = 0
        cdef const uint8_t *at = &view[0] if left else NULL
        cdef packet_item item
        cdef Packet packet
        cdef Malformed malformed
        cdef list found = []
        while left:
            is_item = packet_take(&self.state, at, left, &used, &item)
            at += used
            left -= used
            self.fed += used
            if not is_item:
                break
            if item.kind == PACKET_GOOD:
                packet = Packet.__new__(Packet)
                packet.destination = item.raw[1]
                packet.origin = item.raw[2]
                packet.data = PyBytes_FromStringAndSize(<char *>item.raw + 3, item.len - PACKET_FRAME + (item.crc == 0))
                packet.crc = item.crc
                packet.end = self.fed
                packet.at_ns = self.at_ns
                found.append(packet)
            else:
                malformed = Malformed.__new__(Malformed)
                malformed.fault = FAULTS[item.kind]
                malformed.raw = PyBytes_FromStringAndSize(<char *>item.raw, item.len)
                malformed.end = self.fed - <uint64_t>self.state.len
                malformed.at_ns = self.at_ns
                found.append(malformed)
        return found


def crc8(data not None):
    cdef const uint8_t[::1] view = data
    return packet_crc8(&view[0] if view.shape[0] else NULL, view.shape[0])


def frame(int destination, int origin, bytes data not None, bint crc):
    cdef Py_ssize_t size = len(data)
    if not 0 <= destination <= 255 or not 0 <= origin <= 255 or size > PACKET_DATA_MAX:
        raise ValueError("addresses are 0 to 255, data at most %d bytes" % PACKET_DATA_MAX)
    out = PyBytes_FromStringAndSize(NULL, size + PACKET_FRAME - (not crc))
    packet_encode(<uint8_t *>PyBytes_AS_STRING(out), destination, origin, <const uint8_t *>PyBytes_AS_STRING(data), size, crc)
    return out
