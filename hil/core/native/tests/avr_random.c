/* An ATmega328P runs what is no program: flash, registers and inputs by chance. Nothing outside of it is touched (the
   sanitizers look), and how a span is cut does not show. */
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "mcu/avr/atmega328p.h"

enum { PROGRAMS = 300, CYCLES = 30000, INPUTS = 40, GUARD = 64 };

static uint32_t seed;

static uint32_t chance(uint32_t below)
{
    seed = seed * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)seed * below >> 32);
}

typedef struct heard_of {
    uint64_t sum; /* of all that came out */
    uint32_t events;
} heard_of;

static void add(void *self, uint64_t cycle, uint64_t what)
{
    heard_of *h = self;
    h->sum = (h->sum ^ cycle) * 0x100000001b3ull;
    h->sum = (h->sum ^ what) * 0x100000001b3ull;
    h->events++;
}

static void on_pin(void *self, int pin, enum avr_drive drive, uint64_t cycle) { add(self, cycle, (uint64_t)(pin * 4 + (int)drive)); }
static void on_sent(void *self, const avr_character *c) { add(self, c->cycle, 1000u + c->bits); }
static double on_volts(void *self, int channel, uint64_t cycle)
{
    add(self, cycle, 3000u + (unsigned)channel);
    return (double)(cycle % 500) / 100;
}
static void on_reset(void *self, enum avr_cause cause, uint64_t cycle) { add(self, cycle, 5000u + cause); }
static void on_note(void *self, enum avr_note note, uint32_t value, uint64_t cycle) { add(self, cycle, 6000u + note * 100000u + value); }
static int on_spm(void *self, uint32_t page_byte, uint64_t cycle)
{
    add(self, cycle, 9000u + page_byte);
    return 0;
}

static void on_stored(void *self, int address, uint64_t cycle) { add(self, cycle, 8000u + (unsigned)address); }

/* Opcodes that reach I/O are more likely than by chance alone. */
static uint16_t word_by_chance(void)
{
    uint16_t d = (uint16_t)chance(32), io = (uint16_t)chance(64);
    switch (chance(12)) {
    case 0: return (uint16_t)(0xb800 | (io & 0x30) << 5 | d << 4 | (io & 15)); /* OUT */
    case 1: return (uint16_t)(0xb000 | (io & 0x30) << 5 | d << 4 | (io & 15)); /* IN */
    case 2: return (uint16_t)(0x9800 | chance(4) << 8 | chance(256));          /* CBI, SBIC, SBI, SBIS */
    case 3: return (uint16_t)(0x9200 | d << 4);                                /* STS; its address is what follows */
    case 4: return (uint16_t)(0x9000 | d << 4);                                /* LDS */
    case 5: return (uint16_t)(0xe000 | chance(4096));                          /* LDI */
    case 6: return (uint16_t)(chance(8) ? 0x9478 : 0x9588);                    /* SEI, SLEEP */
    case 7: return (uint16_t)(chance(2) ? 0x9518 : 0x9508);                    /* RETI, RET */
    case 8: return (uint16_t)(0x20 + chance(0xe0));                            /* an address of I/O */
    default: return (uint16_t)chance(65536);
    }
}

/* LDI and STS: a register of I/O gets a value. */
static int put_store(uint16_t *words, unsigned address, unsigned value)
{
    unsigned d = chance(16);
    words[0] = (uint16_t)(0xe000 | (value & 0xf0) << 4 | d << 4 | (value & 15));
    words[1] = (uint16_t)(0x9300 | d << 4);
    words[2] = (uint16_t)address;
    return 3;
}

/* What takes two steps, and what follows on a step: else chance would hardly ever get there. */
static int put_sequence(uint16_t *words)
{
    static const uint8_t timed[4][3] = {{0x3f, 0x04, 0x06}, {0x60, 0x18, 0x4e}, {0x61, 0x80, 0x01}, {0x55, 0x01, 0x02}}; /* EECR, WDTCSR, CLKPR, MCUCR */
    static const uint8_t steps[8] = {0x84, 0xa4, 0xc4, 0xd4, 0xe4, 0x94, 0xb4, 0x85}; /* of TWCR */
    const uint8_t *sequence = timed[chance(4)];
    int n;
    switch (chance(6)) {
    case 0:
        n = put_store(words, sequence[0], sequence[1]);
        return n + put_store(words + n, sequence[0], sequence[2]);
    case 1:
        n = put_store(words, 0x57, (unsigned)(1 | (chance(2) ? 1u << chance(6) : 0))); /* SPMCSR */
        words[n++] = (uint16_t)(chance(2) ? 0x95e8 : 0x95f8);
        return n;
    case 2: return put_store(words, 0xbc, steps[chance(8)]);
    case 3: return put_store(words, 0xb8 + chance(6), chance(256));
    case 4: return put_store(words, 0x20 + chance(0xe0), chance(256));
    default: return put_store(words, 0x80 + chance(12), chance(256));
    }
}

