/* The watchdog: DS40002061, Watchdog Timer. Its oscillator is taken as exact. */
#ifndef HIL_AVR_WATCHDOG_H
#define HIL_AVR_WATCHDOG_H

#include "avr_state.h"

void avr_watchdog_restart(avr *m, uint64_t at); /* WDR, and each change */
void avr_watchdog_store(avr *m, uint8_t value, uint64_t at);
int avr_watchdog_event(avr *m, uint64_t at); /* 1: it resets the chip */

#endif
