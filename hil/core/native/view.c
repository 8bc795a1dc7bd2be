#include "view.h"

#include <math.h>
#include <string.h>

#include "core.h"
#include "hil_core.h"
#include "laws.h"
#include "motion/profile.h"

const hil_field_info hil_field_table[HIL_FIELDS] = {
#define RO 0
#define RW 1
#define X(name, type, kind, access, unit, expression, meaning) {#name, #type, unit, meaning, offsetof(hil_snapshot, name), access, HIL_KIND_##kind},
#include "fields.def"
#undef X
#undef RO
#undef RW
};

static const motion *motion_of(const hil_axis *a)
{
    static const motion none = {.slot = -1};
    const stepper *s = stepper_of(a);
    return s ? &s->motion : &none;
}

static int64_t motion_rpm(const motion *m) { return m->state ? profile_rpm(m) : 0; }
static int64_t motion_period_us(const motion *m) { return m->state ? m->period_us : 0; }
static int motion_loop_kind(const motion *m) { return m->array.is_on ? 2 : m->loop.is_on; }
static int64_t motion_passes(const motion *m) { return m->array.is_on ? m->array.passes : m->loop.passes; }

/* Where the currents of a stepper or a driver pull the rotor to, and the teeth of that; others have none. */
static double commanded_rev(const hil_axis *a, int *teeth)
{
    const stepper *s = stepper_of(a);
    const a3967 *d = driver_view(a);
    *teeth = s ? s->teeth : d->teeth;
    return s ? stepper_commanded_rev(s) : driver_commanded_rev(d);
}

static double commanded_deg(const hil_axis *a)
{
    int teeth;
    double rev = commanded_rev(a, &teeth);
    return teeth ? (rev - a->zero_rev) * 360 : 0;
}

static double lag_steps(const hil_axis *a)
{
    int teeth;
    double rev = commanded_rev(a, &teeth);
    return teeth ? (rev - a->view.rev) * 4 * teeth : 0;
}

static const slip *slip_of(const hil_axis *a)
{
    const stepper *s = stepper_of(a);
    return s ? &s->slip : &driver_view(a)->slip;
}

/* A rotor that has lost its step rests a whole number of teeth away. */
static int64_t lost_steps(const hil_axis *a) { return (int64_t)(4 * nearbyint(lag_steps(a) / 4)); }

static const heat *heat_of(const hil_axis *a)
{
    const a3967 *d = driver_of(a);
    return d ? &d->heat : &servo_view(a)->heat;
}

static int step_dir_level(const hil_axis *a, int pin)
{
    const a3967 *d = driver_of(a);
    const servo *s = servo_view(a);
    if (d) return d->pins[pin];
    return pin == HIL_DRIVER_IN_STEP ? s->pins.step : pin == HIL_DRIVER_IN_DIR ? s->pins.dir : s->pins.enable;
}

static int clk_level(const hil_axis *a, int64_t now_ns)
{
    return a->law == &as5047d_law ? as5047d_view(a)->pins[HIL_SPI_IN_CLK] : stepper_out(a, HIL_OUT_CLK, now_ns);
}

static double reversal_us(const hil_axis *a)
{
    const a3967 *d = driver_of(a);
    return d && a->is_full ? 2e6 * a->full.inductance_H * d->trip_A / a->full.motor.supply_V : 0;
}

static double most_steps_Hz(const hil_axis *a)
{
    double us = reversal_us(a);
    return us > 0 ? 1e6 * driver_resolution(driver_view(a)) / us : 0;
}

static void fill_view(hil_axis *a, int64_t now_ns)
{
    if (a->is_turned) law_plant(a, now_ns);
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
        a->view.raw = shaft_faulty_raw(a, full_raw(&f, now_ns), now_ns);
    } else {
        plant_shaft s = plant_at(&a->plant, now_ns);
        a->view.rev = s.rev;
        a->view.rev_per_s = s.rev_per_s;
        a->view.torque_Nm = plant_motor_torque_Nm(&a->plant, s.rev);
        a->view.a_A = a->plant.current_a_A;
        a->view.b_A = a->plant.current_b_A;
        a->view.raw = shaft_faulty_raw(a, shaft_count(s.rev), now_ns);
    }
    if (a->law->show) a->law->show(a);
    if (a->law->count) a->view.raw = a->law->count(a, now_ns);
    int blind = shaft_blind_raw(a, now_ns);
    if (blind >= 0) a->view.raw = blind;
}

static void fill(hil_axis *a, int64_t now_ns, hil_snapshot *out)
{
    memset(out, 0, sizeof *out);
    fill_view(a, now_ns);
#define X(name, type, kind, access, unit, expression, meaning) out->name = expression;
#include "fields.def"
#undef X
    if (a->cells) cells_show(a->cells, out);
}

