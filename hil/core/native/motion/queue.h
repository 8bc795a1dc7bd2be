/* Which command comes next: of the xRef array's loop, the queue's loop, or those that wait. */
#ifndef HIL_MOTION_QUEUE_H
#define HIL_MOTION_QUEUE_H

#include "engine.h"

int queue_next(motion *m);          /* takes it: its slot; -1: none */
int queue_add(motion *m, int slot); /* to those that wait; 0: there is no room */
void queue_drop(motion *m);         /* all of them, and the loops */

#endif
