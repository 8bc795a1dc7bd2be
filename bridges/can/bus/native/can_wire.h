/* A CAN wire and its controllers, bit by bit. No allocation, no I/O. bridges/can/bus/_bit_wire.pyi says what it
   does. Layers, each on those before it: can_state.h and can_chance.h; can_reader and can_errors; can_node, a
   controller; can_odd, controllers with a clock of their own; this. */
#ifndef CAN_WIRE_H
#define CAN_WIRE_H

#include "can_state.h"

int64_t can_at(const can_wire *w, int64_t bit);
void can_wake(can_wire *w, int64_t now_ns);
void can_tick(can_wire *w, int64_t limit_ns);

#endif
