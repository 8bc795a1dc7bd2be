/* Registers of I/O, as instructions reach them.

   When that happens within an instruction is said once, here: one of n clocks that begins at c writes at c + n, after all
   that the chip's parts do at that clock, and reads at c + n - 1 what is there then; a skip by a bit of I/O reads at c. */
#ifndef HIL_AVR_IO_H
#define HIL_AVR_IO_H

#include "avr_interrupt.h"
#include "avr_memory.h"
#include "avr_pins.h"
#include "avr_registers.h"
#include "avr_sleep.h"
#include "avr_state.h"
#include "avr_watchdog.h"

/* Any address of data space; what is not there reads 0. */
uint8_t avr_load(avr *m, unsigned address, uint64_t at);
void avr_store(avr *m, unsigned address, uint8_t value, uint64_t at);

/* Likewise below 40h, where bits are tested: pins aside, registers that are as they were written. */
static inline uint8_t avr_load_low(avr *m, unsigned address, uint64_t at)
{
    if (address == PINB) return avr_pins_read(m, AVR_PORT_B, at);
    return address == PIND || address == PINC || address == EECR ? avr_load(m, address, at) : m->data[address];
}

/* SBI and CBI: they touch their bit alone. */
void avr_set_bit(avr *m, unsigned address, uint8_t bit, uint64_t at);
void avr_clear_bit(avr *m, unsigned address, uint8_t bit, uint64_t at);

#endif
