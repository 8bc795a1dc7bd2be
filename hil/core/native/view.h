/* What is seen of an axis: its fields, snapshots of them, samples. */
#ifndef HIL_VIEW_H
#define HIL_VIEW_H

#include "state.h"

void view_publish(hil_axis *a, int64_t now_ns);
double view_field(hil_core *c, int axis, hil_field field, int64_t at_ns); /* of an axis that nothing happens to before */
void view_sample(hil_axis *a, int64_t at_ns); /* the samples that are due */
void view_plan(hil_axis *a); /* when to sample, or to look at its switches or its driver's heat, next */
void view_shaft(hil_axis *a, int64_t at_ns, double *rev, double *rev_per_s); /* what turns, as it is told */

#endif
