/* Outputs of an axis: levels, wires that carry their edges on, and edges that are kept. */
#ifndef HIL_OUTPUTS_H
#define HIL_OUTPUTS_H

#include "types.h"

#define MOST_OUTPUTS HIL_BANK_PINS /* of any law */
enum { OUTPUT_OPEN = -1 };         /* the level of an output that drives nothing */

/* From an output to an input, which `set` sets. */
typedef struct law_wire {
    int out, to_axis, to_pin;
    void (*set)(hil_core *c, int to_axis, int to_pin, int level, int64_t at_ns);
} law_wire;

/* Edges that are kept until somebody takes them. */
typedef struct edge_list {
    hil_edge *edges;
    int first, len, room; /* first: that nobody has taken */
} edge_list;

void edges_add(edge_list *l, int pin, int level, int64_t at_ns);
int edges_take(edge_list *l, hil_edge *out, int max); /* how many */
void edges_forget(edge_list *l); /* gives back its memory */

typedef struct outputs {
    int32_t levels[MOST_OUTPUTS]; /* 0, 1, OUTPUT_OPEN */
    int32_t watched;  /* outputs that somebody looks at, a bit each: recorded or wired */
    int32_t recorded; /* a bit each */
    law_wire wires[HIL_WIRES];
    int n_wires;
    edge_list edges;
} outputs;

void outputs_set(hil_core *c, outputs *o, int pin, int level, int64_t at_ns); /* a level, which may be as it was */
int outputs_join(outputs *o, const law_wire *wire); /* -1: too many */
int outputs_is_wired(const outputs *o, int pin);
void outputs_record(outputs *o, int which); /* edges of these from now on, a bit each; of others no more */
void outputs_close(outputs *o);

#endif
