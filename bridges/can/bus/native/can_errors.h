/* Error and overload frames, and the counters. */
#ifndef CAN_ERRORS_H
#define CAN_ERRORS_H

#include "can_state.h"

int can_is_passive(const can_node *n);
void can_go_off(can_node *n);
void can_wrong(can_node *n, int error);
void can_overload(can_node *n);
void can_step_error(can_node *n, int level);

#endif
