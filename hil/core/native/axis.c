/* An axis: law, driver, motor and encoder joined. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "core.h"
#include "motion/profile.h"

enum { KIND_ANY, KIND_SERVO, KIND_STEPPER };

const hil_field_info hil_field_table[HIL_FIELDS] = {
#define RO 0
#define RW 1
#define BOTH KIND_ANY
#define SERVO KIND_SERVO
#define STEPPER KIND_STEPPER
#define X(name, type, kind, access, unit, expression, meaning) {#name, #type, unit, meaning, offsetof(hil_snapshot, name), access, kind},
#include "fields.def"
#undef X
#undef RO
#undef RW
#undef BOTH
#undef SERVO
#undef STEPPER
};

static int shaft_raw(double rev)
{
    if (!(fabs(rev) < 0x1p51)) return 0; /* run away under an absurd load */
    return (int)((rev - floor_of(rev)) * 16384) & 16383;
}

/* What a faulty encoder makes of a count. */
static int faulty_raw(const hil_axis *a, int raw, int64_t t_ns)
{
    if (!a->is_faulty) return raw;
    double noise = full_noise(a->fault.noise_key, a->fault.noise_counts, (uint64_t)t_ns);
    return (raw + a->fault.slip_counts + (int)floor(noise + 0.5)) & 16383;
}

/* What is read of an encoder that does not see the shaft; -1: it sees it. */
static int blind_raw(const hil_axis *a, int64_t t_ns)
{
    if (a->fault.is_line_open) return 16383;
    if (a->fault.is_frozen) return a->fault.frozen_raw;
    return a->encoder.script_len ? encoder_scripted_raw(&a->encoder, t_ns) : -1;
}

int axis_raw(const hil_axis *a, int64_t t_ns)
{
    int raw = blind_raw(a, t_ns);
    if (raw >= 0) return raw;
    if (!a->is_full) return faulty_raw(a, shaft_raw(plant_at(&a->plant, t_ns).rev), t_ns);
    full now = full_at(&a->full, t_ns);
    return faulty_raw(a, full_raw(&now, t_ns), t_ns);
}

/* ---- the plant, whichever it is ---- */

void axis_run_plant(hil_axis *a, int64_t t_ns)
{
    if (a->is_full) full_advance(&a->full, t_ns);
    else plant_advance(&a->plant, t_ns);
}

void axis_make_node(hil_axis *a, int64_t t_ns)
{
    if (a->stepper) stepper_plant(a, t_ns);
    if (a->is_full) full_node(&a->full, t_ns);
    else plant_node(&a->plant, t_ns);
}

void axis_set_currents(hil_axis *a, double a_A, double b_A)
{
    a->fault.told_a_A = a_A;
    a->fault.told_b_A = b_A;
    if (a->fault.is_open_a) a_A = 0;
    if (a->fault.is_open_b) b_A = 0;
    if (a->is_full) full_set_currents(&a->full, a_A, b_A);
    else plant_set_currents(&a->plant, a_A, b_A);
}

void axis_load(hil_axis *a)
{
    double load_Nm = a->load_torque_Nm + a->fault.load_Nm;
    if (a->is_full) full_set_load(&a->full, load_Nm);
    else plant_set_load(&a->plant, load_Nm);
}

static double load_torque_Nm(const hil_axis *a) { return a->is_full ? a->full.load_torque_Nm : a->plant.load_torque_Nm; }

static int parity(unsigned v)
{
    return __builtin_parity(v & 0x7FFF);
}

/* The answer to the frame before, as the AS5047D's pipeline has it; the angle is that of now. While the error
   register holds anything every answer says so, the one that reads and clears it too. */
static int spi_exchange(hil_axis *a, int command, int raw)
{
    int value = 0, error = a->encoder.errfl ? SPI_EF : 0;
    switch (a->encoder.previous_command & 0x3FFF) {
    case SPI_ANGLE: value = raw; break;
    case SPI_DIAAGC: value = a->encoder.diaagc; break;
    case SPI_ERRFL:
        value = a->encoder.errfl;
        a->encoder.errfl = 0;
        break;
    }
    a->encoder.previous_command = command;
    value |= error;
    return value | parity((unsigned)value) << 15;
}

