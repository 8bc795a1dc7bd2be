#include "servo.h"

#include <math.h>

#include "../core.h"
#include "../hil_core.h"
#include "../shaft.h"

const servo *servo_view(const hil_axis *a)
{
    static const servo none = {0};
    const servo *s = servo_of(a);
    return s ? s : &none;
}

/* Of an A4954, with figures of the data sheet of its kin A4952 and A4953: shutdown at 160 degC, 20 K of hysteresis; both
   switches of a bridge have 0.8 ohm at 25 degC and 1.3 ohm at 125 degC, here taken hot. Chosen: 35 K/W, for its package with a thermal pad on a board of
   four layers, and how long it takes to warm up. Its own 10 mA and what switching costs are left out. */
static const heat_limits LIMITS = {.hot_degC = 160, .cool_degC = 140, .K_per_W = 35, .warming_s = 10};
static const double BRIDGE_OHM = 1.3;

/* Control step k of the loop. */
static int64_t step_time_ns(const servo *s, int64_t k)
{
    int64_t whole = k / MECHADUINO_STEP_DEN, part = k % MECHADUINO_STEP_DEN;
    return s->loop_since_ns + whole * MECHADUINO_STEP_NUM_NS + part * MECHADUINO_STEP_NUM_NS / MECHADUINO_STEP_DEN;
}

/* The law's currents, at a node. */
static void drive(hil_axis *a)
{
    const servo *s = a->own;
    double a_A, b_A;
    servo_currents(s, &a_A, &b_A);
    shaft_set_currents(a, a_A, b_A);
}

/* ---- heat ---- */

/* By the currents that its choppers are told; their squares have the same sum at each angle. */
static double power_W(const hil_axis *a)
{
    const axis_fault *f = &a->fault;
    double a_A, b_A;
    servo_currents(a->own, &a_A, &b_A);
    if (f->is_too_hot || f->is_open_a) a_A = 0;
    if (f->is_too_hot || f->is_open_b) b_A = 0;
    return BRIDGE_OHM * (a_A * a_A + b_A * b_A);
}

/* After a change of the currents, and at looks: while the loop runs they are taken as those of the last look. */
static void warm(hil_axis *a, int64_t now_ns)
{
    servo *s = a->own;
    heat *h = &s->heat;
    if (!h->limits) return;
    heat_to(h, now_ns);
    if (h->is_too_hot != a->fault.is_too_hot) {
        shaft_node(a, now_ns);
        a->fault.is_too_hot = h->is_too_hot;
        shaft_sum_faults(a);
        drive(a);
    }
    h->power_W = power_W(a);
    a->heat_next_ns = s->loop_on || heat_is_on_its_way(h) ? (now_ns / HEAT_LOOK_NS + 1) * HEAT_LOOK_NS : HIL_FOREVER;
    if (a->heat_next_ns < a->watch_next_ns) a->watch_next_ns = a->heat_next_ns;
}

static void drive_again(hil_axis *a)
{
    drive(a);
    warm(a, shaft_node_ns(a));
}

/* ---- the loop ---- */

static void set_loop(hil_axis *a, servo *s, int on, int64_t now_ns)
{
    if (on && !s->loop_on) {
        s->loop_since_ns = now_ns;
        s->loop_steps = 0;
        a->law_next_ns = step_time_ns(s, 1);
    }
    if (!on) {
        follow_end(&s->follow);
        a->law_next_ns = HIL_FOREVER;
    }
    s->loop_on = a->is_pacing = on != 0;
    warm(a, now_ns);
}

static void control_step(hil_core *c, hil_axis *a, servo *s)
{
    int64_t at_ns = a->law_next_ns;
    shaft_node(a, at_ns);
    if (s->follow.n) follow_step(&s->follow, at_ns, &s->law.r);
    int raw = shaft_raw_at_node(a, at_ns);
    int count = encoder_exchange(&a->encoder, 0xFFFF, raw) & 16383;
    if (s->is_own_law) {
        mechaduino_measure(&s->law, s->table, count);
        core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_CONTROL, (double)s->law.yw);
    } else {
        float y;
        int print = mechaduino_step(&s->law, c->sine, s->table, count, &y);
        drive(a);
        if (print) core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_STEP_RESPONSE, (double)(s->law.yw * 1024));
    }
    s->control_steps++;
    a->law_next_ns = step_time_ns(s, ++s->loop_steps + 1);
}

static int64_t control_steps(hil_core *c, hil_axis *a, int64_t until_ns)
{
    servo *s = a->own;
    for (int64_t more = 0;; more++) {
        control_step(c, a, s);
        if (a->law_next_ns > until_ns) return more;
    }
}

static double amps_per_count(const hil_axis_params *params) { return 3.3 / 255 / (10 * params->sense_resistor_ohm); }

static double max_current_A(const hil_axis_params *params) { return 255 * amps_per_count(params); }

static void open_servo(hil_axis *a, const hil_axis_params *params)
{
    servo *s = a->own;
    s->amps_per_count = amps_per_count(params);
    heat_open(&s->heat, isnan(params->ambient_degC) ? NULL : &LIMITS, params->ambient_degC);
}

static void close_servo(hil_axis *a)
{
    servo *s = a->own;
    (void)follow_start(&s->follow, 0, 0, NULL);
}

