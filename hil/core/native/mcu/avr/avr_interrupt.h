/* Interrupts: who asks for one. DS40002061, Interrupts, External Interrupts. */
#ifndef HIL_AVR_INTERRUPT_H
#define HIL_AVR_INTERRUPT_H

#include "avr_state.h"

/* A flag or its enable has changed. */
void avr_ask(avr *m);

/* A port's levels have come through the edge detectors. */
void avr_interrupt_edges(avr *m, int port, uint8_t level, uint8_t before);

#endif
