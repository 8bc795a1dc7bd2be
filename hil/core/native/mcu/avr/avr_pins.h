/* Ports B, C and D: what drives a pin, and its level. DS40002061, I/O-Ports. */
#ifndef HIL_AVR_PINS_H
#define HIL_AVR_PINS_H

#include "avr_state.h"

enum { AVR_PORT_B, AVR_PORT_C, AVR_PORT_D };

/* Clocks from a level at a pin to what edges do: the synchroniser, and the edge detector (DS40002061, External Clock Source:
   2.5 to 3.5; the same for input capture and, as far as the figure tells, for pin changes). */
enum { AVR_EDGE_CLOCKS = 3 };

/* Of the Uno's numbers. */
static inline int avr_port_of(int pin) { return pin < 8 ? AVR_PORT_D : pin < 14 ? AVR_PORT_B : AVR_PORT_C; }
static inline int avr_bit_of(int pin) { return pin < 8 ? pin : pin < 14 ? pin - 8 : pin - 14; }

/* The port's registers, or what a part or the world makes of it, have changed. */
void avr_pins_refresh(avr *m, int port, uint64_t at);

/* What PINx shows at a clock. */
static inline uint8_t avr_pins_read(const avr *m, int port, uint64_t at)
{
    const avr_port *p = &m->port[port];
    return at > p->changed ? p->level : p->before;
}

/* A part takes pins of a port: how (bits as they are in avr_port). Follow by avr_pins_refresh. */
void avr_pins_own(avr *m, int port, uint8_t bits, int is_own, int level);
void avr_pins_direct(avr *m, int port, uint8_t bits, int as_output, int as_input);

enum avr_drive avr_pins_drive(const avr *m, int port, uint8_t bit);

/* Bits whose digital input is off, by DIDR0 and DIDR1: PIN reads 0 there, and edges are none. */
uint8_t avr_pins_disabled(const avr *m, int port);

/* Bits whose edges something on the chip waits for. */
uint8_t avr_pins_cared(const avr *m, int port);

#endif