void axis_drive(hil_axis *a)
{
    double a_A, b_A;
    axis_currents(a, &a_A, &b_A);
    axis_set_currents(a, a_A, b_A);
}

static void set_loop(hil_axis *a, int on, int64_t now_ns)
{
    if (on && !a->loop_on) {
        a->loop_since_ns = now_ns;
        a->loop_steps = 0;
        a->next_step_ns = axis_step_time_ns(a, 1);
    }
    a->loop_on = on != 0;
    if (!on) follow_end(a);
}

static void control_step(hil_core *c, hil_axis *a, int axis)
{
    int64_t at_ns = a->next_step_ns;
    axis_make_node(a, at_ns);
    if (a->follow.n) follow_step(a, at_ns);
    int raw = blind_raw(a, at_ns);
    if (raw < 0)
        raw = faulty_raw(a, a->is_full ? full_raw(&a->full, at_ns) : shaft_raw(a->plant.moving.rev), at_ns);
    float y;
    int print = mechaduino_step(&a->law, c->sine, a->table, spi_exchange(a, 0xFFFF, raw) & 16383, &y);
    axis_drive(a);
    if (print) core_post(c, axis, at_ns, HIL_EVENT_STEP_RESPONSE, (double)(a->law.yw * 1024));
    axis_stepped(a);
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
        if (a->source.next_ns == next_ns) source_edge(c, a, axis);
        else if (a->loop_on && a->next_step_ns == next_ns) control_step(c, a, axis);
        else if (a->stepper && stepper_next_ns(a) == next_ns) {
            int64_t until_ns = a->source.next_ns <= t_ns ? a->source.next_ns - 1 : t_ns;
            work += stepper_event(c, a, a->watch_next_ns < until_ns ? a->watch_next_ns : until_ns);
        } else watch_sample(a);
    }
    if (a->loop_on) return work; /* the plant's next node is the next control step's: who looks before steps a copy */
    if (a->stepper) stepper_plant(a, t_ns);
    else axis_run_plant(a, t_ns);
    return work;
}

int axis_is_idle(const hil_axis *a)
{
    if (!(a->is_full ? a->full.at_rest : a->plant.at_rest) || (a->stepper && a->stepper->is_turned)) return 0;
    return axis_next_ns(a) == HIL_FOREVER;
}

/* ---- the firmware's and the daemon's face ---- */

static hil_axis *at(hil_core *c, int axis, int64_t *now_ns)
{
    hil_axis *a = &c->axes[axis];
    *now_ns = atomic_load_explicit(&c->groups[a->group].now_ns, memory_order_relaxed);
    return a;
}

/* For what changes the axis. */
hil_axis *axis_stirred(hil_core *c, int axis, int64_t *now_ns)
{
    core_stir(c, axis);
    return at(c, axis, now_ns);
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
    axis_publish(a, now_ns);
    return axis;
}

void hil_axis_power_up(hil_core *c, int axis)
{
    int64_t now_ns;
    hil_axis *a = axis_stirred(c, axis, &now_ns);
    if (a->stepper) {
        stepper_power_up(c, a, now_ns);
        return;
    }
    axis_make_node(a, now_ns);
    mechaduino_power_up(&a->law);
    set_loop(a, 0, now_ns);
    a->control_steps = 0;
    axis_drive(a);
}

void hil_axis_output(hil_core *c, int axis, float theta_deg, int effort)
{
    int64_t now_ns;
    hil_axis *a = axis_stirred(c, axis, &now_ns);
    axis_make_node(a, now_ns);
    mechaduino_output(&a->law, c->sine, theta_deg, effort);
    axis_drive(a);
}

static void set_vref(hil_axis *a, int vref1, int vref2, int64_t at_ns)
{
    axis_make_node(a, at_ns);
    a->law.pins.vref1 = vref1;
    a->law.pins.vref2 = vref2;
    axis_drive(a);
}

void hil_axis_vref(hil_core *c, int axis, int vref1, int vref2)
{
    int64_t now_ns;
    hil_axis *a = axis_stirred(c, axis, &now_ns);
    set_vref(a, vref1, vref2, now_ns);
}

void hil_axis_loop(hil_core *c, int axis, int on)
{
    int64_t now_ns;
    hil_axis *a = axis_stirred(c, axis, &now_ns);
    set_loop(a, on, now_ns);
}

