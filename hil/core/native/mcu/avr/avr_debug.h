/* A debugger's hold on a chip, which stands between two instructions, and counts of where its time goes. While it steps or
   counts, it runs an instruction at a time, with the same result at a fraction of the speed. */
#ifndef HIL_AVR_DEBUG_H
#define HIL_AVR_DEBUG_H

#include "avr_state.h"

/* For who has the chip. */
void avr_halt(avr *m);                            /* now; an instruction that is under way is still to be carried out */
void avr_go(avr *m, int is_step);   /* goes on; the next instruction is carried out also if a breakpoint is there, a step is it alone */
void avr_jump(avr *m, uint32_t byte);
/* Clocks that are spent from now on in functions, by their first words, n of them ascending, 0: no more; and from one time at a word
   to the next, -1: at none. */
void avr_count(avr *m, int n, const uint16_t *starts, int lap_at);

/* For its run. */
int avr_debug_halts(avr *m);                                   /* before an instruction; 1: it stands there */
void avr_debug_counted(avr *m, unsigned pc, uint64_t began);   /* after one */

#endif