/* As fill, of the fields that its kind of axis has. */
static void look(hil_axis *a, int64_t now_ns, hil_snapshot *out)
{
    int kind = a->law->kind;
    fill_view(a, now_ns);
#define X(name, type, kind_, access, unit, expression, meaning) if (EXTREMES_HAVE(kind, kind_)) out->name = expression;
#include "fields.def"
#undef X
    if (a->cells) cells_show(a->cells, out);
}

void hil_axis_snapshot(hil_core *c, int axis, hil_snapshot *out)
{
    int64_t now_ns;
    hil_axis *a = core_axis(c, axis, &now_ns);
    fill(a, now_ns, out);
}

/* Groups of hundreds are published often, and most axes of a line of boards stand still. */
void view_publish(hil_axis *a, int64_t now_ns)
{
    int stays = !a->is_active && !a->encoder.script_len && a->fault.noise_counts == 0 && !a->law->count;
    if (stays && a->is_shown) {
        if (!heat_is_level(heat_of(a), now_ns)) { /* a driver at rest warms up, or cools down */
            union { double degC; uint64_t word; } u = {heat_degC(heat_of(a), now_ns)};
            seqlock_write(&a->published_lock, a->published + offsetof(hil_snapshot, junction_degC) / sizeof u.word, &u.word, 1);
        }
        uint64_t word = (uint64_t)now_ns;
        seqlock_write(&a->published_lock, a->published + offsetof(hil_snapshot, at_ns) / sizeof word, &word, 1);
        return;
    }
    a->is_shown = stays;
    union { hil_snapshot s; uint64_t words[SNAPSHOT_WORDS]; } u = {.words = {0}};
    fill(a, now_ns, &u.s);
    seqlock_write(&a->published_lock, a->published, u.words, SNAPSHOT_WORDS);
}

void hil_axis_published(const hil_core *c, int axis, hil_snapshot *out)
{
    union { hil_snapshot s; uint64_t words[SNAPSHOT_WORDS]; } u;
    seqlock_read(&c->axes[axis].published_lock, c->axes[axis].published, u.words, SNAPSHOT_WORDS);
    *out = u.s;
}

double view_field(hil_core *c, int axis, hil_field field, int64_t now_ns)
{
    hil_axis *a = &c->axes[axis];
    const cell *own = cells_find(a->cells, (int)field);
    if (own) return own->value;
    if (field <= HIL_FIELD_raw || (field >= HIL_FIELD_voltage_a_V && field <= HIL_FIELD_lag_steps)) fill_view(a, now_ns);
    switch (field) {
#define X(name, type, kind, access, unit, expression, meaning) case HIL_FIELD_##name: return (double)(expression);
#include "fields.def"
#undef X
    default: return NAN;
    }
}

double hil_axis_get(hil_core *c, int axis, hil_field field)
{
    int64_t now_ns;
    (void)core_axis(c, axis, &now_ns);
    return view_field(c, axis, field, now_ns);
}

int hil_axis_watch(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int capacity)
{
    return hil_axis_watch_extremes(c, axis, slot, num_ns, den, 1, capacity);
}

int hil_axis_watch_extremes(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int points, int capacity)
{
    hil_axis *a = &c->axes[axis];
    if (watch_start(&a->watches[slot], hil_group_now(c, a->group), num_ns, den, points, a->law->kind, a->cells,
                    capacity))
        return -1;
    core_stir(c, axis);
    view_plan(a);
    return 0;
}

void view_plan(hil_axis *a)
{
    int64_t next_ns = watch_soonest_ns(a->watches);
    if (a->switch_next_ns < next_ns) next_ns = a->switch_next_ns;
    a->watch_next_ns = a->heat_next_ns < next_ns ? a->heat_next_ns : next_ns;
}

void view_shaft(hil_axis *a, int64_t at_ns, double *rev, double *rev_per_s)
{
    fill_view(a, at_ns);
    *rev = a->view.rev;
    *rev_per_s = a->view.rev_per_s;
}

void view_sample(hil_axis *a, int64_t at_ns)
{
    for (int i = 0; i < HIL_WATCHES; i++) {
        hil_snapshot *place = watch_place(&a->watches[i], at_ns);
        if (!place) continue;
        if (a->watches[i].extremes) look(a, at_ns, place);
        else fill(a, at_ns, place);
        watch_keep(&a->watches[i]);
    }
}

int hil_axis_take_samples(hil_core *c, int axis, int slot, hil_snapshot *out, int max)
{
    return watch_take(&c->axes[axis].watches[slot], out, max);
}

int64_t hil_axis_lost_samples(const hil_core *c, int axis, int slot)
{
    return atomic_load_explicit(&c->axes[axis].watches[slot].lost, memory_order_relaxed);
}
