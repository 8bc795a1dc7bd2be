# cython: language_level=3, embedsignature=False, boundscheck=False, wraparound=False, cdivision=True
"""A CAN wire and its controllers, bit by bit; the stub says what it does.

In Python a bit of one controller takes a microsecond, which is a bit's time. The names of states and rules are
those of the CAN Specification 2.0 (Bosch, 1991), part B: 3.1 frames, 6 error handling, 7 fault confinement.
"""

from libc.stdint cimport int64_t, uint8_t, uint32_t, uint64_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy

cdef enum:
    MOST_NODES = 256
    MOST_BITS = 160
    MOST_NOISES = 16
    HELD_BITS = 4096  # a wire that is dominant for so long changes nobody's counters any more
    REC_MOST = 255
    PASSIVE_FROM = 128
    BUS_OFF_FROM = 256

cdef enum:  # states of a controller
    OFF, INTEGRATING, BUS_OFF, IDLE, FRAME, FLAG, PASSIVE_FLAG, WAITING, DELIMITER, INTERMISSION, SUSPENDED

cdef enum:  # what happened to a controller in a bit
    SENT = 1
    HEARD = 2
    ERROR = 4
    CHANGED = 8

cdef enum:  # errors
    NONE, BIT_ERROR, STUFF_ERROR, CRC_ERROR, FORM_ERROR, ACK_ERROR

cdef int64_t SECOND_NS = 1000000000


cdef struct controller:
    int state, count, tec, rec, sequences, happened, error, lost
    uint8_t drive, is_sender, is_overload, is_forgiven, is_first
    uint8_t is_listening, recovers, is_stuck, acks, is_bad, is_extended, is_remote
    int slot, next_slot, next_size, sent_bits
    uint32_t next_key
    int place, run, last, tail, crc_at
    uint32_t crc, crc_read, id
    int dlc
    uint8_t data[8]
    int64_t start_ns
    uint64_t no_ack_most, no_ack_state
    int64_t rate, origin_ns, bit  # of one with a clock of its own; else rate is 0
    uint8_t coming


cdef struct noise:
    uint64_t most, state


cdef inline uint64_t draw(uint64_t *state) noexcept nogil:
    """As ``Chance.bits`` of hil/wire/byte_faults.py."""
    state[0] += <uint64_t>0x9E3779B97F4A7C15
    cdef uint64_t z = state[0]
    z = (z ^ z >> 30) * <uint64_t>0xBF58476D1CE4E5B9
    z = (z ^ z >> 27) * <uint64_t>0x94D049BB133111EB
    return z ^ z >> 31


cdef class Frames:
    """Bits to send, two places for each controller; a wire and what looks ahead of it share them."""

    cdef uint8_t *bits

    def __cinit__(self):
        self.bits = <uint8_t *>calloc(MOST_NODES * 2 * MOST_BITS, 1)
        if self.bits is NULL:
            raise MemoryError

    def __dealloc__(self):
        free(self.bits)


