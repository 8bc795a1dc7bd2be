/* The processor of a bank of pins: a program that drives them, instruction by instruction. */
#ifndef HIL_LAW_BANK_PROCESSOR_H
#define HIL_LAW_BANK_PROCESSOR_H

#include "bank_state.h"

void bank_processor_open(bank_processor *p); /* its memory is all zeros */
void bank_processor_set_clock(bank_processor *p); /* from nominal_hz and its error, from its present cycle on */
void bank_processor_supply(bank_processor *p, double vcc_V, double aref_V);
void bank_processor_power_up(hil_axis *a, bank_processor *p); /* nothing runs, and its memories are as after avr_open */
int64_t bank_processor_next_ns(const bank_processor *p);      /* HIL_FOREVER: it does nothing by itself */
int64_t bank_processor_run(hil_core *c, hil_axis *a, int64_t until_ns); /* answers how much that was */
void bank_processor_pin(hil_core *c, hil_axis *a, int pin, int64_t at_ns); /* its outside level has changed */
void bank_processor_look(hil_axis *a, int64_t now_ns);
void bank_processor_show(hil_core *c, hil_axis *a, int64_t now_ns); /* all pins, after it has begun or ended */
int bank_processor_hear(bank_processor *p, const avr_character *heard); /* -1: there is no room */
void bank_processor_retract(bank_processor *p, uint64_t after);
double bank_processor_volts(hil_core *c, const bank_processor *p, int channel, int64_t at_ns);
void bank_processor_set_zero(bank_processor *p, int64_t now_ns);    /* its present cycle is at this time */
uint64_t bank_processor_now(const bank_processor *p, int64_t now_ns); /* its cycle, also while it sleeps and is not run */
uint64_t bank_processor_cycle(const bank_processor *p, int64_t at_ns); /* the last one that is not after a time */
int bank_processor_outside(const hil_axis *a, const pin_bank *b, int pin); /* the level that drives a pin from outside; -1: nothing does */

#endif
