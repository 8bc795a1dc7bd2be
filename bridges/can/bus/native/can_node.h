/* A controller in a frame, between frames, and off the bus. */
#ifndef CAN_NODE_H
#define CAN_NODE_H

#include "can_state.h"

/* Begin to send what is loaded. */
void can_begin(can_node *n, int64_t now_ns);
/* Take the level of a bit; decide what to drive in the next. */
void can_step(can_node *n, int level, int64_t now_ns);
/* Its frame is on the wire, and good. */
void can_sent(can_node *n);
/* It has heard a good one. */
void can_good(can_node *n);

#endif
