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

int hil_wire(hil_core *c, int from_axis, int from_pin, int to_axis, int to_pin)
{
    hil_axis *a = &c->axes[from_axis];
    law_wire wire = {.out = from_pin, .to_axis = to_axis, .to_pin = to_pin, .set = pins_set};
    int64_t now_ns = hil_group_now(c, a->group);
    int level;
    if (!a->law->join || a->law->join(a, &wire, now_ns, &level)) return -1;
    core_stir(c, from_axis);
    pins_set(c, to_axis, to_pin, level, now_ns);
    return 0;
}
