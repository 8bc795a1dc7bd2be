#include "pins.h"

#include "core.h"
#include "hil_core.h"
#include "law.h"

void pins_set(hil_core *c, int axis, int pin, int level, int64_t at_ns)
{
    hil_axis *a = &c->axes[axis];
    core_stir(c, axis);
    level = level != 0;
    a->law->pin(c, a, pin, level, at_ns);
}

void pins_take_edge(hil_core *c, int axis)
{
    source *s = &c->axes[axis].source;
    int64_t at_ns = s->next_ns;
    int pin, level;
    source_take(s, &pin, &level);
    pins_set(c, axis, pin, level, at_ns);
}

void hil_axis_pin(hil_core *c, int axis, int pin, int level)
{
    int64_t now_ns;
    core_axis(c, axis, &now_ns);
    pins_set(c, axis, pin, level, now_ns);
}

int hil_axis_drive(hil_core *c, int axis, int n, const hil_edges *rows)
{
    hil_axis *a = &c->axes[axis];
    if (source_start(&a->source, hil_group_now(c, a->group), n, rows)) return -1;
    core_stir(c, axis);
    return 0;
}

static void look(hil_axis *a, int64_t now_ns)
{
    if (a->law->look) a->law->look(a, now_ns);
}

int hil_wire(hil_core *c, int from_axis, int from_pin, int to_axis, int to_pin)
{
    hil_axis *a = &c->axes[from_axis];
    law_wire wire = {.out = from_pin, .to_axis = to_axis, .to_pin = to_pin, .set = pins_set};
    int64_t now_ns = hil_group_now(c, a->group);
    if (!a->law->outputs) return -1;
    outputs *o = a->law->outputs(a);
    look(a, now_ns);
    if (outputs_join(o, &wire)) return -1;
    look(a, now_ns);
    core_join(c, from_axis);
    core_join(c, to_axis);
    core_stir(c, from_axis);
    pins_set(c, to_axis, to_pin, o->levels[from_pin], now_ns);
    return 0;
}

void hil_axis_record_edges(hil_core *c, int axis, int which)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    if (!a->law->outputs) return;
    look(a, now_ns);
    outputs_record(a->law->outputs(a), which);
    look(a, now_ns);
}

int hil_axis_take_edges(hil_core *c, int axis, hil_edge *out, int max)
{
    hil_axis *a = &c->axes[axis];
    return a->law->outputs ? outputs_take(a->law->outputs(a), out, max) : 0;
}