cdef class BitWire:
    cdef controller *nodes
    cdef Frames frames
    cdef readonly int size
    cdef int64_t rate, origin_ns, bit
    cdef int odd  # controllers with a clock of their own
    cdef int stuck
    cdef int level, held, odd_level
    cdef int noises
    cdef noise noise_of[MOST_NOISES]
    cdef int happened
    cdef readonly bint is_asleep
    cdef public bint leaps
    cdef readonly int64_t busy_bits, decided_ns
    cdef readonly int sender

    def __cinit__(self, int64_t rate, BitWire other=None, bint leaps=True):
        self.nodes = <controller *>calloc(MOST_NODES, sizeof(controller))
        if self.nodes is NULL:
            raise MemoryError
        self.frames = other.frames if other is not None else Frames()
        self.rate = rate
        self.level = self.odd_level = 1
        self.is_asleep = True
        self.leaps = leaps
        self.decided_ns = -1
        self.sender = -1

    def __dealloc__(self):
        free(self.nodes)

    # ---- controllers ----

    def add(self, int index, bint is_listening, bint recovers):
        if not 0 <= index < MOST_NODES:
            raise ValueError(f"a wire has at most {MOST_NODES} nodes")
        cdef controller *p = &self.nodes[index]
        p.state = INTEGRATING
        p.count = p.tec = p.rec = p.sequences = p.lost = 0
        p.drive = p.coming = 1
        p.is_sender = p.is_stuck = 0
        p.is_listening, p.recovers = is_listening, recovers
        p.next_size = p.no_ack_most = 0
        p.rate = 0
        if index >= self.size:
            self.size = index + 1
        self.is_asleep = False

    def remove(self, int index):
        self.set_stuck(index, False)
        self.set_rate(index, 0)
        self.nodes[index].state = OFF
        self.nodes[index].drive = self.nodes[index].coming = 1
        self.nodes[index].next_size = 0

    def take(self, BitWire other, int index, bint with_time):
        """Take a controller over: in the middle of whatever it does, with the other wire's time; or to wait
        until this wire has been recessive for 11 bits."""
        cdef controller *p = &self.nodes[index]
        p[0] = other.nodes[index]
        self.size = max(self.size, index + 1)
        self.odd += p.rate != 0
        self.stuck += p.is_stuck
        self.is_asleep = False
        if with_time:
            self.origin_ns, self.bit, self.decided_ns = other.origin_ns, other.bit, other.decided_ns
            return
        if p.state != BUS_OFF:
            p.state, p.is_sender = INTEGRATING, 0
        p.count = p.happened = 0
        p.drive = p.coming = 1
        p.origin_ns, p.bit = self.at(self.bit), -1

    def load(self, int index, bytes bits, uint32_t key):
        cdef controller *p = &self.nodes[index]
        cdef Py_ssize_t size = len(bits)
        cdef const uint8_t *at = bits
        if size > MOST_BITS:
            raise ValueError(f"{size} bits are no frame")
        cdef bint is_out = p.state == FRAME and p.is_sender
        p.next_slot = 1 - p.slot if is_out else 0
        p.next_size = size
        p.next_key = key
        memcpy(self.frames.bits + (index * 2 + p.next_slot) * MOST_BITS, at, size)
        return p.next_slot

    def unload(self, int index):
        self.nodes[index].next_size = 0

    def set_listening(self, int index, bint is_listening):
        self.nodes[index].is_listening = is_listening

    def set_recovery(self, int index, bint recovers):
        cdef controller *p = &self.nodes[index]
        if recovers and not p.recovers and p.state == BUS_OFF:
            p.count = p.sequences = 0
            self.is_asleep = False
        p.recovers = recovers

    def set_stuck(self, int index, bint is_stuck):
        self.stuck += is_stuck - self.nodes[index].is_stuck
        self.nodes[index].is_stuck = is_stuck
        self.is_asleep = False

    def set_no_ack(self, int index, limit, uint64_t seed):
        self.nodes[index].no_ack_most = limit - 1 if limit else 0
        self.nodes[index].no_ack_state = seed

    def set_rate(self, int index, int64_t rate):
        cdef controller *p = &self.nodes[index]
        self.odd += (rate != 0) - (p.rate != 0)
        p.rate = rate
        p.origin_ns, p.bit = self.at(self.bit), -1
        p.coming = p.drive
        self.is_asleep = False

    def set_noise(self, pairs):
        """Set all noises: pairs of how many of 2**64 draws hit, and the state to draw from."""
        if len(pairs) > MOST_NOISES:
            raise ValueError(f"{len(pairs)} noises on one wire; at most {MOST_NOISES}")
        self.noises = 0
        for limit, state in pairs:
            if limit:
                self.noise_of[self.noises].most = limit - 1
                self.noise_of[self.noises].state = state
                self.noises += 1

    def noise_states(self):
        return [self.noise_of[i].state for i in range(self.noises)]

    def force_bus_off(self, int index):
        cdef controller *p = &self.nodes[index]
        if p.state != OFF:
            p.tec = BUS_OFF_FROM
            go_off(p)
            p.coming, p.happened = 1, 0
        self.is_asleep = False

    def look(self, int index):
        cdef controller *p = &self.nodes[index]
        return p.state, p.tec, p.rec, p.lost

    def sent_slot(self, int index):
        return self.nodes[index].slot

    def is_sending(self, int index):
        return self.nodes[index].state == FRAME and self.nodes[index].is_sender != 0

    # ---- time ----

    cdef inline int64_t at(self, int64_t bit) noexcept nogil:
        return self.origin_ns + bit * SECOND_NS // self.rate

    @property
    def now_ns(self):
        return self.at(self.bit)

    @property
    def is_held(self):
        """True if the wire is asleep and dominant."""
        return self.is_asleep and self.level == 0

    def wake(self, int64_t now_ns):
        """Go on now, if it sleeps or everybody only waits: the next bit begins at this time."""
        cdef int i, state
        cdef int64_t over_ns, before
        if not self.is_asleep:
            for i in range(self.size):
                state = self.nodes[i].state
                if self.nodes[i].rate and state != OFF:
                    return
                if state == IDLE and self.nodes[i].next_size or INTERMISSION >= state > IDLE:
                    return
        if self.at(self.bit) > now_ns:
            return
        if self.is_asleep and self.level == 0:  # with the phase that it had, for those who are still in step
            over_ns, before = now_ns - self.origin_ns, self.bit
            self.bit = over_ns % SECOND_NS * self.rate // SECOND_NS
            self.origin_ns += over_ns // SECOND_NS * SECOND_NS
            self.busy_bits += over_ns // SECOND_NS * self.rate + self.bit - before
        else:
            self.origin_ns, self.bit = now_ns, 0
        for i in range(self.size):
            if self.nodes[i].rate:
                self.nodes[i].origin_ns, self.nodes[i].bit = now_ns, -1
        self.held = 0
        self.is_asleep = False

    def copy(self, BitWire other):
        memcpy(self.nodes, other.nodes, other.size * sizeof(controller))
        self.size = other.size
        self.frames = other.frames
        self.origin_ns, self.bit = other.origin_ns, other.bit
        self.odd, self.stuck, self.level, self.held = other.odd, other.stuck, other.level, other.held
        self.odd_level = other.odd_level
        self.noises = other.noises
        self.noise_of = other.noise_of
        self.happened, self.sender = other.happened, other.sender
        self.is_asleep, self.leaps = other.is_asleep, other.leaps
        self.busy_bits, self.decided_ns = other.busy_bits, other.decided_ns

    def advance(self, int64_t until_ns):
        """Go on to the last bit that ends by then, or to where it sleeps."""
        while not self.is_asleep and self.at(self.bit + 1) <= until_ns:
            self.tick(until_ns)

    def run(self):
        """Go on to where something happens; answers that time, -1 if it falls asleep before."""
        cdef int64_t most_ns = (<int64_t>1 << 62)
        while not self.is_asleep:
            self.tick(most_ns)
            if self.happened:
                return self.at(self.bit)
        return -1

    # ---- what happened in the last bit ----

    @property
    def is_clean(self):
        """True if all that happened is that one has sent and others have heard it."""
        return self.sender >= 0

    def has_heard(self, int index):
        return self.nodes[index].happened & HEARD != 0

    def started_ns(self, int index):
        return self.nodes[index].start_ns

    def events(self):
        """All that happened, as (controller, what, error)."""
        return [
            (i, self.nodes[i].happened, self.nodes[i].error)
            for i in range(self.size)
            if self.nodes[i].happened
        ]

    def heard(self, int index):
        """The frame that a controller has heard, as the fields of ``CanFrame``."""
        cdef controller *p = &self.nodes[index]
        dlc = min(p.dlc, 8)
        data = b"" if p.is_remote else bytes(p.data[i] for i in range(dlc))
        return p.id, data, bool(p.is_extended), bool(p.is_remote), dlc if p.is_remote else 0

    # ---- a bit ----

    cdef void tick(self, int64_t limit_ns) noexcept:
        cdef int i, level = 1
        cdef bint is_busy = False, begins = False
        cdef controller *p
        cdef int64_t now_ns
        if self.happened:
            self.happened = 0
            self.sender = -1
            for i in range(self.size):
                self.nodes[i].happened = 0
        if self.bit >= self.rate:
            self.origin_ns += self.bit // self.rate * SECOND_NS
            self.bit %= self.rate
        now_ns = self.at(self.bit)
        for i in range(self.size):
            p = &self.nodes[i]
            if p.state == IDLE:
                self.decided_ns = now_ns
                begins = begins or p.next_size and not p.rate
        if begins and self.leaps and self.leap(limit_ns):
            return
        for i in range(self.size):
            p = &self.nodes[i]
            if p.rate:
                is_busy = is_busy or p.state > IDLE and p.state != SUSPENDED
                continue
            if begins and p.state == IDLE and p.next_size:
                self.begin(p, now_ns)
            if p.state > IDLE:
                is_busy = is_busy or p.state != SUSPENDED
                level &= p.drive
        if self.stuck:
            level = 0
        if self.odd:
            level = self.tick_odd(level, now_ns)
        is_busy = is_busy or level == 0
        if is_busy:
            self.busy_bits += 1
            for i in range(self.noises):
                level ^= draw(&self.noise_of[i].state) <= self.noise_of[i].most
        self.level = level
        self.held = 0 if level else self.held + 1
        for i in range(self.size):
            p = &self.nodes[i]
            if p.state and not p.rate:
                self.step(p, level, i, now_ns)
                self.happened |= p.happened
        self.bit += 1
        if self.happened:
            self.note_sender()
        self.doze()

    cdef void note_sender(self) noexcept:
        """Note the sender if one alone has sent, and others have heard it or nothing."""
        cdef int i, sender = -1
        for i in range(self.size):
            if self.nodes[i].happened & (ERROR | CHANGED):
                return
            if self.nodes[i].happened & SENT:
                if sender >= 0:
                    return
                sender = i
        self.sender = sender

    cdef void doze(self) noexcept:
        """Sleep if nothing will happen until somebody does something."""
        cdef int i, state
        if self.held >= HELD_BITS:
            if self.stuck:
                self.is_asleep = True
            return
        if not self.level:
            return
        for i in range(self.size):
            state = self.nodes[i].state
            if state > IDLE or state == INTEGRATING or state == IDLE and self.nodes[i].next_size:
                return
            if state == BUS_OFF and self.nodes[i].recovers:
                return
        if not self.stuck:
            self.is_asleep = True

    cdef bint leap(self, int64_t limit_ns) noexcept:
        """Leap to the end of a frame that nothing disturbs; False if something may."""
        cdef int i, j, best = -1, ackers = 0, size
        cdef bint is_tie = False
        cdef controller *p
        cdef noise noise_of[MOST_NOISES]
        if self.odd or self.stuck:
            return False
        for i in range(self.size):
            p = &self.nodes[i]
            if p.state == OFF or p.state == BUS_OFF and not p.recovers:
                continue
            # At 128 a good frame makes it active again, for a receiver before the frame's end.
            if p.rec >= PASSIVE_FROM or p.tec == PASSIVE_FROM:
                return False
            if p.no_ack_most or p.state != IDLE and p.state != SUSPENDED:
                return False
            ackers += not p.is_listening
            if p.state == IDLE and p.next_size:
                if best < 0 or p.next_key < self.nodes[best].next_key:
                    best, is_tie = i, False
                elif p.next_key == self.nodes[best].next_key:
                    is_tie = True
        size = self.nodes[best].next_size
        if is_tie or ackers < 2 or self.at(self.bit + size) > limit_ns:
            return False
        for j in range(self.noises):
            noise_of[j] = self.noise_of[j]
            for i in range(size):
                if draw(&noise_of[j].state) <= noise_of[j].most:
                    return False
        for j in range(self.noises):
            self.noise_of[j] = noise_of[j]
        for i in range(self.size):
            p = &self.nodes[i]
            if p.state == OFF or p.state == BUS_OFF:
                continue
            p.start_ns = self.decided_ns
            p.drive = 1
            if i == best:
                p.is_sender = 1
                p.slot = p.next_slot
                self.be_sent(p)
            else:
                p.lost += p.state == IDLE and p.next_size != 0
                p.is_sender = 0
                if not p.is_listening:
                    self.be_good(p)
                p.happened = HEARD
                p.state, p.count = INTERMISSION, 0
            self.happened |= p.happened
        self.sender = best
        self.bit += size
        self.busy_bits += size
        self.level, self.held = 1, 0
        return True

    cdef void begin(self, controller *p, int64_t now_ns) noexcept:
        """Begin to send what is loaded."""
        self.start(p, now_ns)
        p.is_sender = 1
        p.slot = p.next_slot
        p.sent_bits = 0
        p.drive = 0

    cdef void start(self, controller *p, int64_t now_ns) noexcept:
        p.state = FRAME
        p.is_sender = p.is_overload = p.is_forgiven = p.is_bad = 0
        p.place = p.run = p.dlc = 0
        p.last = 2
        p.tail = -1
        p.crc = p.crc_read = p.id = 0
        p.is_extended = p.is_remote = 0
        p.crc_at = 19
        p.acks = 0
        p.drive = 1
        p.start_ns = now_ns

    cdef void step(self, controller *p, int level, int index, int64_t now_ns) noexcept:
        """Take the level of a bit; decide what to drive in the next."""
        if p.state == FRAME:
            self.step_frame(p, level, index)
        elif p.state == IDLE:
            if not level:
                self.hear_start(p, index, now_ns)
        elif p.state == INTERMISSION:
            if level:
                p.count += 1
                if p.count == 3:
                    # 3.1.5: an error passive node that has sent waits for eight bits more.
                    p.state = SUSPENDED if p.is_sender and is_passive(p) else IDLE
                    p.count = p.is_sender = 0
            elif p.count < 2:
                be_overloaded(p)
            else:
                if p.is_sender and is_passive(p):
                    p.state = SUSPENDED
                self.hear_start(p, index, now_ns)
        elif p.state == SUSPENDED:
            p.count += 1
            if not level:
                self.hear_start(p, index, now_ns)
            elif p.count == 8:
                p.state = IDLE
        elif p.state == INTEGRATING or p.state == BUS_OFF:
            self.step_outside(p, level)
        else:
            step_error(p, level)

    cdef void hear_start(self, controller *p, int index, int64_t now_ns) noexcept:
        """Take a dominant bit for a start of frame, and join in with what is loaded, 3.1.5."""
        cdef bint joins = p.next_size and p.state != SUSPENDED and not p.is_listening
        self.start(p, now_ns)
        self.parse(p, 0)
        if joins:
            self.decided_ns = now_ns
            p.is_sender = 1
            p.slot = p.next_slot
            p.sent_bits = 1
            p.drive = self.frames.bits[(index * 2 + p.slot) * MOST_BITS + 1]

    cdef void step_outside(self, controller *p, int level) noexcept:
        if p.state == BUS_OFF and not p.recovers:
            return
        p.count = p.count + 1 if level else 0
        if p.count < 11:
            return
        p.count = 0
        if p.state == BUS_OFF:  # 7, rule 12
            p.sequences += 1
            if p.sequences < 128:
                return
            p.tec = p.rec = p.sequences = 0
            p.happened |= CHANGED
        p.state = IDLE

    cdef void step_frame(self, controller *p, int level, int index) noexcept:
        cdef int place = p.place, tail = p.tail
        cdef bint is_stuffing = p.run == 5
        if p.is_sender:
            if level != p.drive and tail != 1:
                if tail >= 0:
                    be_wrong(p, FORM_ERROR)
                    return
                # From the identifier to RTR; in between are the two bits that only extended frames send 1 in.
                if p.drive == 0 or place == 0 or place > (32 if p.is_extended else 13):
                    be_wrong(p, STUFF_ERROR if is_stuffing and p.drive else BIT_ERROR)
                    return
                if is_stuffing:  # 7, rule 3, exception 2
                    p.is_forgiven = 1
                    be_wrong(p, STUFF_ERROR)
                    return
                p.is_sender = 0
                p.lost += 1
            else:
                p.sent_bits += 1
        if tail < 0:
            if not self.parse(p, level):
                be_wrong(p, STUFF_ERROR)
                return
        elif not self.step_tail(p, level):
            return
        if p.is_sender:
            p.drive = self.frames.bits[(index * 2 + p.slot) * MOST_BITS + p.sent_bits] if p.state == FRAME else 1
        else:
            p.drive = 0 if p.tail == 1 and p.acks == 1 and p.state == FRAME else 1

    cdef bint parse(self, controller *p, int level) noexcept:
        """Take a bit of the stuffed part; False if it had to be a stuff bit and is none."""
        cdef int place, i
        if p.run == 5:
            if level == p.last:
                return False
            p.run, p.last = 1, level
        else:
            p.run = p.run + 1 if level == p.last else 1
            p.last = level
            place = p.place
            p.place += 1
            if place < p.crc_at:
                i = level ^ p.crc >> 14 & 1
                p.crc = p.crc << 1 & 0x7FFF
                if i:
                    p.crc ^= 0x4599
                read_field(p, place, level)
            else:
                p.crc_read = p.crc_read << 1 | level
        if p.place == p.crc_at + 15 and p.run != 5:
            p.tail = 0
            p.is_bad = p.crc_read != p.crc
        return True

    cdef bint step_tail(self, controller *p, int level) noexcept:
        """Take a bit behind the CRC; False if the frame is not followed further."""
        cdef int tail = p.tail
        p.tail += 1
        if tail == 0:
            if not level:
                be_wrong(p, FORM_ERROR)
                return False
            p.acks = not p.is_bad and not p.is_listening and not p.is_sender
            if p.acks and p.no_ack_most and draw(&p.no_ack_state) <= p.no_ack_most:
                p.acks = 2  # it takes itself for one that has acknowledged
        elif tail == 1:
            if p.is_sender:
                if level:
                    be_wrong(p, ACK_ERROR)
                    return False
            elif p.acks:
                if p.acks == 1 and level:
                    be_wrong(p, BIT_ERROR)
                    return False
                self.be_good(p)
        elif tail == 9:
            if p.is_sender:
                if not level:
                    be_wrong(p, FORM_ERROR)
                    return False
                self.be_sent(p)
                return False
            p.happened |= HEARD
            if level:
                p.state, p.count = INTERMISSION, 0
            else:
                be_overloaded(p)
            return False
        elif not level:
            be_wrong(p, FORM_ERROR)
            return False
        elif tail == 2 and p.is_bad and not p.is_sender:
            be_wrong(p, CRC_ERROR)
            return False
        return True

    cdef void be_sent(self, controller *p) noexcept:
        cdef bint was_passive = is_passive(p)
        if p.tec:  # 7, rule 7
            p.tec -= 1
        p.happened |= SENT
        p.next_size = 0
        if was_passive != is_passive(p):
            p.happened |= CHANGED
        p.drive = 1
        p.state, p.count = INTERMISSION, 0

    cdef void be_good(self, controller *p) noexcept:
        """7, rule 8; above the limit it goes to a value from 119 to 127."""
        cdef bint was_passive = is_passive(p)
        if p.rec:
            p.rec = 127 if p.rec >= PASSIVE_FROM else p.rec - 1
        if was_passive != is_passive(p):
            p.happened |= CHANGED

    # ---- controllers with a clock of their own ----

    cdef int tick_odd(self, int level, int64_t start_ns) noexcept:
        """Let them have what falls into a bit, with the level that the others drive; answers the level in the
        middle of it."""
        cdef int64_t middle_ns = self.origin_ns + (2 * self.bit + 1) * SECOND_NS // (2 * self.rate)
        self.go_odd(level, start_ns, middle_ns)
        cdef int in_the_middle = self.level_with_odd(level)
        self.go_odd(level, middle_ns, self.at(self.bit + 1))
        return in_the_middle

    cdef int level_with_odd(self, int level) noexcept:
        cdef int i
        for i in range(self.size):
            if self.nodes[i].rate:
                level &= self.nodes[i].drive
        return level

    cdef void go_odd(self, int others, int64_t now_ns, int64_t until_ns) noexcept:
        """Go on to a time. What happens twice a bit of each: it drives, and in the bit's middle it reads."""
        cdef controller *p
        cdef int i, which
        cdef int64_t due_ns, first_ns
        while True:
            self.synchronise(others, now_ns)
            which, first_ns = -1, until_ns
            for i in range(self.size):
                p = &self.nodes[i]
                if p.rate and p.state:
                    due_ns = p.origin_ns + (p.bit + 1) * SECOND_NS // (2 * p.rate)
                    if due_ns < first_ns:
                        which, first_ns = i, due_ns
            if which < 0:
                return
            now_ns = first_ns
            p = &self.nodes[which]
            p.bit += 1
            if p.bit % 2:
                self.step_odd(p, self.level_with_odd(others), which, now_ns)
                continue
            if p.state == IDLE and p.next_size:
                self.begin(p, now_ns)
                p.coming = 0
            p.drive = p.coming

    cdef void step_odd(self, controller *p, int level, int index, int64_t now_ns) noexcept:
        cdef uint8_t driven = p.drive
        self.step(p, level, index, now_ns)
        p.coming, p.drive = p.drive, driven
        if p.state == BUS_OFF:
            p.drive = 1
        self.happened |= p.happened

    cdef void synchronise(self, int others, int64_t now_ns) noexcept:
        """Let those that drive nothing begin a bit where the wire becomes dominant."""
        cdef int i, level = self.level_with_odd(others)
        cdef controller *p
        if self.odd_level == level:
            return
        self.odd_level = level
        if level:
            return
        for i in range(self.size):
            p = &self.nodes[i]
            if p.rate and p.drive and p.state:
                p.origin_ns, p.bit = now_ns, 0
                p.drive = p.coming


