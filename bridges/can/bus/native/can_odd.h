/* Nodes with a clock of their own. */
#ifndef CAN_ODD_H
#define CAN_ODD_H

#include "can_state.h"

/* Let them have what falls into a bit, with the level that the others drive; answers the level in the middle. */
int can_tick_odd(can_wire *w, int level, int64_t start_ns, int64_t middle_ns, int64_t end_ns);

#endif
