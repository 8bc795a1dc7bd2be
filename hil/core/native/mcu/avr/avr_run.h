/* The order in which things happen: what begins when, and what the chip's parts do in between. */
#ifndef HIL_AVR_RUN_H
#define HIL_AVR_RUN_H

#include "avr_state.h"
#include "avr_world.h"

/* I/O as after a reset; the CPU's next instruction begins at a clock. */
void avr_run_reset(avr *m, int causes, uint64_t at, uint64_t begins);

/* Clocks that it takes from a reset to the first instruction, by the fuses. */
uint64_t avr_run_start_up(const avr *m);

/* Runs until a cycle of the world. */
void avr_run_until(avr *m, uint64_t until, const avr_world *world);

#endif
