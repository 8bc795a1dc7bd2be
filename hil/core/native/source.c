/* Signal sources: pulse trains and single edges on an axis's inputs, at exact times. */
#include <stdlib.h>
#include <string.h>

#include "core.h"

enum { PIN_STEP = 1 };

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

int hil_axis_drive(hil_core *c, int axis, int n, const hil_edges *rows)
{
    hil_axis *a = &c->axes[axis];
    hil_edges *copy = n ? malloc((size_t)n * sizeof *copy) : NULL;
    if (n && !copy) return -1;
    if (n) memcpy(copy, rows, (size_t)n * sizeof *copy);
    free(a->source.rows);
    a->source = (source){.rows = copy, .n = n, .start_ns = hil_group_now(c, a->group)};
    enter_row(&a->source);
    core_stir(c, axis);
    return 0;
}

void source_edge(hil_core *c, hil_axis *a, int axis)
{
    source *s = &a->source;
    const hil_edges *r = &s->rows[s->row];
    int64_t at_ns = s->next_ns;
    if (r->steps == 0) {
        axis_pin(c, axis, r->pin, r->level, at_ns);
    } else {
        axis_pin(c, axis, PIN_STEP, s->edge % 2 == 0, at_ns);
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
