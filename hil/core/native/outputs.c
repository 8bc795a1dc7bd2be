#include "outputs.h"

#include <stdlib.h>
#include <string.h>

void edges_add(edge_list *l, int pin, int level, int64_t at_ns)
{
    if (l->len == l->room) {
        int room = l->room ? 2 * l->room : 1024;
        hil_edge *grown = realloc(l->edges, (size_t)room * sizeof *grown);
        if (!grown) return;
        l->edges = grown;
        l->room = room;
    }
    l->edges[l->len++] = (hil_edge){.at_ns = at_ns, .pin = pin, .level = level};
}

int edges_take(edge_list *l, hil_edge *out, int max)
{
    int left = l->len - l->first, n = left < max ? left : max;
    if (n > 0) memcpy(out, l->edges + l->first, (size_t)n * sizeof *out);
    l->first += n;
    if (l->first == l->len) l->first = l->len = 0;
    return n;
}

void edges_forget(edge_list *l)
{
    free(l->edges);
    *l = (edge_list){0};
}

void outputs_set(hil_core *c, outputs *o, int pin, int level, int64_t at_ns)
{
    int was = o->levels[pin];
    if (was == level) return;
    o->levels[pin] = level;
    if (!(o->watched & 1 << pin)) return;
    if (o->recorded & 1 << pin && (level > 0) != (was > 0)) edges_add(&o->edges, pin, level > 0, at_ns);
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

int outputs_is_wired(const outputs *o, int pin)
{
    for (int i = 0; i < o->n_wires; i++)
        if (o->wires[i].out == pin) return 1;
    return 0;
}

void outputs_record(outputs *o, int which)
{
    o->recorded = which;
    o->edges.first = o->edges.len = 0;
    attend(o);
}

void outputs_close(outputs *o) { edges_forget(&o->edges); }
