/* An axis's inputs: levels that clients, signal sources and other axes' outputs set. */
#ifndef HIL_PINS_H
#define HIL_PINS_H

#include "state.h"

/* level: 0, 1; OUTPUT_OPEN: nothing drives it any more. */
void pins_set(hil_core *c, int axis, int pin, int level, int64_t at_ns);
void pins_take_edge(hil_core *c, int axis); /* the source's edge at its next_ns */

#endif
