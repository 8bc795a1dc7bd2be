/* Timers 0, 1 and 2 in all modes: DS40002061, 8-bit Timer/Counter0, 16-bit Timer/Counter1, Prescalers, Timer/Counter2.

   Flags and pins change at the tick that leaves a value, by the figures of those chapters (Timer/Counter Timing Diagrams). */
#ifndef HIL_AVR_TIMER_H
#define HIL_AVR_TIMER_H

#include "avr_state.h"

/* Does what its ticks up to a clock do. The event of its part, and before each look at it. */
void avr_timer_advance(avr *m, int n, uint64_t at);

/* A tick from outside: an edge at T0 or T1. */
void avr_timer_pulse(avr *m, int n, uint64_t at);

/* An edge of ICP1 has come through the edge detector; the noise canceller may hold it. */
void avr_timer_edge(avr *m, int level, uint64_t at);

uint8_t avr_timer_load(avr *m, unsigned address, uint64_t at);
void avr_timer_store(avr *m, unsigned address, uint8_t value, uint64_t at);

/* Flags of TIFRn are cleared. */
void avr_timer_clear(avr *m, int n, uint8_t flags, uint64_t at);

/* GTCCR, PRR or ASSR has changed. */
void avr_timer_gates(avr *m, uint64_t at);

/* The I/O clock has stood still for some clocks. */
void avr_timer_shift(avr *m, uint64_t clocks);

/* Part of the time that a pin is high by its PWM; -1: it has none. */
double avr_timer_duty(const avr *m, int pin);

#endif
