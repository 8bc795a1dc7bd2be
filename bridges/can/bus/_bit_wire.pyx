# cython: language_level=3, embedsignature=False, boundscheck=False, wraparound=False
"""The binding of native/can_wire.h; the stub says what it does. In Python a bit of one controller takes about
a microsecond, which is a bit's time."""

from libc.stdint cimport int64_t, uint8_t, uint32_t, uint64_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy

cdef extern from "native/can_wire.h":
    enum:
        CAN_NODES_MAX
        CAN_BITS_MAX
        CAN_NOISES_MAX
        CAN_OFF
        CAN_ABSENT
        CAN_INTEGRATING
        CAN_BUS_OFF
        CAN_FRAME
        CAN_HEARD
    ctypedef struct can_node:
        int state, count, tec, rec, sequences, happened, error, lost
        uint8_t drive, coming, is_sender, is_stuck, is_listening, recovers, is_extended, is_remote
        uint8_t *places
        int next_place, next_size, place, dlc
        uint32_t next_key, id
        uint8_t *data
        int64_t start_ns, rate, origin_ns, half_bits
        uint64_t no_ack_most, no_ack_state
    ctypedef struct can_noise:
        uint64_t most, state
    ctypedef struct can_wire:
        can_node *nodes
        int size, odd, stuck, level, odd_level, noises, happened, sender, is_asleep, leaps
        int64_t rate, origin_ns, bit, busy_bits, decided_ns
        can_noise *noise
    int64_t can_at(const can_wire *w, int64_t bit)
    void can_wake(can_wire *w, int64_t now_ns)
    void can_tick(can_wire *w, int64_t limit_ns)

cdef extern from "native/can_errors.h":
    void can_go_off(can_node *n)

cdef int64_t NEVER_NS = (<int64_t>1 << 62)
cdef int AHEAD_BITS = 2000  # more than anything takes: who does something before has it done again


cdef class Places:
    """Bits to send, two places for each controller; a wire and what looks ahead of it share them."""

    cdef uint8_t *bits

    def __cinit__(self):
        self.bits = <uint8_t *>calloc(CAN_NODES_MAX * 2 * CAN_BITS_MAX, 1)
        if self.bits is NULL:
            raise MemoryError

    def __dealloc__(self):
        free(self.bits)