cdef inline bint is_passive(controller *p) noexcept:
    return p.tec >= PASSIVE_FROM or p.rec >= PASSIVE_FROM


cdef void go_off(controller *p) noexcept:
    p.state = BUS_OFF
    p.count = p.sequences = p.is_sender = 0
    p.drive = 1
    p.happened |= CHANGED


cdef void count_error(controller *p, int by) noexcept:
    """Count at the sender's counter, or at the receiver's."""
    cdef bint was_passive = is_passive(p)
    if p.is_listening:
        return
    if p.is_sender:
        p.tec += by
        if p.tec >= BUS_OFF_FROM:  # 7, rule 10
            go_off(p)
            return
    else:
        p.rec = min(p.rec + by, REC_MOST)
    if was_passive != is_passive(p):
        p.happened |= CHANGED


cdef void be_wrong(controller *p, int error) noexcept:
    """Find an error, and begin an error flag with the next bit. It is an active one also if this very error
    makes the node passive (7, rule 9)."""
    cdef bint was_passive = is_passive(p)
    p.happened |= ERROR
    p.error = error
    if error == ACK_ERROR and was_passive:
        p.is_forgiven = 1  # 7, rule 3, exception 1: unless it sees a dominant bit in its flag
    elif error == STUFF_ERROR and p.is_forgiven:
        p.is_forgiven = 0
    else:
        p.is_forgiven = 0
        count_error(p, 8 if p.is_sender else 1)
    if p.state == BUS_OFF:
        return
    p.count = p.is_overload = 0
    p.last = 2
    p.is_first = 1
    if was_passive or p.is_listening:
        p.state, p.drive = PASSIVE_FLAG, 1
    else:
        p.state, p.drive = FLAG, 0


