/* Sleep: which clocks stand still, and what waking takes. DS40002061, Power Management and Sleep Modes. */
#ifndef HIL_AVR_SLEEP_H
#define HIL_AVR_SLEEP_H

#include "avr_state.h"

void avr_sleep(avr *m, uint64_t at); /* SLEEP, at its end */

/* Wakes it at a clock; its next instruction begins later. */
void avr_wake(avr *m, uint64_t at);

/* Whether anything could wake it without the world. */
int avr_may_wake(const avr *m);

#endif
