/* An ATmega328P: a program that runs instruction by instruction, with all that is on the chip.

   Time is the count of its clock's cycles. What comes out, the world is called with; what comes in, is told with the
   cycle at which it happens. An avr is data without pointers: copying it is a snapshot of it. It allocates nothing. */
#ifndef HIL_AVR_H
#define HIL_AVR_H

#include <stdint.h>

#include "avr_state.h" /* struct avr, avr_character, what is driven, causes, notes */
#include "avr_world.h"

/* Pins, by the numbers that a Uno has for them: 0 to 13 are D0 to D13, 14 to 19 A0 to A5; 20 and 21 are A6 and A7, which
   are no digital pins. */
enum { AVR_PINS = 20, AVR_CHANNELS = 8 };

/* For avr_watch: D1 is silent while the transmitter has it. Without it each bit of a frame is an edge there. */
enum { AVR_WATCH_NO_FRAMES = 1 << AVR_PINS };

/* Power off for ever so long: SRAM is zeros, flash and EEPROM are FFh, fuses are a Uno's without bootloader (BOOTRST is
   off), its clock 16 MHz. Nothing runs before avr_reset. */
void avr_open(avr *m);
void avr_clock(avr *m, double hz);            /* of the crystal: what other clocks of the chip are, in cycles */
void avr_crystal_at(avr *m, uint32_t hz, int is_clock); /* at TOSC1 and TOSC2, for timer 2 (avr_crystal.h); is_clock: a clock for EXCLK. At first none */
void avr_fuses(avr *m, int low, int high, int extended, int lock);
void avr_load_flash(avr *m, uint32_t byte, const uint8_t *data, uint32_t n); /* also while it runs */
void avr_load_eeprom(avr *m, uint32_t byte, const uint8_t *data, uint32_t n);

/* A reset now, at m->cycle: I/O as after it, SRAM as it was. Runs from address 0, or from the boot section by its fuse, after
   start_up cycles (the fuses' own: avr_start_up). Cause 0: as a power-on, and MCUSR is 0. */
void avr_reset(avr *m, int causes, uint64_t start_up);
uint64_t avr_start_up(const avr *m);

/* Runs all that ends at or before a cycle: instructions, and what the chip's parts do by themselves. What comes out does not
   depend on how a span is cut. Returns m->cycle: `until`, or less where avr_stop was called. */
uint64_t avr_run(avr *m, uint64_t until, const avr_world *world);
void avr_stop(avr *m); /* from the world: avr_run returns after the instruction that is under way */

/* The next cycle at which anything that is heard of could happen while nothing comes in: m->cycle while instructions run, later
   while it sleeps, UINT64_MAX: never. */
uint64_t avr_next(const avr *m);

/* From the cycle m->cycle on, which the world has brought it to. */
void avr_pin(avr *m, int pin, int level);     /* 0, 1; -1: nothing outside drives it */
void avr_volts(avr *m, int channel, double volts); /* at an analogue pin; lasts */
void avr_supply(avr *m, double vcc_volts, double aref_volts);
int avr_hear(avr *m, const avr_character *c); /* a character that comes to RX, or has begun to and is not over; -1: there is no room */
void avr_retract(avr *m, uint64_t after);     /* characters that begin after a cycle do not come, also where they have begun: their bits are told again */
void avr_watch(avr *m, uint32_t pins);        /* pins whose edges the world hears of, a bit each */
void avr_tell_means(avr *m, int is_told);     /* whether the world hears where mean levels of pins may change */
void avr_stack_floor(avr *m, uint16_t address); /* where its heap begins: below it a user is told of the stack. At first 100h */

/* Breakpoints: avr_run returns as by avr_stop before it carries out what is at such a byte; the next avr_run does. An interrupt
   that comes first is entered first. Where there are none they cost nothing. */
void avr_break_at(avr *m, uint32_t byte, int is_on);
int avr_is_at_break(const avr *m);

/* Looks, now. */
int avr_level(const avr *m, int pin);         /* of the pin, whoever drives it; a floating one is 0 */
enum avr_drive avr_driven(const avr *m, int pin);
double avr_duty(const avr *m, int pin);       /* part of the time that a PWM pin is high, from its timer's registers; -1: no PWM */
int avr_is_sending(const avr *m);              /* its transmitter has D1: what drives that is the frames */
uint32_t avr_bit_cycles(const avr *m);        /* of the UART; 0: its transmitter and receiver are off */
int avr_framing(const avr *m);                /* of the UART's characters: data bits, AVR_EVEN or AVR_ODD, AVR_TWO_STOPS */
uint16_t avr_stack_lowest(const avr *m);      /* where a push has been since the reset; 8FFh: none was below it */
uint8_t avr_peek(const avr *m, uint16_t address); /* data space, without what a read does */
void avr_poke(avr *m, uint16_t address, uint8_t value); /* likewise: SRAM and registers */

#endif