int hil_axis_spi(hil_core *c, int axis, int command)
{
    int64_t now_ns;
    hil_axis *a = at(c, axis, &now_ns);
    a->is_shown = 0; /* reading changes registers */
    return spi_exchange(a, command, axis_raw(a, now_ns));
}

float *hil_axis_table(hil_core *c, int axis) { return c->axes[axis].table; }

/* Stock firmware leaves the three interrupts commented out; the twin has them on its inputs always. */
void axis_pin(hil_core *c, int axis, int pin, int level, int64_t at_ns)
{
    hil_axis *a = &c->axes[axis];
    core_stir(c, axis);
    level = level != 0;
    if (a->stepper) {
        stepper_pin(c, a, pin, level, at_ns);
        return;
    }
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

void hil_axis_pin(hil_core *c, int axis, int pin, int level)
{
    int64_t now_ns;
    at(c, axis, &now_ns);
    axis_pin(c, axis, pin, level, now_ns);
}

static const motion *motion_of(const hil_axis *a)
{
    static const motion none = {.slot = -1};
    return a->stepper ? &a->stepper->motion : &none;
}

static int64_t motion_rpm(const motion *m) { return m->state ? profile_rpm(m) : 0; }
static int64_t motion_period_us(const motion *m) { return m->state ? m->period_us : 0; }
static int motion_loop_kind(const motion *m) { return m->array.is_on ? 2 : m->loop.is_on; }
static int64_t motion_passes(const motion *m) { return m->array.is_on ? m->array.passes : m->loop.passes; }

static void fill_view(hil_axis *a, int64_t now_ns)
{
    if (a->stepper) stepper_plant(a, now_ns);
    if (a->is_full) {
        full f = full_at(&a->full, now_ns);
        a->view.rev = f.moving.state.rev;
        a->view.rev_per_s = f.moving.state.rev_per_s;
        a->view.torque_Nm = full_motor_torque_Nm(&f);
        a->view.a_A = f.moving.state.a_A;
        a->view.b_A = f.moving.state.b_A;
        a->view.a_V = f.moving.a_V;
        a->view.b_V = f.moving.b_V;
        a->view.energy = f.moving.energy;
        a->view.raw = faulty_raw(a, full_raw(&f, now_ns), now_ns);
    } else {
        plant_shaft s = plant_at(&a->plant, now_ns);
        a->view.rev = s.rev;
        a->view.rev_per_s = s.rev_per_s;
        a->view.torque_Nm = plant_motor_torque_Nm(&a->plant, s.rev);
        a->view.a_A = a->plant.current_a_A;
        a->view.b_A = a->plant.current_b_A;
        a->view.raw = faulty_raw(a, shaft_raw(s.rev), now_ns);
    }
    int blind = blind_raw(a, now_ns);
    if (blind >= 0) a->view.raw = blind;
}

void axis_fill(hil_axis *a, int64_t now_ns, hil_snapshot *out)
{
    memset(out, 0, sizeof *out);
    fill_view(a, now_ns);
#define X(name, type, kind, access, unit, expression, meaning) out->name = expression;
#include "fields.def"
#undef X
}

void hil_axis_snapshot(hil_core *c, int axis, hil_snapshot *out)
{
    int64_t now_ns;
    hil_axis *a = at(c, axis, &now_ns);
    axis_fill(a, now_ns, out);
}

/* Groups of hundreds are published often, and most axes of a line of boards stand still. */
void axis_publish(hil_axis *a, int64_t now_ns)
{
    int stays = !a->is_active && !a->encoder.script_len && a->fault.noise_counts == 0;
    if (stays && a->is_shown) {
        uint64_t word = (uint64_t)now_ns;
        seqlock_write(&a->published_lock, a->published + offsetof(hil_snapshot, at_ns) / sizeof word, &word, 1);
        return;
    }
    a->is_shown = stays;
    union { hil_snapshot s; uint64_t words[SNAPSHOT_WORDS]; } u = {.words = {0}};
    axis_fill(a, now_ns, &u.s);
    seqlock_write(&a->published_lock, a->published, u.words, SNAPSHOT_WORDS);
}

void hil_axis_published(const hil_core *c, int axis, hil_snapshot *out)
{
    union { hil_snapshot s; uint64_t words[SNAPSHOT_WORDS]; } u;
    seqlock_read(&c->axes[axis].published_lock, c->axes[axis].published, u.words, SNAPSHOT_WORDS);
    *out = u.s;
}

double hil_axis_get(hil_core *c, int axis, hil_field field)
{
    int64_t now_ns;
    hil_axis *a = at(c, axis, &now_ns);
    if (field <= HIL_FIELD_raw || (field >= HIL_FIELD_voltage_a_V && field <= HIL_FIELD_lag_steps)) fill_view(a, now_ns);
    switch (field) {
#define X(name, type, kind, access, unit, expression, meaning) case HIL_FIELD_##name: return (double)(expression);
#include "fields.def"
#undef X
    default: return NAN;
    }
}

/* C leaves the conversion of a NaN and of what does not fit undefined. */
static int32_t to_i32(double x)
{
    if (isnan(x)) return 0;
    return x >= INT32_MAX ? INT32_MAX : x <= INT32_MIN ? INT32_MIN : (int32_t)x;
}

static int set_law(mechaduino *m, hil_field field, double value)
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
    case HIL_FIELD_print_yw: m->print_yw = value != 0; return 0;
    default: return -1;
    }
}

