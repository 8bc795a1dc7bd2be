/* The two-wire interface, bit by bit at its pins: SDA A4, SCL A5, both open-drain. DS40002061, 2-wire Serial Interface.

   Of several masters the one that pulls SDA low goes on; another one follows its byte, which may be for it as a slave. */
#ifndef HIL_AVR_TWI_H
#define HIL_AVR_TWI_H

#include "avr_state.h"

void avr_twi_event(avr *m, uint64_t at);                               /* half a bit of a master is over */
void avr_twi_edges(avr *m, uint8_t level, uint8_t before, uint64_t at); /* levels of port C have come through */
void avr_twi_store(avr *m, unsigned address, uint8_t value, uint64_t at);

#endif
