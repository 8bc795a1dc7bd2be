#include "a3967.h"

#include <math.h>

#include "../core.h"
#include "../plant/trig.h"

enum { EIGHTHS = 8, HOME = 4, CYCLE = 32 }; /* of a full step: a cycle of the translator turns the rotor by a tooth */

/* On the board. */
enum { PULLED_UP = 1 << HIL_DRIVER_IN_MS1 | 1 << HIL_DRIVER_IN_MS2 | 1 << HIL_DRIVER_IN_SLEEP | 1 << HIL_DRIVER_IN_RESET };

/* Data sheet, timing at 5 V. */
enum { PULSE_NS = 1000, SETUP_NS = 200, WAKE_NS = 1000000 };
#define LONG_AGO (-HIL_FOREVER / 4)

/* Data sheet: source and sink of a coil drop 1.91 V at 0.4 A and 2.55 V at 0.75 A, the logic takes 50 mA of 5 V; shutdown
   and its hysteresis; 50 K/W on a board of two layers. How long it takes to warm up is chosen. */
static const double DROP_V = 1.18, DROP_OHM = 1.83, LOGIC_W = 0.25;
static const heat_limits LIMITS = {.hot_degC = 165, .cool_degC = 150, .K_per_W = 50, .warming_s = 10};

const a3967 *driver_view(const hil_axis *a)
{
    static const a3967 none = {0};
    const a3967 *d = driver_of(a);
    return d ? d : &none;
}

int driver_resolution(const a3967 *d)
{
    static const int of[4] = {1, 2, 4, 8}; /* data sheet, table 1: MS2 MS1 */
    return of[2 * d->pins[HIL_DRIVER_IN_MS2] + d->pins[HIL_DRIVER_IN_MS1]];
}

int driver_is_on(const a3967 *d)
{
    const int32_t *pins = d->pins;
    return !pins[HIL_DRIVER_IN_ENABLE] && pins[HIL_DRIVER_IN_SLEEP] && pins[HIL_DRIVER_IN_RESET] && !d->heat.is_too_hot;
}

double driver_commanded_rev(const a3967 *d) { return d->teeth ? d->origin_rev + (double)d->position / (CYCLE * d->teeth) : 0; }

/* ---- currents ---- */

/* Phase 1 and phase 2: cosine and sine of the translator's angle, of which the data sheet's table has eight a quarter. */
static void currents(const a3967 *d, double *a_A, double *b_A)
{
    double s, c, amps = driver_is_on(d) ? d->trip_A : 0;
    sincos_turns((double)driver_index(d) / CYCLE, &s, &c);
    *a_A = -amps * s;
    *b_A = amps * c;
}

static void tell(hil_axis *a, double a_A, double b_A)
{
    const a3967 *d = a->own;
    if (a->is_full) full_set_fall(&a->full, a->fault.is_open_a ? 1 : d->fall_a, a->fault.is_open_b ? 1 : d->fall_b);
    shaft_set_currents(a, a_A, b_A);
}

/* A step to a lower current has the decay that PFD sets, one to a higher or the same one slow decay. Outputs that are off
   give the current back to the supply. */
static double fall_of(const a3967 *d, double from_A, double to_A)
{
    if (!driver_is_on(d)) return 1;
    return fabs(to_A) < 0.999 * fabs(from_A) ? d->fast_decay : 0; /* the table's levels are 2 % apart at least */
}

static void apply_currents(hil_axis *a)
{
    a3967 *d = a->own;
    double a_A, b_A;
    currents(d, &a_A, &b_A);
    d->fall_a = fall_of(d, a->fault.told_a_A, a_A);
    d->fall_b = fall_of(d, a->fault.told_b_A, b_A);
    tell(a, a_A, b_A);
}

/* Not those of a position that is new since the plant's last node. */
static void drive(hil_axis *a) { tell(a, a->fault.told_a_A, a->fault.told_b_A); }

/* ---- heat ---- */

static double coil_W(double current_A) { return (DROP_V + DROP_OHM * fabs(current_A)) * fabs(current_A); }

static double power_W(const a3967 *d)
{
    double a_A, b_A;
    if (!driver_is_on(d)) return 0;
    currents(d, &a_A, &b_A);
    return LOGIC_W + coil_W(a_A) + coil_W(b_A);
}

/* After a change: what it warms with, and when to look at the heat, if that leads past a threshold. */
static void plan(hil_axis *a, int64_t now_ns)
{
    a3967 *d = a->own;
    d->heat.power_W = power_W(d);
    a->law_next_ns = heat_is_on_its_way(&d->heat) ? now_ns + HEAT_LOOK_NS : HIL_FOREVER;
}

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    (void)c;
    a3967 *d = a->own;
    for (int64_t looks = 0;; looks++) {
        int64_t at_ns = a->law_next_ns;
        int was_on = driver_is_on(d);
        law_plant(a, at_ns);
        heat_to(&d->heat, at_ns);
        if (driver_is_on(d) != was_on) a->is_turned = 1;
        plan(a, at_ns);
        if (a->law_next_ns > until_ns) return looks;
    }
}

/* ---- pins ---- */

/* The next place of the mode: in full steps both coils have current. */
static int64_t next_place(const a3967 *d)
{
    int64_t step = EIGHTHS / driver_resolution(d), first = step == EIGHTHS ? HOME : 0, at = d->position - first;
    int64_t off = ((at % step) + step) % step; /* above a place of the mode */
    int64_t next = d->pins[HIL_DRIVER_IN_DIR] ? at + step - off : at - (off ? off : step);
    return next + first;
}

