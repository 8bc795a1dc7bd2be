#include "avr_crystal.h"

#include "avr_time.h"

enum { REGISTERS = 5, UPDATE_EDGES = 2 };

/* By bits of ASSR, from bit 0 on: TCR2BUB, TCR2AUB, OCR2BUB, OCR2AUB, TCN2UB. */
static const uint16_t REGISTER[REGISTERS] = {TCCR2B, TCCR2A, OCR2B, OCR2A, TCNT2};

static int number_of(unsigned address)
{
    int n = 0;
    while (n < REGISTERS - 1 && REGISTER[n] != address) n++;
    return n;
}

static uint64_t hz(const avr *m) { return (uint64_t)(m->hz + 0.5); }

int avr_crystal_runs(const avr *m)
{
    return m->crystal.hz && avr_is_asynchronous(m) && !(m->data[ASSR] & EXCLK) == !m->crystal.is_clock;
}

static uint64_t edges_by(const avr *m, uint64_t cycle)
{
    uint64_t passed = cycle > m->crystal.zero ? cycle - m->crystal.zero : 0;
    return m->crystal.edges + passed / hz(m) * m->crystal.hz + passed % hz(m) * m->crystal.hz / hz(m);
}

uint64_t avr_crystal_edges(const avr *m, uint64_t at) { return edges_by(m, avr_outer(m, at)); }

void avr_crystal_rebase(avr *m)
{
    m->crystal.edges = edges_by(m, m->cycle);
    m->crystal.zero = m->cycle;
}

uint64_t avr_crystal_clock(const avr *m, uint64_t edge)
{
    uint64_t of = m->crystal.hz, edges = edge > m->crystal.edges ? edge - m->crystal.edges : 0;
    return avr_inner(m, m->crystal.zero + edges / of * hz(m) + (edges % of * hz(m) + of - 1) / of);
}

int avr_crystal_delays(avr *m, unsigned address, uint8_t value, uint64_t at)
{
    if (!avr_is_asynchronous(m)) return 0;
    int n = number_of(address);
    m->crystal.waiting[n] = value;
    m->crystal.due[n] = m->crystal.hz ? avr_crystal_edges(m, at) + UPDATE_EDGES : AVR_NEVER;
    m->data[ASSR] |= (uint8_t)(1 << n);
    return 1;
}

unsigned avr_crystal_next(const avr *m, uint64_t *clock)
{
    int next = -1;
    for (int n = 0; n < REGISTERS && avr_crystal_runs(m); n++)
        if (m->data[ASSR] >> n & 1 && m->crystal.due[n] != AVR_NEVER && (next < 0 || m->crystal.due[n] < m->crystal.due[next])) next = n;
    *clock = next < 0 ? AVR_NEVER : avr_crystal_clock(m, m->crystal.due[next]);
    return next < 0 ? 0 : REGISTER[next];
}

uint8_t avr_crystal_take(avr *m, unsigned address)
{
    int n = number_of(address);
    m->data[ASSR] &= (uint8_t)~(1 << n);
    return m->crystal.waiting[n];
}

uint8_t avr_crystal_read(const avr *m, unsigned address, uint8_t value)
{
    int n = number_of(address);
    return address != TCNT2 && m->data[ASSR] >> n & 1 ? m->crystal.waiting[n] : value;
}