cdef class BitWire:
    cdef can_wire w
    cdef Places places

    def __cinit__(self, int64_t rate, BitWire other=None, bint leaps=True):
        self.w.nodes = <can_node *>calloc(CAN_NODES_MAX, sizeof(can_node))
        if self.w.nodes is NULL:
            raise MemoryError
        self.places = other.places if other is not None else Places()
        self.w.rate = rate
        self.w.level = self.w.odd_level = self.w.is_asleep = 1
        self.w.leaps = leaps
        self.w.decided_ns = self.w.sender = -1

    def __dealloc__(self):
        free(self.w.nodes)

    # ---- controllers ----

    def add(self, int index, bint is_listening, bint recovers):
        if not 0 <= index < CAN_NODES_MAX:
            raise ValueError(f"a wire has at most {CAN_NODES_MAX} nodes")
        cdef can_node *n = &self.w.nodes[index]
        n.state = CAN_INTEGRATING
        n.count = n.tec = n.rec = n.sequences = n.lost = n.happened = 0
        n.drive = n.coming = 1
        n.is_sender = n.is_stuck = 0
        n.is_listening, n.recovers = is_listening, recovers
        n.places = self.places.bits + index * 2 * CAN_BITS_MAX
        n.next_size = n.no_ack_most = n.rate = 0
        self.w.size = max(self.w.size, index + 1)
        self.w.is_asleep = False

    def remove(self, int index):
        self.set_stuck(index, False)
        self.set_rate(index, 0)
        self.w.nodes[index].state = CAN_ABSENT
        self.w.nodes[index].drive = self.w.nodes[index].coming = 1
        self.w.nodes[index].next_size = self.w.nodes[index].happened = 0

    def take_over(self, BitWire other, int index, bint with_time):
        cdef can_node *n = &self.w.nodes[index]
        n[0] = other.w.nodes[index]
        self.w.size = max(self.w.size, index + 1)
        self.w.odd += n.rate != 0
        self.w.stuck += n.is_stuck
        self.w.is_asleep = False
        n.happened = 0
        # The wire is cut in the middle of its bit, and nothing else happens to it.
        if with_time:
            self.w.origin_ns, self.w.bit = other.w.origin_ns, other.w.bit
            self.w.decided_ns = other.w.decided_ns
            return
        # It comes back as one that starts, and waits for 11 recessive bits; bus-off lasts.
        if n.state != CAN_BUS_OFF:
            n.state, n.is_sender = CAN_INTEGRATING, 0
        n.count = 0
        n.drive = n.coming = 1
        n.origin_ns, n.half_bits = can_at(&self.w, self.w.bit), -1

    def load(self, int index, bytes bits not None, uint32_t key):
        cdef can_node *n = &self.w.nodes[index]
        cdef Py_ssize_t size = len(bits)
        cdef const uint8_t *at = bits
        if size > CAN_BITS_MAX:
            raise ValueError(f"{size} bits are no frame")
        # The frame that is on the wire keeps its bits until its end.
        n.next_place = 1 - n.place if n.state == CAN_FRAME and n.is_sender else 0
        n.next_size = <int>size
        n.next_key = key
        memcpy(self.places.bits + (index * 2 + n.next_place) * CAN_BITS_MAX, at, size)
        return n.next_place

    def unload(self, int index):
        self.w.nodes[index].next_size = 0

    def set_listening(self, int index, bint is_listening):
        self.w.nodes[index].is_listening = is_listening

    def set_recovery(self, int index, bint recovers):
        cdef can_node *n = &self.w.nodes[index]
        if recovers and not n.recovers and n.state == CAN_BUS_OFF:
            n.count = n.sequences = 0
        n.recovers = recovers

    def set_stuck(self, int index, bint is_stuck):
        self.w.stuck += is_stuck - self.w.nodes[index].is_stuck
        self.w.nodes[index].is_stuck = is_stuck

    def set_no_ack(self, int index, limit, uint64_t seed):
        self.w.nodes[index].no_ack_most = limit - 1 if limit else 0
        self.w.nodes[index].no_ack_state = seed

    def set_rate(self, int index, int64_t rate):
        cdef can_node *n = &self.w.nodes[index]
        self.w.odd += (rate != 0) - (n.rate != 0)
        if n.rate:
            n.drive = n.coming  # what it has decided to drive next
        n.coming = n.drive
        n.rate = rate
        n.origin_ns, n.half_bits = can_at(&self.w, self.w.bit), -1

    def set_noise(self, pairs):
        cdef int count = 0
        if len(pairs) > CAN_NOISES_MAX:
            raise ValueError(f"{len(pairs)} noises on one wire; at most {CAN_NOISES_MAX}")
        for limit, state in pairs:
            self.w.noise[count].most = limit - 1
            self.w.noise[count].state = state
            count += 1
        self.w.noises = count

    def noise_states(self):
        return [self.w.noise[i].state for i in range(self.w.noises)]

    def force_bus_off(self, int index):
        cdef can_node *n = &self.w.nodes[index]
        if n.state != CAN_ABSENT:
            n.tec = CAN_OFF
            can_go_off(n)
            n.coming, n.happened = 1, 0

    # ---- what can be seen ----

    def look(self, int index):
        cdef can_node *n = &self.w.nodes[index]
        return n.state, n.tec, n.rec, n.lost

    def sent_slot(self, int index):
        return self.w.nodes[index].place

    @property
    def leaps(self):
        return bool(self.w.leaps)

    @leaps.setter
    def leaps(self, bint leaps):
        self.w.leaps = leaps

    @property
    def is_asleep(self):
        return bool(self.w.is_asleep)

    @property
    def is_held(self):
        return bool(self.w.is_asleep and not self.w.level)

    @property
    def busy_bits(self):
        return self.w.busy_bits

    @property
    def decided_ns(self):
        return self.w.decided_ns

    @property
    def now_ns(self):
        return can_at(&self.w, self.w.bit)

    # ---- time ----

    def wake(self, int64_t now_ns):
        can_wake(&self.w, now_ns)

    def copy(self, BitWire other not None):
        cdef can_node *nodes = self.w.nodes
        self.w = other.w
        self.w.nodes = nodes
        memcpy(nodes, other.w.nodes, other.w.size * sizeof(can_node))
        self.places = other.places

    def advance(self, int64_t until_ns):
        while not self.w.is_asleep and can_at(&self.w, self.w.bit + 1) <= until_ns:
            can_tick(&self.w, until_ns)

    def run(self):
        cdef int i = 0
        while not self.w.is_asleep:
            can_tick(&self.w, NEVER_NS)
            i += 1
            if self.w.happened or i == AHEAD_BITS:
                return can_at(&self.w, self.w.bit)
        return -1

    # ---- what happened in the last bit ----

    @property
    def sender(self):
        return self.w.sender

    def has_heard(self, int index):
        return self.w.nodes[index].happened & CAN_HEARD != 0

    def started_ns(self, int index):
        return self.w.nodes[index].start_ns

    def events(self):
        return [
            (i, self.w.nodes[i].happened, self.w.nodes[i].error)
            for i in range(self.w.size)
            if self.w.nodes[i].happened
        ]

    def heard(self, int index):
        cdef can_node *n = &self.w.nodes[index]
        dlc = min(n.dlc, 8)
        data = b"" if n.is_remote else bytes([n.data[i] for i in range(dlc)])
        return n.id, data, bool(n.is_extended), bool(n.is_remote), dlc if n.is_remote else 0
