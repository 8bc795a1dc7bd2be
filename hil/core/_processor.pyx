# cython: language_level=3, embedsignature=False, freethreading_compatible=False
"""An ATmega328P alone, without a bench: for tests and tools. ``native/mcu/avr/atmega328p.h`` says what each call
means; the types are in ``_processor.pyi``."""

from libc.stdint cimport uint8_t, uint16_t, uint32_t, uint64_t
from libc.stdlib cimport free, malloc
from libc.string cimport memcpy, memset

cdef extern from "native/mcu/avr/atmega328p.h" nogil:
    enum:
        AVR_PINS
        AVR_CHANNELS
        AVR_FLASH_WORDS
        AVR_EEPROM_BYTES
        AVR_WATCH_NO_FRAMES
    ctypedef int avr_drive "enum avr_drive"
    ctypedef int avr_cause "enum avr_cause"
    ctypedef int avr_note "enum avr_note"
    ctypedef struct avr:
        uint64_t cycle
        uint64_t t
        uint16_t pc
        uint16_t sp
        uint8_t sreg
        uint8_t asleep
        uint8_t data[0x900]
        uint8_t eeprom[1024]
        uint16_t flash[16384]
    ctypedef struct avr_character:
        uint64_t cycle
        uint32_t bit_cycles_256
        uint16_t bits
        uint8_t length
        uint8_t is_broken
        uint8_t framing
    ctypedef struct avr_world:
        void *self
        void (*pin)(void *self, int pin, avr_drive drive, uint64_t cycle) noexcept
        void (*sent)(void *self, const avr_character *character) noexcept
        double (*volts)(void *self, int channel, uint64_t cycle) noexcept
        void (*reset)(void *self, avr_cause cause, uint64_t cycle) noexcept
        void (*note)(void *self, avr_note note, uint32_t value, uint64_t cycle) noexcept
        int (*spm)(void *self, uint32_t page_byte, uint64_t cycle) noexcept
        void (*stored)(void *self, int address, uint64_t cycle) noexcept
    void avr_open(avr *m)
    void avr_clock(avr *m, double hz)
    void avr_crystal_at(avr *m, uint32_t hz, int is_clock)
    void avr_fuses(avr *m, int low, int high, int extended, int lock)
    void avr_load_flash(avr *m, uint32_t byte, const uint8_t *data, uint32_t n)
    void avr_load_eeprom(avr *m, uint32_t byte, const uint8_t *data, uint32_t n)
    void avr_reset(avr *m, int causes, uint64_t start_up)
    uint64_t avr_start_up(const avr *m)
    uint64_t avr_run(avr *m, uint64_t until, const avr_world *world)
    uint64_t avr_next(const avr *m)
    void avr_pin(avr *m, int pin, int level)
    void avr_volts(avr *m, int channel, double volts)
    void avr_supply(avr *m, double vcc_volts, double aref_volts)
    int avr_hear(avr *m, const avr_character *c)
    void avr_retract(avr *m, uint64_t after)
    void avr_watch(avr *m, uint32_t pins)
    void avr_stack_floor(avr *m, uint16_t address)
    void avr_break_at(avr *m, uint32_t byte, int is_on)
    int avr_is_at_break(const avr *m)
    uint16_t avr_stack_lowest(const avr *m)
    int avr_level(const avr *m, int pin)
    avr_drive avr_driven(const avr *m, int pin)
    double avr_duty(const avr *m, int pin)
    int avr_is_sending(const avr *m)
    uint32_t avr_bit_cycles(const avr *m)
    uint8_t avr_peek(const avr *m, uint16_t address)
    void avr_poke(avr *m, uint16_t address, uint8_t value)

WITHOUT_FRAMES = AVR_WATCH_NO_FRAMES
Event = tuple  # _processor.pyi has what is in it


cdef void on_pin(void *self, int pin, avr_drive drive, uint64_t cycle) noexcept:
    cdef Processor p = <Processor>self
    kind = "line" if pin == 1 and avr_is_sending(p.m) else "pin"
    p.events.append((cycle, kind, pin, <int>drive))


cdef void on_sent(void *self, const avr_character *c) noexcept:
    (<Processor>self).events.append((c.cycle, "sent", c.bits, c.length))


cdef void on_reset(void *self, avr_cause cause, uint64_t cycle) noexcept:
    (<Processor>self).events.append((cycle, "reset", <int>cause, 0))


cdef void on_note(void *self, avr_note note, uint32_t value, uint64_t cycle) noexcept:
    (<Processor>self).events.append((cycle, "note", <int>note, value))