int hil_axis_set(hil_core *c, int axis, hil_field field, double value)
{
    int64_t now_ns;
    hil_axis *a = axis_stirred(c, axis, &now_ns);
    if (field >= HIL_FIELDS || hil_field_table[field].kind == (a->stepper ? KIND_SERVO : KIND_STEPPER)) return -1;
    switch (field) {
    case HIL_FIELD_load_torque_Nm:
        axis_make_node(a, now_ns);
        a->load_torque_Nm = value;
        axis_load(a);
        return 0;
    case HIL_FIELD_clock_Hz: /* beyond 1 THz nothing changes: no pulse is shorter than 2 us */
        motion_clock(&a->stepper->motion, (int64_t)fmin(fmax(value, -1), 1e12), (now_ns + 499) / 500);
        return 0;
    case HIL_FIELD_diaagc: a->encoder.diaagc = to_i32(value); return 0;
    case HIL_FIELD_errfl: a->encoder.errfl = to_i32(value); return 0;
    case HIL_FIELD_spi_previous_command: a->encoder.previous_command = to_i32(value); return 0;
    default:
        if (field == HIL_FIELD_mode || field == HIL_FIELD_r) follow_end(a);
        return set_law(&a->law, field, value);
    }
}

/* ---- the law alone ---- */

struct hil_replay {
    mechaduino law;
    int16_t sine[MECHADUINO_SINE_LEN];
    float table[HIL_TABLE_LEN];
};

hil_replay *hil_replay_new(const float *table)
{
    hil_replay *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    mechaduino_sine(p->sine);
    mechaduino_power_up(&p->law);
    memcpy(p->table, table, sizeof p->table);
    return p;
}

int hil_replay_set(hil_replay *p, hil_field field, double value) { return set_law(&p->law, field, value); }

static void fill_row(const hil_replay *p, float y, hil_replay_row *row)
{
    const mechaduino *m = &p->law;
    const mechaduino_pins *n = &m->pins;
    *row = (hil_replay_row){.y_meas = y, .y_excite = m->y, .yw = m->yw, .e = m->e, .ITerm = m->ITerm, .DTerm = m->DTerm,
                            .v = m->v, .u = m->u, .U = m->U, .wrap_count = m->wrap_count,
                            .vref1 = (int16_t)n->vref1, .vref2 = (int16_t)n->vref2, .in1 = (int8_t)n->in1,
                            .in2 = (int8_t)n->in2, .in3 = (int8_t)n->in3, .in4 = (int8_t)n->in4,
                            .led = (int8_t)m->led};
}

void hil_replay_step(hil_replay *p, int raw, hil_replay_row *row)
{
    float y;
    mechaduino_step(&p->law, p->sine, p->table, raw & 16383, &y);
    fill_row(p, y, row);
}

void hil_replay_output(hil_replay *p, float theta_deg, int effort, hil_replay_row *row)
{
    mechaduino_output(&p->law, p->sine, theta_deg, effort);
    fill_row(p, 0, row);
}

void hil_replay_free(hil_replay *p) { free(p); }
