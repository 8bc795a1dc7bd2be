/* Outputs of an axis: levels, wires that carry their edges on, and edges that are kept. */
#ifndef HIL_OUTPUTS_H
#define HIL_OUTPUTS_H

#include "types.h"

#define MOST_OUTPUTS HIL_BANK_PINS /* of any law */

/* From an output to an input, which `set` sets. */
typedef struct law_wire {
    int out, to_axis, to_pin;
    void (*set)(hil_core *c, int to_axis, int to_pin, int level, int64_t at_ns);
} law_wire;

typedef struct outputs {
    int32_t levels[MOST_OUTPUTS];
    int32_t watched;  /* outputs that somebody looks at, a bit each: recorded or wired */
    int32_t recorded; /* a bit each */
    law_wire wires[HIL_WIRES];
    int n_wires;
    hil_edge *edges;
    int edges_first, edges_len, edges_room; /* first: that nobody has taken */
} outputs;

void outputs_set(hil_core *c, outputs *o, int pin, int level, int64_t at_ns); /* a level, which may be as it was */
int outputs_join(outputs *o, const law_wire *wire); /* -1: too many */
void outputs_record(outputs *o, int which); /* edges of these from now on, a bit each; of others no more */
int outputs_take(outputs *o, hil_edge *out, int max); /* how many */
void outputs_close(outputs *o);

#endif
