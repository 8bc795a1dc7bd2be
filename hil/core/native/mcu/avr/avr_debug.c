#include "avr_debug.h"

#include <string.h>

enum { LAST = AVR_FLASH_WORDS - 1 };

static void look(avr *m)
{
    avr_debug *d = &m->debug;
    d->is_on = (uint8_t)(d->is_halted || d->is_counting || d->steps);
    m->attention = 0;
}

void avr_halt(avr *m)
{
    m->debug.is_halted = 1;
    m->debug.steps = 0;
    look(m);
}

void avr_go(avr *m, int is_step)
{
    m->debug.is_halted = 0;
    m->is_passing = !m->planned;
    m->is_at_break = 0;
    m->debug.steps = (uint8_t)(!is_step ? 0 : m->planned ? 1 : 2);
    look(m);
}

void avr_jump(avr *m, uint32_t byte)
{
    m->pc = (uint16_t)(byte / 2 & LAST);
    m->planned = m->entered = m->is_at_break = m->is_passing = 0;
    m->attention = 0;
}

void avr_count(avr *m, int n, const uint16_t *starts, int lap_at)
{
    avr_debug *d = &m->debug;
    d->functions = (uint16_t)(n < AVR_FUNCTIONS ? n : AVR_FUNCTIONS);
    memcpy(d->starts, starts, d->functions * sizeof(*starts));
    memset(d->spent, 0, sizeof(d->spent));
    memset(d->calls, 0, sizeof(d->calls));
    d->last = 0;
    d->lap_at = lap_at;
    d->lap_from = d->laps = 0;
    d->since = m->t;
    d->is_counting = n > 0 || lap_at >= 0;
    look(m);
}

int avr_debug_halts(avr *m)
{
    avr_debug *d = &m->debug;
    if (d->steps && --d->steps == 0) d->is_halted = 1;
    if (!d->is_halted) return 0;
    d->steps = 0;
    m->is_stopped = 1;
    m->reached = m->t;
    return 1;
}

/* The function of a word: of the last one that begins at or before it. */
static unsigned function_of(const avr_debug *d, unsigned pc)
{
    unsigned first = 0, end = d->functions;
    while (end - first > 1) {
        unsigned middle = (first + end) / 2;
        if (d->starts[middle] <= pc) first = middle;
        else end = middle;
    }
    return first;
}

void avr_debug_counted(avr *m, unsigned pc, uint64_t began)
{
    avr_debug *d = &m->debug;
    if (d->functions) {
        unsigned at = d->last;
        if (pc < d->starts[at] || (at + 1u < d->functions && pc >= d->starts[at + 1])) d->last = (uint16_t)(at = function_of(d, pc));
        d->spent[at] += m->t - began;
        d->calls[at] += pc == d->starts[at];
    }
    if ((int)pc != d->lap_at) return;
    if (d->lap_from) d->lap[d->laps++ % AVR_LAPS] = (uint32_t)(began - d->lap_from);
    d->lap_from = began;
}