static void power_up(hil_core *c, hil_axis *a, int64_t now_ns)
{
    (void)c;
    servo *s = a->own;
    heat_begin(&s->heat, now_ns);
    shaft_node(a, now_ns);
    mechaduino_power_up(&s->law);
    s->is_own_law = s->is_own_step = 0;
    mechaduino_dir_pin(&s->law, s->pins.dir); /* by the level, unless a firmware has it otherwise */
    a->is_telling = 0;
    set_loop(a, s, 0, now_ns);
    s->control_steps = 0;
    drive_again(a);
}

static void set_vref(hil_axis *a, servo *s, int vref1, int vref2, int64_t at_ns)
{
    shaft_node(a, at_ns);
    s->law.pins.vref1 = vref1;
    s->law.pins.vref2 = vref2;
    drive_again(a);
}

/* Stock firmware leaves the three interrupts commented out; the twin has them on its inputs always. */
static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    servo *s = a->own;
    switch (pin) {
    case HIL_SERVO_IN_DIR:
        if (level != s->pins.dir) mechaduino_dir_pin(&s->law, level);
        s->pins.dir = level;
        break;
    case HIL_SERVO_IN_STEP:
        if (level && !s->pins.step) {
            if (s->is_own_step) core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_STEP, 1);
            else mechaduino_step_pin(&s->law);
        }
        s->pins.step = level;
        break;
    case HIL_SERVO_IN_ENABLE:
        if (level == s->pins.enable) break;
        s->pins.enable = level;
        set_loop(a, s, !level, at_ns);
        if (level) set_vref(a, s, 0, 0, at_ns);
        core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_ENABLE, level);
        break;
    default:
        s->pins.d3 = level;
    }
}

/* ---- the firmware's face ---- */

void hil_axis_output(hil_core *c, int axis, float theta_deg, int effort)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    servo *s = servo_of(a);
    if (!s) return;
    shaft_node(a, now_ns);
    mechaduino_output(&s->law, c->sine, theta_deg, effort);
    drive_again(a);
}

void hil_axis_vref(hil_core *c, int axis, int vref1, int vref2)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    servo *s = servo_of(a);
    if (s) set_vref(a, s, vref1, vref2, now_ns);
}

void hil_axis_loop(hil_core *c, int axis, int on)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    servo *s = servo_of(a);
    if (s) set_loop(a, s, on, now_ns);
}

float *hil_axis_table(hil_core *c, int axis)
{
    servo *s = servo_of(&c->axes[axis]);
    return s ? s->table : NULL;
}

int hil_axis_follow(hil_core *c, int axis, int64_t start_ns, int n, const hil_path_piece *pieces)
{
    int64_t now_ns;
    hil_axis *a = core_axis_stirred(c, axis, &now_ns);
    servo *s = servo_of(a);
    return s ? follow_start(&s->follow, start_ns > now_ns ? start_ns : now_ns, n, pieces) : -3;
}

/* The nearest that fits, toward 0; NaN: 0. C leaves both undefined. */
static int32_t to_i32(double x)
{
    if (isnan(x)) return 0;
    return x >= INT32_MAX ? INT32_MAX : x <= INT32_MIN ? INT32_MIN : (int32_t)x;
}

int servo_set(mechaduino *m, hil_field field, double value)
{
    switch (field) {
    case HIL_FIELD_mode: m->mode = to_i32(value); return 0;
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
    case HIL_FIELD_uMAX: m->uMAX = to_i32(value); return 0;
    case HIL_FIELD_dir: m->dir = value != 0; return 0;
    case HIL_FIELD_print_yw: m->print_yw = value != 0; return 0;
    default: return -1;
    }
}

static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    (void)now_ns;
    servo *s = a->own;
    switch (field) {
    case HIL_FIELD_diaagc: a->encoder.diaagc = to_i32(value); return 0;
    case HIL_FIELD_errfl: a->encoder.errfl = to_i32(value); return 0;
    case HIL_FIELD_spi_previous_command: a->encoder.previous_command = to_i32(value); return 0;
    default:
        if (field == HIL_FIELD_mode || field == HIL_FIELD_r) follow_end(&s->follow);
        if (servo_set(&s->law, field, value)) return -1;
        a->is_telling = s->law.print_yw || s->is_own_law;
        return 0;
    }
}

static double act(hil_core *c, hil_axis *a, int call, double x, double y, double z)
{
    (void)c;
    (void)y;
    (void)z;
    servo *s = a->own;
    switch (call) {
    case HIL_SERVO_CALL_SPR: mechaduino_set_spr(&s->law, to_i32(x)); return 0;
    case HIL_SERVO_CALL_OWN_LAW:
        s->is_own_law = x != 0;
        a->is_telling = s->law.print_yw || s->is_own_law;
        return 0;
    case HIL_SERVO_CALL_OWN_STEP: s->is_own_step = x != 0; return 0;
    case HIL_SERVO_CALL_U: s->law.u = (float)x; return 0;
    case HIL_SERVO_CALL_E: s->law.e = (float)x; return 0;
    default: return -1;
    }
}

const law mechaduino_law = {
    .bytes = sizeof(servo) + HIL_TABLE_LEN * sizeof(float),
    .kind = HIL_KIND_SERVO,
    .events = RING_MOST, /* j posts 650 in half a second */
    .max_current_A = max_current_A,
    .open = open_servo,
    .close = close_servo,
    .power_up = power_up,
    .step = control_steps,
    .drive = drive_again,
    .warm = warm,
    .pin = set_pin,
    .act = act,
    .set = set,
};
