/* Instructions, one after the other. */
#ifndef HIL_AVR_EXECUTE_H
#define HIL_AVR_EXECUTE_H

#include "avr_state.h"

/* Clocks of the instruction at pc, from what registers and pins are now. */
int avr_length(avr *m);

/* Runs instructions, one at least, until m->t is no longer before m->attention, which some of them set to 0. */
void avr_execute(avr *m);

/* Enters the handler of a vector: four clocks. */
void avr_enter(avr *m, int vector);

#endif
