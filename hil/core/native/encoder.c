#include "encoder.h"

#include <stdlib.h>
#include <string.h>

static int64_t floor_div(__int128 n, int64_t d)
{
    __int128 q = n / d;
    return (int64_t)(q - (n % d < 0));
}

int encoder_scripted_raw(const encoder *e, int64_t t_ns)
{
    int i = 0, last = e->script_len - 1;
    if (t_ns < e->script_ns[0]) return (int)(e->script_raw[0] & 16383);
    for (int high = last + 1; high - i > 1;) { /* the last point not after t_ns */
        int middle = (i + high) / 2;
        if (e->script_ns[middle] <= t_ns) i = middle; else high = middle;
    }
    int64_t raw = e->script_raw[i];
    if (e->script_linear && i < last)
        raw += floor_div(((__int128)e->script_raw[i + 1] - raw) * (t_ns - e->script_ns[i]),
                         e->script_ns[i + 1] - e->script_ns[i]);
    return (int)(raw & 16383); /* two's complement: & is the mathematical modulo, below 0 too */
}

int encoder_script(encoder *e, int n, const int64_t *at_ns, const int64_t *raw, int is_linear)
{
    int64_t *copy = n ? malloc((size_t)n * 2 * sizeof *copy) : NULL;
    if (n && !copy) return -1;
    if (n) {
        memcpy(copy, at_ns, (size_t)n * sizeof *copy);
        memcpy(copy + n, raw, (size_t)n * sizeof *copy);
    }
    free(e->script_ns);
    e->script_ns = copy;
    e->script_raw = copy ? copy + n : NULL;
    e->script_len = n;
    e->script_linear = is_linear;
    return 0;
}
