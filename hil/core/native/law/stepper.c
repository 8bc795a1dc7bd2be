#include "stepper.h"

#include <math.h>

#include "../core.h"
#include "../hil_core.h"
#include "../motion/motion.h"
#include "../plant/trig.h"

enum { HALF_US = 500 };

static int64_t half_us_after(int64_t ns) { return ns / HALF_US + (ns % HALF_US > 0); }
static int64_t to_ns(int64_t half_us) { return half_us >= HIL_FOREVER / HALF_US ? HIL_FOREVER : half_us * HALF_US; }

/* Microstep exponent that a driver makes of MS3 MS2 MS1 (data sheets; -1 in no row: its last one). */
static int driver_exponent(int driver, int pins)
{
    static const int8_t a4988[8] = {0, 1, 2, 3, 0, 1, 2, 4}, drv8825[8] = {0, 1, 2, 3, 4, 5, 5, 5};
    return (driver ? drv8825 : a4988)[pins & 7];
}

/* ---- driver and motor ---- */

double stepper_commanded_rev(const stepper *s)
{
    return s->origin_rev + (double)s->position / MICROSTEPS / (4 * s->teeth);
}

int stepper_out(const hil_axis *a, int pin, int64_t now_ns)
{
    const stepper *s = stepper_of(a);
    return s && s->out.levels[pin] && (pin != HIL_OUT_CLK || now_ns < s->fall_ns);
}

/* Not those of a position that is new since the plant's last node. */
static void drive(hil_axis *a) { shaft_set_currents(a, a->fault.told_a_A, a->fault.told_b_A); }

/* Currents whose pull has its rest where the driver's position is; the torque's law is in plant/simple.h. */
static void apply_currents(hil_axis *a)
{
    const stepper *of = a->own;
    double s, c, amps = of->phase_current_A;
    sincos_turns(of->teeth * stepper_commanded_rev(of), &s, &c);
    shaft_set_currents(a, -amps * s, amps * c);
}

static void turn(hil_axis *a, int64_t at_ns)
{
    stepper *s = a->own;
    law_plant(a, at_ns);
    slip_look(&s->slip, a, stepper_commanded_rev(s), s->teeth, at_ns);
    int step = MICROSTEPS >> driver_exponent(s->driver, s->motion.setup.mode_pins);
    s->position += s->motion.dir_level == s->motion.setup.is_cw_high ? step : -step;
    a->is_turned = 1;
}

/* ---- outputs ---- */

static void out(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    stepper *s = a->own;
    outputs_set(c, &s->out, pin, level, at_ns);
}

/* Pins that follow the engine's state; OP SB is OP SA's inverse. */
static void follow_engine(hil_core *c, hil_axis *a, int64_t at_ns)
{
    const stepper *s = a->own;
    const motion *m = &s->motion;
    out(c, a, HIL_OUT_DIR, m->dir_level, at_ns);
    out(c, a, HIL_OUT_OP_SA, m->op_sa && (m->setup.ops & 32), at_ns);
    out(c, a, HIL_OUT_OP_SB, !m->op_sa && (m->setup.ops & 4), at_ns);
    for (int i = 0; i < 3; i++) out(c, a, HIL_OUT_MS1 + i, m->setup.mode_pins >> i & 1, at_ns);
}

static void rise(hil_core *c, hil_axis *a, int64_t at_ns)
{
    stepper *s = a->own;
    s->fall_ns = at_ns + s->motion.fall_after * HALF_US;
    s->is_pulsing = 1;
    if (is_clk_watched(s)) out(c, a, HIL_OUT_CLK, 0, at_ns);
    out(c, a, HIL_OUT_CLK, 1, at_ns);
    s->is_pulsing = 0;
    turn(a, at_ns);
}

typedef struct counts {
    int64_t begun, ended;
} counts;

static counts counts_of(const motion *m) { return (counts){m->begun, m->ended}; }

/* When clk comes down, given when the engine does something next. Without anybody at the pin that is nothing to be done
   between two pulses, whoever asks for the level compares times; but an axis may not rest before. */
static int64_t next_fall_ns(const stepper *s, int64_t engine_ns)
{
    int is_to_come = s->out.levels[HIL_OUT_CLK] && (is_clk_watched(s) || engine_ns == HIL_FOREVER);
    return is_to_come ? s->fall_ns : HIL_FOREVER;
}

/* When its engine does something next. Pulse by pulse it is too much to ask for it. */
static void plan(hil_axis *a, int64_t now_ns)
{
    stepper *s = a->own;
    if (!is_clk_watched(s)) s->out.levels[HIL_OUT_CLK] = stepper_out(a, HIL_OUT_CLK, now_ns);
    int64_t next_ns = to_ns(motion_next(&s->motion)), fall_ns = next_fall_ns(s, next_ns);
    a->law_next_ns = fall_ns < next_ns ? fall_ns : next_ns;
}

