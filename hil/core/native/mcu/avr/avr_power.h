/* PRR: it stops parts, which go on later as they were. DS40002061, Power Reduction Register. */
#ifndef HIL_AVR_POWER_H
#define HIL_AVR_POWER_H

#include "avr_state.h"

void avr_power_store(avr *m, uint8_t value, uint64_t at);

#endif