cdef int on_spm(void *self, uint32_t page_byte, uint64_t cycle) noexcept:
    (<Processor>self).events.append((cycle, "page", page_byte, 0))
    return 0


cdef void on_stored(void *self, int address, uint64_t cycle) noexcept:
    (<Processor>self).events.append((cycle, "stored", address, 0))


cdef class Processor:
    """A chip, its flash erased; nothing runs before ``reset``."""

    cdef avr *m
    cdef list events

    def __cinit__(self):
        self.m = <avr *>malloc(sizeof(avr))
        if self.m == NULL:
            raise MemoryError
        avr_open(self.m)
        self.events = []

    def __dealloc__(self):
        free(self.m)

    def clock(self, double hz):
        avr_clock(self.m, hz)

    def crystal(self, uint32_t hz, bint is_clock=False):
        avr_crystal_at(self.m, hz, is_clock)

    def fuses(self, int low, int high, int extended, int lock):
        avr_fuses(self.m, low, high, extended, lock)

    def load(self, const uint8_t[::1] flash, uint32_t at=0):
        if len(flash):
            avr_load_flash(self.m, at, &flash[0], <uint32_t>len(flash))

    def load_eeprom(self, const uint8_t[::1] data, uint32_t at=0):
        if len(data):
            avr_load_eeprom(self.m, at, &data[0], <uint32_t>len(data))

    def reset(self, int causes=1, uint64_t start_up=0):
        avr_reset(self.m, causes, start_up)

    def run(self, uint64_t until):
        cdef avr_world world
        memset(&world, 0, sizeof(world))  # what is not named here need not be known
        world.self = <void *>self
        world.pin, world.sent = on_pin, on_sent
        world.reset, world.note, world.spm, world.stored = on_reset, on_note, on_spm, on_stored
        avr_run(self.m, until, &world)
        told, self.events = self.events, []
        return told

    def pin(self, int pin, int level):
        avr_pin(self.m, pin, level)

    def hear(self, uint64_t cycle, uint16_t bits, double bit_cycles, int length=8, bint is_broken=False):
        cdef avr_character c = avr_character(cycle, <uint32_t>(bit_cycles * 256 + 0.5), bits, <uint8_t>length, is_broken, 0)
        return avr_hear(self.m, &c) == 0

    def retract(self, uint64_t after):
        avr_retract(self.m, after)

    def volts(self, int channel, double volts):
        avr_volts(self.m, channel, volts)

    def supply(self, double vcc_volts, double aref_volts):
        avr_supply(self.m, vcc_volts, aref_volts)

    def watch(self, uint32_t pins):
        avr_watch(self.m, pins)

    def stack_floor(self, uint16_t address):
        avr_stack_floor(self.m, address)

    def break_at(self, uint32_t byte, bint is_on=True):
        avr_break_at(self.m, byte, is_on)

    def peek(self, uint16_t address):
        return avr_peek(self.m, address)

    def poke(self, uint16_t address, uint8_t value):
        avr_poke(self.m, address, value)

    def level(self, int pin):
        return avr_level(self.m, pin)

    def driven(self, int pin):
        return <int>avr_driven(self.m, pin)

    def duty(self, int pin):
        return avr_duty(self.m, pin)

    def registers(self):
        m = self.m
        return {"pc": 2 * m.pc, "sp": m.sp, "sreg": m.sreg, "r": bytes(m.data[:32])}

    def set_pc(self, uint16_t byte):
        self.m.pc = byte // 2

    def copy(self):
        return (<uint8_t *>self.m)[:sizeof(avr)]

    def restore(self, const uint8_t[::1] copy):
        if len(copy) != sizeof(avr):
            raise ValueError(f"a copy of a processor has {sizeof(avr)} bytes, not {len(copy)}")
        memcpy(self.m, &copy[0], sizeof(avr))

    @property
    def flash(self):
        return (<uint8_t *>self.m.flash)[: 2 * AVR_FLASH_WORDS]

    @property
    def eeprom(self):
        return (<uint8_t *>self.m.eeprom)[:AVR_EEPROM_BYTES]

    @property
    def cycles(self):
        return self.m.cycle

    @property
    def begins(self):
        return self.m.t

    @property
    def next_cycle(self):
        return avr_next(self.m)

    @property
    def start_up(self):
        return avr_start_up(self.m)

    @property
    def bit_cycles(self):
        return avr_bit_cycles(self.m)

    @property
    def is_at_break(self):
        return avr_is_at_break(self.m) != 0

    @property
    def stack_lowest(self):
        return avr_stack_lowest(self.m)

    @property
    def is_asleep(self):
        return self.m.asleep != 0