cdef void be_overloaded(controller *p) noexcept:
    """Answer a dominant bit where none may be by an overload flag, 3.1.4."""
    p.count = 0
    p.is_overload = 1
    if p.is_listening:
        p.state, p.drive, p.last = PASSIVE_FLAG, 1, 2
    else:
        p.state, p.drive = FLAG, 0


cdef void step_error(controller *p, int level) noexcept:
    """Take a bit of an error or overload frame."""
    if p.state == FLAG:
        if level:  # 7, rules 4 and 5
            p.happened |= ERROR
            p.error = BIT_ERROR
            p.count = 0
            count_error(p, 8)
            return
        p.count += 1
        if p.count == 6:
            p.state, p.drive, p.count = WAITING, 1, 0
            p.is_first = not p.is_overload
    elif p.state == PASSIVE_FLAG:
        p.count = p.count + 1 if level == p.last else 1
        p.last = level
        if not level and p.is_forgiven:
            p.is_forgiven = 0
            count_error(p, 8)
            if p.state == BUS_OFF:
                return
        if p.count == 6:
            p.state, p.count = WAITING, 0
            p.is_first = not p.is_overload
    elif p.state == WAITING:
        if level:
            p.state, p.count = DELIMITER, 1
            return
        p.count += 1
        if p.is_first and not p.is_sender:  # 7, rule 2
            count_error(p, 8)
        p.is_first = 0
        if p.count % 8 == 0:  # 7, rule 6
            count_error(p, 8)
    elif level:  # of a delimiter
        p.count += 1
        if p.count == 8:
            p.state, p.count = INTERMISSION, 0
    elif p.count == 7:
        be_overloaded(p)
    else:
        be_wrong(p, FORM_ERROR)


cdef inline void read_field(controller *p, int place, int level) noexcept:
    """Take a bit before the CRC by its place, from the start of frame, which is 0."""
    cdef int at
    if place == 0:
        return
    if place < 12:
        p.id = p.id << 1 | level
    elif place == 12:
        p.is_remote = level
    elif place == 13:
        p.is_extended = level
        if level:
            p.crc_at = 39
    elif p.is_extended and place < 32:
        p.id = p.id << 1 | level
    elif p.is_extended and place == 32:
        p.is_remote = level
    else:
        at = place - (35 if p.is_extended else 15)
        if at < 0:
            return
        if at < 4:
            p.dlc = p.dlc << 1 | level
            if at == 3 and not p.is_remote:
                p.crc_at += 8 * min(p.dlc, 8)
        else:
            at -= 4
            p.data[at // 8] = <uint8_t>(p.data[at // 8] << 1 | level)
