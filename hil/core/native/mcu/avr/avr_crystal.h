/* Timer 2 by a crystal of its own, as ASSR has it: DS40002061, Asynchronous Operation of Timer/Counter2.

   It is time in the world, whatever the CPU's clock does, and goes on where that stands still. What is written takes two of
   its edges until it is at work. Without a crystal there are no edges. A Uno has none: TOSC1 and TOSC2 have its clock. */
#ifndef HIL_AVR_CRYSTAL_H
#define HIL_AVR_CRYSTAL_H

#include "avr_registers.h"
#include "avr_state.h"

static inline int avr_is_asynchronous(const avr *m) { return m->data[ASSR] & AS2; }

int avr_crystal_runs(const avr *m);
void avr_crystal_rebase(avr *m);                            /* the chip's clock gets another speed */
uint64_t avr_crystal_edges(const avr *m, uint64_t at);      /* up to a clock */
uint64_t avr_crystal_clock(const avr *m, uint64_t edges);   /* the first clock by which there are so many */

/* A register of timer 2 is written: from its second edge on it is at work. Answers where it is not to wait. */
int avr_crystal_delays(avr *m, unsigned address, uint8_t value, uint64_t at);

/* The register that is next to get what waits, at a clock; 0: none. Its value, and it waits no more. */
unsigned avr_crystal_next(const avr *m, uint64_t *clock);
uint8_t avr_crystal_take(avr *m, unsigned address);

/* What a read gives where a register waits, else what it has: TCNT2 aside. */
uint8_t avr_crystal_read(const avr *m, unsigned address, uint8_t value);

#endif
