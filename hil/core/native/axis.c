#include "axis.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "core.h"
#include "hil_core.h"
#include "motion/motion.h"
#include "pins.h"
#include "rt/lock.h"
#include "servo.h"
#include "shaft.h"
#include "stepper.h"
#include "view.h"

void axis_node(hil_axis *a, int64_t t_ns)
{
    if (a->stepper) stepper_plant(a, t_ns);
    shaft_node(a, t_ns);
}

int64_t axis_next_ns(const hil_axis *a)
{
    int64_t next_ns = a->loop_on ? a->next_step_ns : HIL_FOREVER;
    if (a->source.next_ns < next_ns) next_ns = a->source.next_ns;
    if (a->watch_next_ns < next_ns) next_ns = a->watch_next_ns;
    int64_t stepper_ns = a->stepper ? stepper_next_ns(a) : HIL_FOREVER;
    return stepper_ns < next_ns ? stepper_ns : next_ns;
}

int64_t axis_advance(hil_core *c, hil_axis *a, int axis, int64_t t_ns)
{
    int64_t work = 0;
    for (int64_t next_ns; (next_ns = axis_next_ns(a)) <= t_ns && next_ns < HIL_FOREVER; work++) {
        if (a->source.next_ns == next_ns) pins_take_edge(c, axis);
        else if (a->loop_on && a->next_step_ns == next_ns) servo_step(c, a, axis);
        else if (a->stepper && stepper_next_ns(a) == next_ns) {
            int64_t until_ns = a->source.next_ns <= t_ns ? a->source.next_ns - 1 : t_ns;
            work += stepper_event(c, a, a->watch_next_ns < until_ns ? a->watch_next_ns : until_ns);
        } else view_sample(a);
    }
    if (a->loop_on) return work; /* the plant's next node is the next control step's: who looks before steps a copy */
    if (a->stepper) stepper_plant(a, t_ns);
    else shaft_run(a, t_ns);
    return work;
}

int axis_is_idle(const hil_axis *a)
{
    if (!(a->is_full ? a->full.at_rest : a->plant.at_rest) || (a->stepper && a->stepper->is_turned)) return 0;
    return axis_next_ns(a) == HIL_FOREVER;
}

int hil_axis_open(hil_core *c, int group, const hil_axis_params *params)
{
    int axis = 0;
    while (axis < c->max_axes && c->axes[axis].open) axis++;
    if (axis == c->max_axes) return -1;
    int64_t now_ns = atomic_load(&c->groups[group].now_ns);
    plant simple = {0};
    full full = {0};
    double amps_per_count = 3.3 / 255 / (10 * params->sense_resistor_ohm), max_current_A = 255 * amps_per_count;
    if (params->law == HIL_LAW_SAC) max_current_A = params->phase_current_A;
    if (params->is_full ? full_init(&full, params, max_current_A, now_ns)
                        : plant_init(&simple, params->inertia_kg_m2, params->viscous_Nm_s_per_rad,
                                     params->torque_constant_Nm_per_A, params->rotor_teeth, max_current_A,
                                     params->start_deg / 360, params->load_torque_Nm, now_ns))
        return -2;
    hil_axis *a = &c->axes[axis];
    memset((char *)a + offsetof(hil_axis, open), 0, sizeof *a - offsetof(hil_axis, open));
    if (atomic_load(&c->rt.running)) (void)rt_lock_axis(c, axis); /* what was refused was said at the start */
    a->open = 1;
    a->is_full = params->is_full;
    a->plant = simple;
    a->full = full;
    a->group = group;
    a->next_in_group = c->groups[group].first_axis;
    a->order = a->next_in_group < 0 ? 0 : c->axes[a->next_in_group].order + 1;
    c->groups[group].first_axis = axis;
    a->amps_per_count = amps_per_count;
    a->load_torque_Nm = params->load_torque_Nm;
    a->encoder.previous_command = 0xFFFF;
    a->source.next_ns = a->watch_next_ns = HIL_FOREVER;
    if (params->law == HIL_LAW_SAC && stepper_open(a, params)) {
        a->open = 0;
        return -1;
    }
    if (a->stepper && !a->is_full) plant_halve(&a->plant);
    hil_axis_power_up(c, axis);
    view_publish(a, now_ns);
    return axis;
}

void axis_close(hil_axis *a)
{
    (void)encoder_script(&a->encoder, 0, NULL, NULL, 0);
    (void)source_start(&a->source, 0, 0, NULL);
    (void)follow_start(&a->follow, 0, 0, NULL);
    for (int i = 0; i < HIL_WATCHES; i++) (void)watch_start(&a->watches[i], 0, 0, 0, 0);
    stepper_close(a);
    a->open = 0;
}

void hil_axis_power_up(hil_core *c, int axis)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    if (a->stepper) stepper_power_up(c, a, now_ns);
    else servo_power_up(a, now_ns);
}

int hil_axis_set(hil_core *c, int axis, hil_field field, double value)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    if (field >= HIL_FIELDS || hil_field_table[field].kind == (a->stepper ? HIL_KIND_SERVO : HIL_KIND_STEPPER)) return -1;
    switch (field) {
    case HIL_FIELD_load_torque_Nm:
        axis_node(a, now_ns);
        a->load_torque_Nm = value;
        shaft_set_load(a);
        return 0;
    case HIL_FIELD_clock_Hz: /* beyond 1 THz nothing changes: no pulse is shorter than 2 us */
        motion_clock(&a->stepper->motion, (int64_t)fmin(fmax(value, -1), 1e12), (now_ns + 499) / 500);
        return 0;
    case HIL_FIELD_diaagc: a->encoder.diaagc = servo_i32(value); return 0;
    case HIL_FIELD_errfl: a->encoder.errfl = servo_i32(value); return 0;
    case HIL_FIELD_spi_previous_command: a->encoder.previous_command = servo_i32(value); return 0;
    default:
        if (field == HIL_FIELD_mode || field == HIL_FIELD_r) follow_end(&a->follow);
        return servo_set(&a->law, field, value);
    }
}
