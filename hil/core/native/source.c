#include "source.h"

#include <stdlib.h>
#include <string.h>

/* Makes the row that comes now ready for its first edge. */
static void enter_row(source *s)
{
    if (s->row == s->n) {
        s->next_ns = HIL_FOREVER;
        return;
    }
    const hil_edges *r = &s->rows[s->row];
    s->next_ns = s->start_ns + r->at_ns;
    s->edge = s->rest = 0;
    if (r->steps == 0) return;
    s->whole_ns = r->duration_ns / (2 * r->steps);
    s->part = r->duration_ns % (2 * r->steps);
}

int source_start(source *s, int64_t now_ns, int n, const hil_edges *rows)
{
    hil_edges *copy = n ? malloc((size_t)n * sizeof *copy) : NULL;
    if (n && !copy) return -1;
    if (n) memcpy(copy, rows, (size_t)n * sizeof *copy);
    free(s->rows);
    *s = (source){.rows = copy, .n = n, .start_ns = now_ns};
    enter_row(s);
    return 0;
}

void source_take(source *s, int *pin, int *level)
{
    const hil_edges *r = &s->rows[s->row];
    if (r->steps == 0) {
        *pin = r->pin;
        *level = r->level;
    } else {
        *pin = HIL_SERVO_IN_STEP;
        *level = s->edge % 2 == 0;
        s->next_ns += s->whole_ns;
        s->rest += s->part;
        if (s->rest >= 2 * r->steps) {
            s->rest -= 2 * r->steps;
            s->next_ns++;
        }
        if (++s->edge < 2 * r->steps) return;
    }
    s->row++;
    enter_row(s);
}
