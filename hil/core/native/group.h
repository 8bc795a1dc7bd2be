/* Groups of axes, from inside; hil_core.h has what is asked of them from outside. */
#ifndef HIL_GROUP_H
#define HIL_GROUP_H

#include "state.h"

void group_publish(hil_core *c, int group); /* the snapshots of its axes */

#endif
