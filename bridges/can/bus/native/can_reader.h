/* What a frame says: its stuffed part, bit by bit. */
#ifndef CAN_READER_H
#define CAN_READER_H

#include "can_state.h"

void can_reader_start(can_node *n);
int can_read_bit(can_node *n, int level);

#endif