static void load_by_chance(avr *m)
{
    static uint16_t words[AVR_FLASH_WORDS + 16];
    for (int i = 0; i < AVR_FLASH_WORDS;) {
        if (chance(3) == 0) i += put_sequence(words + i);
        else words[i++] = word_by_chance();
    }
    avr_load_flash(m, 0, (const uint8_t *)words, AVR_FLASH_BYTES); /* this machine is little-endian, as an AVR is */
    avr_fuses(m, 0xff, chance(2) ? 0xde : chance(2) ? 0xd8 : 0xdf, 0xfd, (int)chance(256));
    avr_clock(m, chance(2) ? 16e6 : 1e5); /* the other oscillators are fast then */
    if (chance(2)) avr_crystal_at(m, 32768, chance(4) == 0);
    avr_reset(m, AVR_POWER_ON, chance(2) ? 0 : chance(5000));
    avr_watch(m, chance(2) ? 0xfffff : chance(1u << 21));
    for (uint16_t address = 0; address < 0x100; address++)
        if (chance(3) == 0 && address != 0x61 && address != 0x64) avr_poke(m, address, (uint8_t)chance(256));
}

typedef struct input {
    uint64_t cycle;
    int pin, level;
    avr_character heard;
} input;

static void put_in(avr *m, const input *in)
{
    if (in->pin < AVR_PINS) avr_pin(m, in->pin, in->level);
    else if (in->pin == AVR_PINS) avr_volts(m, in->level & 7, in->level);
    else avr_hear(m, &in->heard);
}

static void run(avr *m, const input *inputs, int cuts, heard_of *h)
{
    const avr_world world = {.self = h, .pin = on_pin, .sent = on_sent, .volts = on_volts, .reset = on_reset,
                             .note = on_note, .spm = on_spm, .stored = on_stored};
    uint64_t end = m->cycle + CYCLES;
    for (int i = 0; i <= INPUTS; i++) {
        uint64_t until = i < INPUTS ? inputs[i].cycle : end;
        for (int k = 0; k < cuts && m->cycle < until; k++) {
            uint64_t cut = m->cycle + (chance(4) ? chance(9) : chance(900));
            avr_run(m, cut < until ? cut : until, &world);
        }
        avr_run(m, until, &world);
        if (i < INPUTS) put_in(m, &inputs[i]);
    }
}

static void inputs_by_chance(input *inputs)
{
    uint64_t at = 0;
    for (int i = 0; i < INPUTS; i++) {
        at += chance(CYCLES / INPUTS);
        inputs[i] = (input){at, (int)chance(AVR_PINS + 4), (int)chance(3) - 1,
                            {at + chance(300), 256 + chance(60000), (uint16_t)chance(1024), (uint8_t)(5 + chance(6)), (uint8_t)chance(2), 0}};
    }
}

static void check_alike(const avr *one, const avr *other, uint32_t program)
{
    int unlike = one->pc != other->pc || one->t != other->t || one->asleep != other->asleep || one->cycle != other->cycle;
    for (unsigned address = 0; address < AVR_DATA_BYTES; address++)
        unlike += avr_peek(one, (uint16_t)address) != avr_peek(other, (uint16_t)address);
    unlike += memcmp(one->eeprom, other->eeprom, sizeof(one->eeprom)) || memcmp(one->flash, other->flash, sizeof(one->flash));
    unlike += memcmp(one->ops, other->ops, sizeof(one->ops)) != 0;
    if (unlike) CHECK_FAILED("program %u: %d differences between whole and cut", program, unlike);
}

/* Guards around it, for what a sanitizer cannot see: the struct is within an array. */
typedef struct guarded {
    uint8_t before[GUARD];
    avr chip;
    uint8_t after[GUARD];
} guarded;

static void cuts_do_not_show(void)
{
    guarded *whole = malloc(sizeof(guarded)), *cut = malloc(sizeof(guarded));
    uint64_t events = 0;
    memset(whole, 0x5a, sizeof(*whole));
    for (uint32_t program = 1; program <= PROGRAMS; program++) {
        input inputs[INPUTS];
        heard_of of_whole = {0, 0}, of_cut = {0, 0};
        seed = program;
        avr_open(&whole->chip);
        load_by_chance(&whole->chip);
        inputs_by_chance(inputs);
        memcpy(cut, whole, sizeof(*cut));
        run(&whole->chip, inputs, 0, &of_whole);
        run(&cut->chip, inputs, 60, &of_cut);
        if (of_whole.sum != of_cut.sum) CHECK_FAILED("program %u: %u and %u events", program, of_whole.events, of_cut.events);
        check_alike(&whole->chip, &cut->chip, program);
        events += of_whole.events;
    }
    for (int i = 0; i < GUARD; i++) CHECK(whole->before[i] == 0x5a && whole->after[i] == 0x5a);
    CHECK(events > PROGRAMS * 10); /* something happens in them */
    free(whole);
    free(cut);
}

void avr_random_tests(void) { RUN(cuts_do_not_show); }
