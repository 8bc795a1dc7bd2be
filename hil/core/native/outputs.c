#include "outputs.h"

#include <stdlib.h>
#include <string.h>

static void record(outputs *o, int pin, int level, int64_t at_ns)
{
    if (o->edges_len == o->edges_room) {
        int room = o->edges_room ? 2 * o->edges_room : 1024;
        hil_edge *grown = realloc(o->edges, (size_t)room * sizeof *grown);
        if (!grown) return;
        o->edges = grown;
        o->edges_room = room;
    }
    o->edges[o->edges_len++] = (hil_edge){.at_ns = at_ns, .pin = pin, .level = level};
}

void outputs_set(hil_core *c, outputs *o, int pin, int level, int64_t at_ns)
{
    if (o->levels[pin] == level) return;
    o->levels[pin] = level;
    if (!(o->watched & 1 << pin)) return;
    if (o->recorded & 1 << pin) record(o, pin, level, at_ns);
    for (int i = 0; i < o->n_wires; i++) {
        const law_wire *w = &o->wires[i];
        if (w->out == pin) w->set(c, w->to_axis, w->to_pin, level, at_ns);
    }
}

static void attend(outputs *o)
{
    o->watched = o->recorded;
    for (int i = 0; i < o->n_wires; i++) o->watched |= 1 << o->wires[i].out;
}

int outputs_join(outputs *o, const law_wire *wire)
{
    if (o->n_wires == HIL_WIRES) return -1;
    o->wires[o->n_wires++] = *wire;
    attend(o);
    return 0;
}

void outputs_record(outputs *o, int which)
{
    o->recorded = which;
    o->edges_first = o->edges_len = 0;
    attend(o);
}

int outputs_take(outputs *o, hil_edge *out, int max)
{
    int left = o->edges_len - o->edges_first, n = left < max ? left : max;
    if (n > 0) memcpy(out, o->edges + o->edges_first, (size_t)n * sizeof *out);
    o->edges_first += n;
    if (o->edges_first == o->edges_len) o->edges_first = o->edges_len = 0;
    return n;
}

void outputs_close(outputs *o)
{
    free(o->edges);
    o->edges = NULL;
}
