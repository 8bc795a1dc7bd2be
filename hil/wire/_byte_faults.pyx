# cython: language_level=3, embedsignature=False, boundscheck=False
"""The draws of hil/wire/byte_faults.py, which says what they do: one for each bit of a long answer is too
much for Python."""

from cpython.bytes cimport PyBytes_FromStringAndSize
from libc.stdint cimport int64_t, uint8_t, uint64_t
from libc.stdlib cimport free, malloc


cdef inline uint64_t draw(uint64_t *state) noexcept nogil:
    state[0] += <uint64_t>0x9E3779B97F4A7C15
    cdef uint64_t z = state[0]
    z = (z ^ z >> 30) * <uint64_t>0xBF58476D1CE4E5B9
    z = (z ^ z >> 27) * <uint64_t>0x94D049BB133111EB
    return z ^ z >> 31


cdef struct rate:
    bint is_on
    uint64_t most  # of a draw that hits


cdef rate rate_of(limit):
    """Make a rate. ``limit``: how many of the 2**64 draws hit."""
    cdef rate r
    r.is_on = limit > 0
    r.most = limit - 1 if limit else 0
    return r


cdef inline bint hits(rate *r, uint64_t *state) noexcept nogil:
    return draw(state) <= r.most


cdef class Draws:
    cdef uint64_t state
    cdef rate flip, drop, duplicate, delay
    cdef int64_t delay_ns
    cdef readonly uint64_t changed_bytes

    def __init__(self, uint64_t seed, flip, drop, duplicate, delay, int64_t delay_ns):
        self.state = seed
        self.flip, self.drop = rate_of(flip), rate_of(drop)
        self.duplicate, self.delay = rate_of(duplicate), rate_of(delay)
        self.delay_ns = delay_ns

    def apply(self, data not None):
        cdef const uint8_t[::1] view = data
        cdef Py_ssize_t size = view.shape[0], i, filled = 0
        cdef int64_t late_ns = 0
        cdef uint8_t byte, flipped
        cdef int place
        cdef bint is_late
        cdef list pieces = []
        cdef uint8_t *piece = <uint8_t *>malloc(2 * size + 1)
        if piece is NULL:
            raise MemoryError
        try:
            for i in range(size):
                byte = view[i]
                if self.drop.is_on and hits(&self.drop, &self.state):
                    self.changed_bytes += 1
                    continue
                if self.delay.is_on:
                    is_late = hits(&self.delay, &self.state)
                    self.changed_bytes += is_late
                    if filled and is_late != (late_ns > 0):
                        pieces.append((late_ns, PyBytes_FromStringAndSize(<char *>piece, filled)))
                        filled = 0
                    late_ns = self.delay_ns if is_late else 0
                flipped = byte
                if self.flip.is_on:
                    for place in range(8):
                        flipped ^= <uint8_t>(hits(&self.flip, &self.state) << place)
                    self.changed_bytes += flipped != byte
                piece[filled] = flipped
                filled += 1
                if self.duplicate.is_on and hits(&self.duplicate, &self.state):
                    self.changed_bytes += 1
                    piece[filled] = flipped
                    filled += 1
            if filled:
                pieces.append((late_ns, PyBytes_FromStringAndSize(<char *>piece, filled)))
        finally:
            free(piece)
        return pieces