/* To home, by the shortest way: the currents are the same in each cycle. */
static void go_home(a3967 *d)
{
    int64_t off = ((d->position - HOME) % CYCLE + CYCLE) % CYCLE;
    d->position += off <= CYCLE / 2 ? -off : CYCLE - off;
    d->is_step_high = 0;
}

static int is_listening(const a3967 *d, int64_t at_ns)
{
    return d->pins[HIL_DRIVER_IN_RESET] && d->pins[HIL_DRIVER_IN_SLEEP] && at_ns >= d->awake_ns;
}

static void rise(const hil_axis *a, a3967 *d, int64_t at_ns)
{
    int is_long = at_ns - d->fall_ns >= PULSE_NS;
    d->is_step_high = is_long && is_listening(d, at_ns);
    d->timing_errors += !is_long || at_ns - d->changed_ns < SETUP_NS;
    d->rise_ns = at_ns;
    slip_look(&d->slip, a, driver_commanded_rev(d), d->teeth, at_ns);
    if (!d->is_step_high) {
        d->ignored++;
        return;
    }
    d->before_rise = d->position;
    d->taken_before = d->taken;
    d->position = next_place(d);
    d->taken += d->pins[HIL_DRIVER_IN_DIR] ? 1 : -1;
}

/* A pulse is a step at its rise; one that turns out to be too short has been none. */
static void fall(a3967 *d, int64_t at_ns)
{
    d->fall_ns = at_ns;
    if (at_ns - d->rise_ns >= PULSE_NS) return;
    d->timing_errors++;
    if (!d->is_step_high) return;
    d->position = d->before_rise;
    d->taken = d->taken_before;
    d->ignored++;
}

static void change(const hil_axis *a, a3967 *d, int pin, int level, int64_t at_ns)
{
    switch (pin) {
    case HIL_DRIVER_IN_STEP:
        if (level) rise(a, d, at_ns);
        else fall(d, at_ns);
        return;
    case HIL_DRIVER_IN_DIR:
    case HIL_DRIVER_IN_MS1:
    case HIL_DRIVER_IN_MS2:
        d->changed_ns = at_ns;
        d->timing_errors += at_ns - d->rise_ns < SETUP_NS;
        return;
    case HIL_DRIVER_IN_SLEEP:
        if (level) d->awake_ns = at_ns + WAKE_NS;
        go_home(d);
        return;
    case HIL_DRIVER_IN_RESET:
        d->changed_ns = at_ns;
        d->timing_errors += at_ns - d->rise_ns < SETUP_NS;
        go_home(d);
        return;
    default: return;
    }
}

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    (void)c;
    a3967 *d = a->own;
    if (d->pins[pin] == level) return;
    int64_t position = d->position;
    int was_on = driver_is_on(d);
    law_plant(a, at_ns);
    heat_to(&d->heat, at_ns);
    d->pins[pin] = level;
    change(a, d, pin, level, at_ns);
    if (d->position != position || driver_is_on(d) != was_on) a->is_turned = 1;
    plan(a, at_ns);
}

/* ---- its life ---- */

static double max_current_A(const hil_axis_params *params) { return params->phase_current_A; }

static void open_driver(hil_axis *a, const hil_axis_params *params)
{
    a3967 *d = a->own;
    d->teeth = params->rotor_teeth;
    d->trip_A = params->phase_current_A;
    d->fast_decay = params->fast_decay_pct / 100;
    double start_teeth = params->start_deg / 360 * d->teeth;
    d->origin_rev = nearbyint(start_teeth - (double)HOME / CYCLE) / d->teeth;
    for (int pin = 0; pin < HIL_DRIVER_INPUTS; pin++) d->pins[pin] = PULLED_UP >> pin & 1;
    d->position = HOME;
    heat_open(&d->heat, &LIMITS, params->ambient_degC);
    d->heat.power_W = power_W(d);
    if (!a->is_full) plant_halve(&a->plant);
}

static void close_driver(hil_axis *a) { (void)a; }

static void power_up(hil_core *c, hil_axis *a, int64_t now_ns)
{
    (void)c;
    a3967 *d = a->own;
    heat_begin(&d->heat, now_ns);
    law_plant(a, now_ns);
    shaft_node(a, now_ns);
    heat_to(&d->heat, now_ns);
    go_home(d);
    slip_clear(&d->slip, a, driver_commanded_rev(d), d->teeth);
    d->taken = d->ignored = d->timing_errors = 0;
    d->rise_ns = d->fall_ns = d->changed_ns = d->awake_ns = LONG_AGO;
    apply_currents(a);
    a->is_turned = 0;
    plan(a, now_ns);
}

static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    (void)a, (void)field, (void)value, (void)now_ns;
    return -1;
}

const law a3967_law = {
    .bytes = sizeof(a3967),
    .kind = HIL_KIND_DRIVER,
    .pulled_up = PULLED_UP,
    .events = 1,
    .max_current_A = max_current_A,
    .open = open_driver,
    .close = close_driver,
    .power_up = power_up,
    .step = step,
    .drive = drive,
    .turn = apply_currents,
    .pin = set_pin,
    .set = set,
};
