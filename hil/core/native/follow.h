/* A path that a set-point follows: what moves a servo from one angle to another with ramps. */
#ifndef HIL_FOLLOW_H
#define HIL_FOLLOW_H

#include "types.h"

typedef struct follow {
    hil_path_piece *pieces;
    int n, at;        /* n: 0 none */
    int64_t since_ns; /* the beginning of the piece at */
} follow;

/* Instead of the path before; n = 0: none. -1: no memory, -2: a piece that is not finite, or too long. */
int follow_start(follow *f, int64_t start_ns, int n, const hil_path_piece *pieces);
void follow_step(follow *f, int64_t at_ns, float *r); /* at that time, with a path: the set-point, unless it has not begun */
void follow_end(follow *f);

#endif
