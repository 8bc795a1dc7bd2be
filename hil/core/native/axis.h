/* An axis: its law, its shaft, its source and its watches, in time. */
#ifndef HIL_AXIS_H
#define HIL_AXIS_H

#include "state.h"

int64_t axis_advance(hil_core *c, hil_axis *a, int axis, int64_t t_ns); /* all that happens up to and at t_ns, or until it has stopped; how much that was */
int64_t axis_next_ns(const hil_axis *a);       /* when something happens next; HIL_FOREVER: never */
int64_t axis_tells_ns(const hil_axis *a);      /* before that it does nothing that others could hear of; HIL_FOREVER: it never does */
int axis_is_idle(const hil_axis *a);           /* at rest, and nothing will happen by itself */
void axis_node(hil_axis *a, int64_t t_ns);     /* makes t_ns a node: before what changes its currents or its load */
void axis_close(hil_axis *a);                  /* gives back its memory; one that was never opened has none */

#endif