/* After anything but a pulse: tells what began or ended since, and brings the outputs up to date. */
static void settle(hil_core *c, hil_axis *a, counts was, int64_t at_ns)
{
    const stepper *s = a->own;
    const motion *m = &s->motion;
    int axis = (int)(a - c->axes);
    if (a->is_telling && m->ended != was.ended) core_post(c, axis, at_ns, HIL_EVENT_COMMAND_ENDED, 0);
    if (a->is_telling && m->begun != was.begun) core_post(c, axis, at_ns, HIL_EVENT_COMMAND_BEGUN, m->slot);
    follow_engine(c, a, at_ns);
    plan(a, at_ns);
}

static int64_t tells_ns(const hil_axis *a)
{
    const stepper *s = a->own;
    return to_ns(motion_tells(&s->motion));
}

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    stepper *s = a->own;
    motion *m = &s->motion;
    for (int64_t work = 0;; work++) {
        int64_t next_ns = to_ns(motion_next(m)), fall_ns = next_fall_ns(s, next_ns);
        int64_t at_ns = fall_ns <= next_ns ? fall_ns : next_ns;
        if (at_ns > until_ns || at_ns == HIL_FOREVER) {
            a->law_next_ns = at_ns;
            return work;
        }
        if (fall_ns <= next_ns) {
            out(c, a, HIL_OUT_CLK, 0, at_ns);
            continue;
        }
        counts was = counts_of(m);
        if (motion_run(m)) rise(c, a, at_ns);
        else settle(c, a, was, at_ns);
    }
}

/* ---- inputs ---- */

/* One that its own pulse causes, over wires, is lost: an interrupt is not entered again before it has ended. */
static void single(hil_core *c, hil_axis *a, int is_ccw, int64_t at_ns)
{
    stepper *s = a->own;
    if (s->is_pulsing || !motion_single(&s->motion, is_ccw, half_us_after(at_ns))) return;
    s->is_pulsing = 1;
    follow_engine(c, a, at_ns);
    rise(c, a, at_ns);
}

/* One pulse a full quadrature cycle; A before B is clockwise. */
static void turn_encoder(hil_core *c, hil_axis *a, int ena, int enb, int64_t at_ns)
{
    stepper *s = a->own;
    static const int8_t place[4] = {0, 3, 1, 2}; /* of (A, B) in the cycle 00 10 11 01 */
    int moved = (place[2 * ena + enb] - place[2 * s->ena + s->enb] + 4) % 4;
    s->ena = ena;
    s->enb = enb;
    if (!s->is_set_up) return; /* nobody looks yet: where an encoder rests at power-up is no turn */
    if (moved == 1) s->quadrature++;
    else if (moved == 3) s->quadrature--;
    if (s->quadrature > -4 && s->quadrature < 4) return;
    int is_ccw = s->quadrature < 0;
    s->quadrature = 0;
    motion *m = &s->motion;
    if (!m->is_throttle) single(c, a, is_ccw, at_ns);
    else if (m->slot == MOTION_CONTINUOUS_SLOT && (!is_ccw || m->now.rpm > 1)) {
        uint32_t rpm = m->now.rpm + (is_ccw ? -1u : 1u);
        motion_retarget(m, rpm, (uint32_t)(60000000 / m->setup.steps_per_rev) / (rpm ? rpm : 1), half_us_after(at_ns));
    }
}

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    stepper *s = a->own;
    motion *m = &s->motion;
    int64_t now = half_us_after(at_ns);
    counts was = counts_of(m);
    switch (pin) {
    case HIL_IN_SYNC:
        if (m->sync_level && !level) motion_release_sync(m, now);
        m->sync_level = level;
        break;
    case HIL_IN_ESTOP:
        if (level == m->estop_level) break;
        if (!level) motion_stop(m, now);
        m->estop_level = level;
        core_post(c, (int)(a - c->axes), at_ns, HIL_EVENT_ESTOP, level);
        break;
    case HIL_IN_ENA: turn_encoder(c, a, level, s->enb, at_ns); break;
    case HIL_IN_ENB: turn_encoder(c, a, s->ena, level, at_ns); break;
    default: s->rst_is_low = !level; /* read by the firmware at a cold start */
    }
    settle(c, a, was, at_ns);
}

/* ---- the firmware's face ---- */

static double max_current_A(const hil_axis_params *params) { return params->phase_current_A; }

static void open_stepper(hil_axis *a, const hil_axis_params *params)
{
    static const motion_setup start = {.steps_per_rev = 200, .slow_rpm = 10, .microstep_exponent = 1, .pulse_us = 30,
                                       .interrupt_overhead_us = 8, .is_clock_internal = 1, .ops = 36, .mode_pins = 1,
                                       .external_clock_Hz = 1000000};
    stepper *s = a->own;
    s->driver = params->driver;
    s->teeth = params->rotor_teeth;
    s->phase_current_A = params->phase_current_A;
    s->origin_rev = params->start_deg / 360;
    motion_init(&s->motion, &start);
    if (!a->is_full) plant_halve(&a->plant);
}

