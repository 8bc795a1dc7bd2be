#include "pins.h"

#include "core.h"
#include "hil_core.h"
#include "law.h"

void pins_set(hil_core *c, int axis, int pin, int level, int64_t at_ns)
{
    hil_axis *a = &c->axes[axis];
    core_stir(c, axis);
    int32_t bit = 1 << pin, was = a->inputs.known & bit ? !!(a->inputs.high & bit) : OUTPUT_OPEN;
    a->inputs.known = level == OUTPUT_OPEN ? a->inputs.known & ~bit : a->inputs.known | bit;
    a->inputs.high = level > 0 ? a->inputs.high | bit : a->inputs.high & ~bit;
    if (a->inputs.recorded & bit && level != was) edges_add(&a->inputs.edges, pin, level > 0, at_ns);
    a->law->pin(c, a, pin, level == OUTPUT_OPEN ? a->law->pulled_up >> pin & 1 : level, at_ns);
}

void pins_take_edge(hil_core *c, int axis)
{
    source *s = &c->axes[axis].source;
    int64_t at_ns = s->next_ns;
    int pin, level;
    source_take(s, &pin, &level);
    pins_set(c, axis, pin, level != 0, at_ns);
}

void hil_axis_pin(hil_core *c, int axis, int pin, int level)
{
    int64_t now_ns;
    core_axis(c, axis, &now_ns);
    pins_set(c, axis, pin, level != 0, now_ns);
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
    return a->law->outputs ? edges_take(&a->law->outputs(a)->edges, out, max) : 0;
}

int hil_axis_output_levels(hil_core *c, int axis)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    int high = 0;
    if (!a->law->outputs) return 0;
    look(a, now_ns);
    for (int pin = 0; pin < MOST_OUTPUTS; pin++) high |= (a->law->outputs(a)->levels[pin] > 0) << pin;
    return high;
}

void hil_axis_record_inputs(hil_core *c, int axis, int which)
{
    int64_t now_ns;
    hil_axis *a = core_axis(c, axis, &now_ns);
    a->inputs.recorded = which;
    a->inputs.edges.first = a->inputs.edges.len = 0;
    for (int pin = 0; pin < 32; pin++) {
        int32_t bit = (int32_t)(1u << pin);
        if (which & a->inputs.known & bit) edges_add(&a->inputs.edges, pin, !!(a->inputs.high & bit), now_ns);
    }
}

int hil_axis_take_inputs(hil_core *c, int axis, hil_edge *out, int max) { return edges_take(&c->axes[axis].inputs.edges, out, max); }
