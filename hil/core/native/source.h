/* A signal source: pulse trains and single edges for an axis's inputs, at exact times. */
#ifndef HIL_SOURCE_H
#define HIL_SOURCE_H

#include "types.h"

typedef struct source {
    hil_edges *rows;
    int n, row;
    int64_t start_ns, next_ns; /* next_ns: of the edge to come, HIL_FOREVER: none */
    int64_t edge, whole_ns, part, rest; /* in a run: duration = whole * edges + part; rest: floor's remainder */
} source;

int source_start(source *s, int64_t now_ns, int n, const hil_edges *rows); /* instead of the rows before; -1: no memory */
void source_take(source *s, int *pin, int *level); /* the edge at next_ns; the next one is then to come */

#endif
