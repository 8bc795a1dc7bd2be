#include "follow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void follow_end(follow *f) { f->n = 0; }

int follow_start(follow *f, int64_t start_ns, int n, const hil_path_piece *pieces)
{
    int64_t length_ns = 0;
    for (int i = 0; i < n; i++) {
        const hil_path_piece *p = &pieces[i];
        if (p->duration_ns < 0 || p->duration_ns > HIL_PATH_NS - length_ns) return -2;
        if (!isfinite(p->r) || !isfinite(p->per_s) || !isfinite(p->per_s2) || !isfinite(p->per_s3)) return -2;
        length_ns += p->duration_ns;
    }
    hil_path_piece *copy = n ? malloc((size_t)n * sizeof *copy) : NULL;
    if (n && !copy) return -1;
    if (n) memcpy(copy, pieces, (size_t)n * sizeof *copy);
    free(f->pieces);
    *f = (follow){.pieces = copy, .n = n, .since_ns = start_ns};
    return 0;
}

void follow_step(follow *f, int64_t at_ns, float *r)
{
    if (at_ns < f->since_ns) return;
    const hil_path_piece *p = &f->pieces[f->at];
    while (at_ns - f->since_ns > p->duration_ns && f->at < f->n - 1) {
        f->since_ns += p->duration_ns;
        p = &f->pieces[++f->at];
    }
    int64_t into_ns = at_ns - f->since_ns;
    if (into_ns >= p->duration_ns && f->at == f->n - 1) { /* the path's end, which the set-point keeps */
        into_ns = p->duration_ns;
        f->n = 0;
    }
    double t = (double)into_ns * 1e-9;
    *r = (float)(p->r + t * (p->per_s + t * (p->per_s2 / 2 + t * p->per_s3 / 6)));
}
