/* An ATmega328P whose flash has NOPs alone, one clock each: a test writes and reads registers at clocks, as a program would. */
#ifndef HIL_TESTS_AVR_LAB_H
#define HIL_TESTS_AVR_LAB_H

#include "../mcu/avr/atmega328p.h"

#include "../mcu/avr/avr_io.h"
#include "../mcu/avr/avr_registers.h"
#include "check.h"

enum { LAB_MOST = 256, D = 0, B = 8, C = 14 /* numbers of a port's pin 0 */ };

typedef struct avr_lab {
    avr chip;
    int count; /* edges of watched pins: when, which, and what drives it */
    struct { uint64_t cycle; int pin, drive; } edge[LAB_MOST];
    int frames;
    avr_character frame[LAB_MOST];
    int resets, pages, cells;
} avr_lab;

static inline void lab_pin(void *self, int pin, enum avr_drive drive, uint64_t cycle)
{
    avr_lab *l = self;
    if (l->count == LAB_MOST) return;
    l->edge[l->count].cycle = cycle;
    l->edge[l->count].pin = pin;
    l->edge[l->count++].drive = drive;
}

static inline void lab_sent(void *self, const avr_character *c)
{
    avr_lab *l = self;
    if (l->frames < LAB_MOST) l->frame[l->frames++] = *c;
}

static inline void lab_reset(void *self, enum avr_cause cause, uint64_t cycle)
{
    (void)cause, (void)cycle;
    ((avr_lab *)self)->resets++;
}

static inline int lab_page(void *self, uint32_t page_byte, uint64_t cycle)
{
    (void)page_byte, (void)cycle;
    ((avr_lab *)self)->pages++;
    return 0;
}

static inline void lab_stored(void *self, int address, uint64_t cycle)
{
    (void)address, (void)cycle;
    ((avr_lab *)self)->cells++;
}

static inline void lab_open(avr_lab *l)
{
    static const uint8_t nops[AVR_FLASH_BYTES];
    avr_open(&l->chip);
    avr_load_flash(&l->chip, 0, nops, sizeof(nops));
    avr_reset(&l->chip, AVR_POWER_ON, 0);
    avr_watch(&l->chip, ((1u << AVR_PINS) - 1) | AVR_WATCH_NO_FRAMES);
    l->count = l->frames = l->resets = l->pages = l->cells = 0;
}

/* Runs up to a cycle, and by so many. */
static inline void lab_until(avr_lab *l, uint64_t cycle)
{
    avr_world world = {.self = l, .pin = lab_pin, .sent = lab_sent, .reset = lab_reset, .spm = lab_page, .stored = lab_stored};
    avr_run(&l->chip, cycle, &world);
}

static inline void lab_run(avr_lab *l, uint64_t cycles) { lab_until(l, l->chip.cycle + cycles); }

/* What a write and a read do that end now. What begins next is settled after them. */
static inline void put(avr_lab *l, unsigned address, unsigned value)
{
    avr_store(&l->chip, address, (uint8_t)value, l->chip.t);
    l->chip.planned = 0;
}

static inline uint8_t get(avr_lab *l, unsigned address) { return avr_load(&l->chip, address, l->chip.t); }

/* Goes asleep, with interrupts. */
static inline void sleep_in(avr_lab *l, unsigned mode)
{
    put(l, SMCR, mode << 1 | 1);
    l->chip.sreg |= FLAG_I;
    avr_sleep(&l->chip, l->chip.t);
}

/* Cycles from now until bits of a register are as they are to be; `most` at most. */
static inline uint64_t until_bits(avr_lab *l, unsigned address, unsigned bits, unsigned wanted, uint64_t most)
{
    uint64_t from = l->chip.cycle;
    while (l->chip.cycle < from + most && (avr_peek(&l->chip, (uint16_t)address) & bits) != wanted) lab_run(l, 1);
    return l->chip.cycle - from;
}

/* Lets it enter the interrupt that asks, and tells its vector; 0: none. */
static inline unsigned entered(avr_lab *l)
{
    l->chip.pc = 0x1000;
    l->chip.sreg |= FLAG_I;
    lab_run(l, 5);
    l->chip.sreg &= (uint8_t)~FLAG_I;
    return l->chip.pc < 0x1000 ? l->chip.pc / 2 : 0;
}

/* The n-th edge of a pin, from 0; its cycle. drive: what it is to be. UINT64_MAX: there is none. */
static inline uint64_t edge_of(const avr_lab *l, int pin, int n)
{
    for (int i = 0; i < l->count; i++)
        if (l->edge[i].pin == pin && n-- == 0) return l->edge[i].cycle;
    return UINT64_MAX;
}

static inline int drive_of(const avr_lab *l, int pin, int n)
{
    for (int i = 0; i < l->count; i++)
        if (l->edge[i].pin == pin && n-- == 0) return l->edge[i].drive;
    return -1;
}

static inline int edges_of(const avr_lab *l, int pin)
{
    int n = 0;
    for (int i = 0; i < l->count; i++) n += l->edge[i].pin == pin;
    return n;
}

#endif
