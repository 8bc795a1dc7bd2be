/* What is seen of an axis: its fields, snapshots of them, samples. */
#ifndef HIL_VIEW_H
#define HIL_VIEW_H

#include "state.h"

void view_publish(hil_axis *a, int64_t now_ns);
void view_sample(hil_axis *a); /* the samples at watch_next_ns */

#endif
