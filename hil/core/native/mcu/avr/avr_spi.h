/* The serial peripheral interface, bit by bit at its pins: SS D10, MOSI D11, MISO D12, SCK D13. DS40002061, SPI. */
#ifndef HIL_AVR_SPI_H
#define HIL_AVR_SPI_H

#include "avr_state.h"

void avr_spi_event(avr *m, uint64_t at);                               /* half a bit of a master is over */
void avr_spi_edges(avr *m, uint8_t level, uint8_t before, uint64_t at); /* levels of port B have come through */
void avr_spi_look(avr *m, uint64_t at); /* SS may have become an input that is low: a master is one no longer */
uint8_t avr_spi_load(avr *m, unsigned address);
void avr_spi_store(avr *m, unsigned address, uint8_t value, uint64_t at);

#endif
