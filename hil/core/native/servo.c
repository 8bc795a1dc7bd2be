#include "servo.h"

#include <math.h>

#include "core.h"
#include "hil_core.h"
#include "shaft.h"

/* Control step k of the loop. */
static int64_t step_time_ns(const hil_axis *a, int64_t k)
{
    int64_t whole = k / MECHADUINO_STEP_DEN, part = k % MECHADUINO_STEP_DEN;
    return a->loop_since_ns + whole * MECHADUINO_STEP_NUM_NS + part * MECHADUINO_STEP_NUM_NS / MECHADUINO_STEP_DEN;
}

void servo_drive(hil_axis *a)
{
    double a_A, b_A;
    servo_currents(a, &a_A, &b_A);
    shaft_set_currents(a, a_A, b_A);
}

static void set_loop(hil_axis *a, int on, int64_t now_ns)
{
    if (on && !a->loop_on) {
        a->loop_since_ns = now_ns;
        a->loop_steps = 0;
        a->next_step_ns = step_time_ns(a, 1);
    }
    a->loop_on = on != 0;
    if (!on) follow_end(&a->follow);
}

void servo_step(hil_core *c, hil_axis *a, int axis)
{
    int64_t at_ns = a->next_step_ns;
    shaft_node(a, at_ns);
    if (a->follow.n) follow_step(&a->follow, at_ns, &a->law.r);
    int raw = shaft_raw_at_node(a, at_ns);
    float y;
    int print = mechaduino_step(&a->law, c->sine, a->table, encoder_exchange(&a->encoder, 0xFFFF, raw) & 16383, &y);
    servo_drive(a);
    if (print) core_post(c, axis, at_ns, HIL_EVENT_STEP_RESPONSE, (double)(a->law.yw * 1024));
    a->control_steps++;
    a->next_step_ns = step_time_ns(a, ++a->loop_steps + 1);
}

void servo_power_up(hil_axis *a, int64_t now_ns)
{
    shaft_node(a, now_ns);
    mechaduino_power_up(&a->law);
    set_loop(a, 0, now_ns);
    a->control_steps = 0;
    servo_drive(a);
}

static void set_vref(hil_axis *a, int vref1, int vref2, int64_t at_ns)
{
    shaft_node(a, at_ns);
    a->law.pins.vref1 = vref1;
    a->law.pins.vref2 = vref2;
    servo_drive(a);
}

/* Stock firmware leaves the three interrupts commented out; the twin has them on its inputs always. */
void servo_pin(hil_core *c, hil_axis *a, int axis, int pin, int level, int64_t at_ns)
{
    switch (pin) {
    case 0:
        a->pins.dir = level;
        break;
    case 1:
        if (level && !a->pins.step) mechaduino_step_pin(&a->law, a->pins.dir);
        a->pins.step = level;
        break;
    case 2:
        if (level == a->pins.enable) break;
        a->pins.enable = level;
        set_loop(a, !level, at_ns);
        if (level) set_vref(a, (int)(0.33 * a->law.uMAX), (int)(0.33 * a->law.uMAX), at_ns);
        core_post(c, axis, at_ns, HIL_EVENT_ENABLE, level);
        break;
    default:
        a->pins.d3 = level;
    }
}

/* ---- the firmware's face ---- */

void hil_axis_output(hil_core *c, int axis, float theta_deg, int effort)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    shaft_node(a, now_ns);
    mechaduino_output(&a->law, c->sine, theta_deg, effort);
    servo_drive(a);
}

void hil_axis_vref(hil_core *c, int axis, int vref1, int vref2)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    set_vref(a, vref1, vref2, now_ns);
}

void hil_axis_loop(hil_core *c, int axis, int on)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    set_loop(a, on, now_ns);
}

int hil_axis_spi(hil_core *c, int axis, int command)
{
    int64_t now_ns;
    hil_axis *a = core_axis(c, axis, &now_ns);
    a->is_shown = 0; /* reading changes registers */
    return encoder_exchange(&a->encoder, command, shaft_raw(a, now_ns));
}

float *hil_axis_table(hil_core *c, int axis) { return c->axes[axis].table; }

int hil_axis_follow(hil_core *c, int axis, int64_t start_ns, int n, const hil_path_piece *pieces)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    return follow_start(&a->follow, start_ns > now_ns ? start_ns : now_ns, n, pieces);
}

int32_t servo_i32(double x)
{
    if (isnan(x)) return 0;
    return x >= INT32_MAX ? INT32_MAX : x <= INT32_MIN ? INT32_MIN : (int32_t)x;
}

int servo_set(mechaduino *m, hil_field field, double value)
{
    switch (field) {
    case HIL_FIELD_mode: m->mode = servo_i32(value); return 0;
    case HIL_FIELD_r: m->r = (float)value; return 0;
    case HIL_FIELD_pKp: m->pKp = (float)value; return 0;
    case HIL_FIELD_pKi: m->pKi = (float)value; return 0;
    case HIL_FIELD_pKd: m->pKd = (float)value; return 0;
    case HIL_FIELD_pLPF: mechaduino_set_pLPF(m, (float)value); return 0;
    case HIL_FIELD_vKp: m->vKp = (float)value; return 0;
    case HIL_FIELD_vKi: m->vKi = (float)value; return 0;
    case HIL_FIELD_vKd: m->vKd = (float)value; return 0;
    case HIL_FIELD_vLPF: mechaduino_set_vLPF(m, (float)value); return 0;
    case HIL_FIELD_PA: m->PA = (float)value; return 0;
    case HIL_FIELD_uMAX: m->uMAX = servo_i32(value); return 0;
    case HIL_FIELD_print_yw: m->print_yw = value != 0; return 0;
    default: return -1;
    }
}
