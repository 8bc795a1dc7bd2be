/* The CPU's clocks and the world's cycles, and when a part does something. */
#ifndef HIL_AVR_TIME_H
#define HIL_AVR_TIME_H

#include "avr_state.h"

static inline uint64_t avr_outer(const avr *m, uint64_t t) { return m->clock_base + ((t - m->clock_from) << m->clock_shift); }

/* The first clock that is not before a cycle. */
static inline uint64_t avr_inner(const avr *m, uint64_t cycle)
{
    if (cycle <= m->clock_base) return m->clock_from;
    return m->clock_from + ((cycle - m->clock_base + (1ull << m->clock_shift) - 1) >> m->clock_shift);
}

/* Clocks of a time of another oscillator, one at least. */
static inline uint64_t avr_clocks(const avr *m, double seconds)
{
    uint64_t clocks = (uint64_t)(seconds * m->hz + 0.5) >> m->clock_shift;
    return clocks ? clocks : 1;
}

/* How far the I/O clock has got at a clock: in most modes of sleep it stands still. */
static inline uint64_t avr_io_clock(const avr *m, uint64_t t) { return m->is_frozen && t > m->frozen ? m->frozen : t; }

static inline void avr_due(avr *m, enum avr_part part, uint64_t t)
{
    m->due[part] = t;
    m->attention = 0;
}

/* CLKPS, from a clock on. */
static inline void avr_set_clock_shift(avr *m, int shift, uint64_t t)
{
    m->clock_base = avr_outer(m, t);
    m->clock_from = t;
    m->clock_shift = (uint8_t)(shift > 8 ? 8 : shift);
    m->attention = 0;
}

/* What a pin's level or its PWM is may be another from now on. */
static inline void avr_mean_changes(avr *m)
{
    if (!m->is_mean_told) return;
    m->is_mean_new = 1;
    m->attention = 0;
}

/* A user is told it once from a reset to the next. */
static inline void avr_note_once(avr *m, enum avr_note note, uint16_t value)
{
    if (m->noted >> note & 1) return;
    m->noted |= (uint8_t)(1 << note);
    m->notes |= (uint8_t)(1 << note);
    m->note_values[note] = value;
    m->attention = 0;
}

#endif