static void close_stepper(hil_axis *a)
{
    stepper *s = a->own;
    outputs_close(&s->out);
}

static void power_up(hil_core *c, hil_axis *a, int64_t now_ns)
{
    stepper *s = a->own;
    motion *m = &s->motion;
    int64_t clock_Hz = m->clock_Hz;
    int32_t sync = m->sync_level, estop = m->estop_level;
    motion_setup setup = m->setup;
    motion_init(m, &setup);
    m->clock_Hz = clock_Hz;
    m->sync_level = sync;
    m->estop_level = estop;
    a->is_telling = s->is_set_up = s->quadrature = 0;
    out(c, a, HIL_OUT_CLK, 0, now_ns);
    follow_engine(c, a, now_ns);
    plan(a, now_ns);
    law_plant(a, now_ns);
    shaft_node(a, now_ns);
    slip_clear(&s->slip, a, stepper_commanded_rev(s), s->teeth);
    apply_currents(a);
    a->is_turned = 0;
}

/* Beyond 1 THz nothing changes: no pulse is shorter than 2 us. */
static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    stepper *s = a->own;
    if (field != HIL_FIELD_clock_Hz) return -1;
    motion_clock(&s->motion, (int64_t)fmin(fmax(value, -1), 1e12), (now_ns + 499) / 500);
    plan(a, now_ns);
    return 0;
}

static stepper *of(hil_core *c, int axis) { return c->axes[axis].own; }

void hil_motion_setup(hil_core *c, int axis, const motion_setup *setup)
{
    hil_axis *a = &c->axes[axis];
    stepper *s = a->own;
    motion *m = &s->motion;
    int64_t now_ns = hil_group_now(c, a->group);
    counts was = counts_of(m);
    core_stir(c, axis);
    motion_configure(m, setup, half_us_after(now_ns));
    s->is_set_up = 1;
    settle(c, a, was, now_ns);
}

void hil_motion_write(hil_core *c, int axis, int slot, const motion_entry *entry) { of(c, axis)->motion.entries[slot] = *entry; }

void hil_motion_read(hil_core *c, int axis, int slot, motion_entry *out) { *out = of(c, axis)->motion.entries[slot]; }

void hil_motion_xref_write(hil_core *c, int axis, int index, int slot) { of(c, axis)->motion.xref[index] = (uint8_t)slot; }

int hil_motion_xref(hil_core *c, int axis, int index) { return of(c, axis)->motion.xref[index]; }

static double act(hil_core *c, hil_axis *a, int call, double given_x, double given_y, double z)
{
    (void)z;
    motion *m = &stepper_of(a)->motion;
    int64_t x = (int64_t)given_x, y = (int64_t)given_y;
    int64_t now_ns = hil_group_now(c, a->group), now = half_us_after(now_ns);
    counts was = counts_of(m);
    switch ((hil_motion_call)call) {
    case HIL_MOTION_ENQUEUE: motion_enqueue(m, (int)x, now); break;
    case HIL_MOTION_ONCE: motion_once(m, (int)x, now); break;
    case HIL_MOTION_RETARGET: motion_retarget(m, (uint32_t)x, (uint32_t)y, now); break;
    case HIL_MOTION_PULSE: single(c, a, (int)x, now_ns); break;
    case HIL_MOTION_STOP:
        if (x < 0) motion_stop(m, now);
        else motion_stop_gracefully(m, (int32_t)x, now);
        break;
    case HIL_MOTION_NEXT: motion_next_command(m, (int)x, now); break;
    case HIL_MOTION_FINISH: motion_finish(m, now); break;
    case HIL_MOTION_LOOP_BOUNDS: motion_loop_bounds(m, (int)x, (int)y, now); break;
    case HIL_MOTION_LOOP_PASSES: motion_loop_passes(m, x); break;
    case HIL_MOTION_LOOP_ARRAY: motion_loop_array(m, x, now); break;
    case HIL_MOTION_RELEASE_SYNC: motion_release_sync(m, now); break;
    case HIL_MOTION_GAP: m->is_gap_on = x != 0; break;
    case HIL_MOTION_THROTTLE: m->is_throttle = x != 0; break;
    case HIL_MOTION_REPORT: a->is_telling = x != 0; break;
    }
    settle(c, a, was, now_ns);
    return 0;
}

static outputs *outputs_of(hil_axis *a)
{
    stepper *s = a->own;
    return &s->out;
}

const law sac_law = {
    .bytes = sizeof(stepper),
    .kind = HIL_KIND_STEPPER,
    .events = 8, /* a command's end and the next one's beginning, Estop, and some */
    .max_current_A = max_current_A,
    .open = open_stepper,
    .close = close_stepper,
    .power_up = power_up,
    .step = step,
    .tells_ns = tells_ns,
    .drive = drive,
    .turn = apply_currents,
    .pin = set_pin,
    .set = set,
    .act = act,
    .outputs = outputs_of,
    .look = plan,
};
