#include "axis.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "hil_core.h"
#include "laws.h"
#include "pins.h"
#include "rt/lock.h"
#include "switches.h"
#include "view.h"

void axis_node(hil_axis *a, int64_t t_ns)
{
    if (a->is_turned) law_plant(a, t_ns);
    shaft_node(a, t_ns);
}

int64_t axis_next_ns(const hil_axis *a)
{
    int64_t next_ns = a->law_next_ns;
    if (a->source.next_ns < next_ns) next_ns = a->source.next_ns;
    return a->watch_next_ns < next_ns ? a->watch_next_ns : next_ns;
}

int64_t axis_tells_ns(const hil_axis *a)
{
    if (a->is_joined || !a->law->tells_ns) return axis_next_ns(a);
    int64_t tells_ns = a->law->tells_ns(a);
    return a->source.next_ns < tells_ns ? a->source.next_ns : tells_ns;
}

/* At its switches and its driver's heat, and for its watchers. */
static void look(hil_core *c, hil_axis *a, int64_t at_ns)
{
    if (a->switch_next_ns == at_ns) switches_look(c, a);
    if (a->heat_next_ns == at_ns) a->law->warm(a, at_ns);
    view_sample(a, at_ns);
    view_plan(a);
}

int64_t axis_advance(hil_core *c, hil_axis *a, int axis, int64_t t_ns)
{
    int64_t work = 0;
    for (int64_t next_ns; (next_ns = axis_next_ns(a)) <= t_ns && next_ns < HIL_FOREVER; work++) {
        if (a->source.next_ns == next_ns) pins_take_edge(c, axis);
        else if (a->law_next_ns == next_ns) {
            int64_t until_ns = a->source.next_ns <= t_ns ? a->source.next_ns - 1 : t_ns;
            work += a->law->step(c, a, a->watch_next_ns < until_ns ? a->watch_next_ns : until_ns);
            if (a->has_stopped) return work;
        } else look(c, a, next_ns);
    }
    if (!a->is_pacing) law_plant(a, t_ns);
    return work;
}

int axis_is_idle(const hil_axis *a)
{
    if (!(a->is_full ? a->full.at_rest : a->plant.at_rest) || a->is_turned) return 0;
    return axis_next_ns(a) == HIL_FOREVER;
}

/* Memory for its events, which grows with a group's axes. */
static void make_room(hil_core *c, hil_group *g)
{
    int events = 0;
    for (int i = g->first_axis; i >= 0; i = c->axes[i].next_in_group) events += c->axes[i].law->events;
    ring_grow(&g->events, (uint32_t)events);
}

int hil_axis_open(hil_core *c, int group, const hil_axis_params *params)
{
    int axis = 0;
    while (axis < c->max_axes && c->axes[axis].open) axis++;
    if (axis == c->max_axes) return -1;
    int64_t now_ns = atomic_load(&c->groups[group].now_ns);
    plant simple = {0};
    full full = {0};
    const law *law = laws[params->law];
    double max_current_A = law->max_current_A(params);
    if (params->is_full ? full_init(&full, params, max_current_A, now_ns)
                        : plant_init(&simple, params->inertia_kg_m2, params->viscous_Nm_s_per_rad,
                                     params->torque_constant_Nm_per_A, params->rotor_teeth, max_current_A,
                                     params->start_deg / 360, params->load_torque_Nm, now_ns))
        return -2;
    hil_axis *a = &c->axes[axis];
    memset((char *)a + offsetof(hil_axis, open), 0, sizeof *a - offsetof(hil_axis, open));
    a->open = 1;
    a->law = law;
    a->own = memset(law_place(c, (hil_law)params->law, axis), 0, law->bytes);
    a->law_next_ns = HIL_FOREVER;
    a->is_full = params->is_full;
    a->plant = simple;
    a->full = full;
    a->group = group;
    a->next_in_group = c->groups[group].first_axis;
    a->order = a->next_in_group < 0 ? 0 : c->axes[a->next_in_group].order + 1;
    c->groups[group].first_axis = axis;
    a->load_torque_Nm = params->load_torque_Nm;
    a->encoder.previous_command = 0xFFFF;
    a->source.next_ns = a->watch_next_ns = a->switch_next_ns = a->heat_next_ns = HIL_FOREVER;
    make_room(c, &c->groups[group]);
    if (atomic_load(&c->rt.running)) { /* what was refused was said at the start */
        (void)rt_lock_axis(c, axis);
        (void)rt_lock_group(c, group);
    }
    law->open(a, params);
    hil_axis_power_up(c, axis);
    view_publish(a, now_ns);
    return axis;
}

int hil_axis_cells(hil_core *c, int axis, int n, const int32_t *fields)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    own_cells *own = calloc(1, sizeof *own + (size_t)n * sizeof *own->cells);
    if (!own || a->cells || a->watch_next_ns != HIL_FOREVER) {
        free(own);
        return -1;
    }
    own->n = n;
    for (int i = 0; i < n; i++) {
        const hil_field_info *in = &hil_field_table[fields[i]];
        own->cells[i] = (cell){.field = fields[i], .offset = (int32_t)in->offset, .type = {in->type[0], in->type[1]}};
    }
    a->cells = own;
    return 0;
}

int64_t hil_axis_bytes(hil_law law)
{
    int events = laws[law]->events > RING_LEAST ? laws[law]->events : RING_LEAST;
    return (int64_t)(sizeof(hil_axis) + laws[law]->bytes + sizeof(hil_group) + (size_t)events * sizeof(hil_event));
}

void axis_close(hil_axis *a)
{
    (void)encoder_script(&a->encoder, 0, NULL, NULL, 0);
    (void)source_start(&a->source, 0, 0, NULL);
    for (int i = 0; i < HIL_WATCHES; i++) (void)watch_start(&a->watches[i], 0, 0, 0, 1, 0, NULL, 0);
    free(a->cells);
    a->cells = NULL;
    edges_forget(&a->inputs.edges);
    switches_close(a);
    if (a->open) a->law->close(a);
    a->open = 0;
}

void hil_axis_power_up(hil_core *c, int axis)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    a->law->power_up(c, a, now_ns);
}

int hil_axis_set(hil_core *c, int axis, hil_field field, double value)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    if (field >= HIL_FIELDS) return -1;
    cell *own = cells_find(a->cells, (int)field);
    if (own) {
        own->value = value;
        return 0;
    }
    int kind = hil_field_table[field].kind;
    if (kind != HIL_KIND_ANY && !(kind & a->law->kind)) return -1;
    if (field == HIL_FIELD_position_deg) {
        (void)hil_axis_get(c, axis, field); /* a look, which does not move the plant's nodes */
        a->zero_rev = a->view.rev - value / 360;
        return 0;
    }
    if (field != HIL_FIELD_load_torque_Nm) return a->law->set(a, field, value, now_ns);
    axis_node(a, now_ns);
    a->load_torque_Nm = value;
    shaft_set_load(a);
    return 0;
}

double hil_axis_do(hil_core *c, int axis, int call, double x, double y, double z)
{
    hil_axis *a = &c->axes[axis];
    if (!a->law->act) return -1;
    core_stir(c, axis);
    return a->law->act(c, a, call, x, y, z);
}

int hil_axis_spi(hil_core *c, int axis, int command)
{
    int64_t now_ns;
    hil_axis *a = core_axis(c, axis, &now_ns);
    a->is_shown = 0; /* reading changes registers */
    return encoder_exchange(&a->encoder, command, shaft_raw(a, now_ns));
}
