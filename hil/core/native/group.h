/* Groups of axes, from inside; hil_core.h has what is asked of them from outside. */
#ifndef HIL_GROUP_H
#define HIL_GROUP_H

#include "state.h"

/* hil_group_advance in two halves, between which axes that nothing but their own control steps is due to may be moved
   on, in any order. begin: what has an order; answers how far the group comes, -1: nowhere. It is less far than a call of
   hil_group_advance may come. end: the rest of that. */
int64_t group_begin(hil_core *c, int group, int64_t until_ns);
void group_end(hil_core *c, int group, int64_t until_ns);
void group_publish(hil_core *c, int group); /* the snapshots of its axes */

#endif
