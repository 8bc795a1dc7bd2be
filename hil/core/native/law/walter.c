#include "walter.h"

#include <math.h>
#include <string.h>

#include "../core.h"
#include "../hil_core.h"

enum { LATE_NS = 2 };

static walter_axis *of(const hil_axis *a) { return a->own; }

const walter_axis *walter_view(const hil_axis *a)
{
    static const walter_axis none;
    return a->law == &walter_law ? a->own : &none;
}

static const walter_board *board_view(const hil_axis *a)
{
    const walter_axis *w = walter_view(a);
    return w->first ? &of(w->first)->board : NULL;
}

int walter_is_powered(const hil_axis *a)
{
    const walter_board *b = board_view(a);
    return b && b->has_24V;
}

static uint32_t clock_ms(const walter_board *b, int64_t now_ns) { return (uint32_t)((now_ns - b->origin_ns) / 1000000); }

double walter_to_be_deg(const hil_axis *a, int64_t now_ns)
{
    const walter_board *b = board_view(a);
    return b ? (double)walter_ramp_at(&of(a)->joint.ramp, clock_ms(b, now_ns)) : 0;
}

int64_t walter_ramp_left_ms(const hil_axis *a, int64_t now_ns)
{
    const walter_board *b = board_view(a);
    if (!b || !of(a)->joint.ramp.start_ms) return 0;
    int64_t left_ms = (int64_t)of(a)->joint.ramp.end_ms - clock_ms(b, now_ns);
    return left_ms > 0 ? left_ms : 0;
}

/* ---- the joint behind the gear ---- */

/* The shaft is where pulses have brought it: to the plant it is clamped there. */
static void show(hil_axis *a)
{
    a->plant.is_jammed = 1;
    a->plant.jam_rev = a->plant.moving.rev = of(a)->deg / 360;
    a->is_shown = 0;
}

static int can_turn(const hil_axis *a)
{
    const axis_fault *f = &a->fault;
    return !f->is_jammed && !f->is_open_a && !f->is_open_b && fabs(shaft_load_Nm(a)) <= of(a)->holding_Nm;
}

static int is_driven(const hil_axis *a, const walter_board *b) { return b->has_24V && of(a)->is_enabled && can_turn(a); }

static void pulse(hil_axis *a, const walter_board *b, int is_up)
{
    walter_axis *w = a->own;
    w->pulses++;
    w->is_up = is_up;
    if (is_driven(a, b)) {
        w->deg += is_up ? w->step_deg : -w->step_deg;
        show(a);
    }
    if (w->is_enabled) walter_joint_count(&w->joint, is_up);
}

static int answers(const hil_axis *a, int64_t at_ns)
{
    const axis_fault *f = &a->fault;
    if (f->is_line_open) return 0;
    if (f->silent_rate <= 0) return 1;
    return (double)(full_hash(f->noise_key ^ (uint64_t)at_ns) >> 11) * 0x1p-53 >= f->silent_rate;
}

static int encoder_count(hil_axis *a, int64_t at_ns)
{
    walter_axis *w = a->own;
    if (!a->fault.is_frozen) w->last_count = shaft_faulty_raw(a, walter_count(w->deg + w->mount_deg), at_ns);
    return w->last_count;
}

/* -1: it does not answer, which is counted. */
static int read_encoder(hil_axis *a, const walter_board *b, int64_t at_us, int is_filtered)
{
    walter_axis *w = a->own;
    int64_t at_ns = b->origin_ns + at_us * 1000;
    if (!answers(a, at_ns)) {
        w->failures++;
        return -1;
    }
    w->failures = 0;
    walter_joint_read(&w->joint, encoder_count(a, at_ns), is_filtered, (uint32_t)(at_us / 1000));
    return 0;
}

/* ---- the main loop ---- */

static int64_t poll_steps(walter_board *b, int64_t at_us)
{
    for (int i = 0; i < b->steppers; i++) {
        int step = walter_steps_poll(&of(b->axes[i])->joint.steps, (uint32_t)at_us);
        if (!step) continue;
        pulse(b->axes[i], b, step > 0);
        at_us += WALTER_PULSE_US;
    }
    return at_us;
}

static int is_sample_due(const walter_board *b, const walter_axis *w)
{
    return (uint16_t)((uint16_t)b->now_ms - w->sampled_ms) >= WALTER_SAMPLE_MS;
}

static int64_t sample_joints(hil_core *c, walter_board *b, int64_t at_us)
{
    for (int i = 0; i < b->steppers; i++) {
        hil_axis *a = b->axes[i];
        walter_axis *w = a->own;
        if (!is_sample_due(b, w)) continue;
        w->sampled_ms = (uint16_t)b->now_ms;
        a->is_shown = 0;
        int is_read = 0;
        if (w->is_connected && w->is_passed && w->failures < WALTER_MOST_FAILURES) {
            is_read = !read_encoder(a, b, at_us, 1);
            if (!is_read) core_post(c, (int)(a - c->axes), b->origin_ns + at_us * 1000, HIL_EVENT_READING_FAILED, w->failures);
        }
        walter_joint_sample(&w->joint, is_read ? walter_joint_encoder_deg(&w->joint) : w->joint.measured_deg, (uint32_t)b->now_ms);
        at_us = poll_steps(b, at_us);
    }
    return at_us;
}

static void finish_pass(hil_core *c, walter_board *b, int64_t at_us)
{
    b->cursor_us = sample_joints(c, b, at_us) + WALTER_PASS_US;
    b->mode = WALTER_RUNS;
}

static void pass(hil_core *c, walter_board *b, int64_t at_us)
{
    b->now_ms = at_us / 1000;
    finish_pass(c, b, poll_steps(b, at_us));
}

/* The first of the loop's turns at or after a time. */
static int64_t turn_at_us(const walter_board *b, int64_t due_us)
{
    if (due_us <= b->cursor_us) return b->cursor_us;
    return b->cursor_us + (due_us - b->cursor_us + WALTER_PASS_US - 1) / WALTER_PASS_US * WALTER_PASS_US;
}

/* The ms that the turn before the next one at or after a time goes by. Turns with nothing to do are not taken: they are
   as long as each other, and a turn with pulses is longer. */
static int64_t ms_before(const walter_board *b, int64_t due_us)
{
    int64_t turn_us = turn_at_us(b, due_us);
    return turn_us > b->cursor_us ? (turn_us - WALTER_PASS_US) / 1000 : b->now_ms;
}

/* When something happens in the loop from a time on that its turns count from; -1: never. */
static int64_t next_from_us(const walter_board *b)
{
    if (b->mode == WALTER_STOPPED || !b->steppers) return -1;
    int64_t least_us = INT64_MAX, now_ms = b->cursor_us / 1000;
    for (int i = 0; i < b->steppers; i++) {
        const walter_axis *w = of(b->axes[i]);
        int64_t due_us = walter_steps_due_us(&w->joint.steps, (uint32_t)b->cursor_us);
        if (due_us >= 0 && b->cursor_us + due_us < least_us) least_us = b->cursor_us + due_us;
        if (b->mode != WALTER_RUNS) continue;
        int64_t left_ms = WALTER_SAMPLE_MS - (uint16_t)((uint16_t)now_ms - w->sampled_ms);
        due_us = left_ms <= 0 ? b->cursor_us : (now_ms + left_ms) * 1000;
        if (due_us < least_us) least_us = due_us;
    }
    return least_us == INT64_MAX ? -1 : turn_at_us(b, least_us);
}

/* The same; where a wait begins behind another, turns count from its beginning. */
static int64_t next_us(walter_board *b)
{
    int64_t at_us = next_from_us(b);
    if (!b->second_us || (at_us >= 0 && at_us < b->second_us)) return at_us;
    b->cursor_us = b->second_us;
    b->second_us = 0;
    return next_from_us(b);
}

/* A turn begins two nanoseconds late: what comes from outside at its time is there before, and what the firmware does
   one nanosecond after it. */
static void plan(hil_axis *first)
{
    walter_board *b = &of(first)->board;
    int64_t at_us = next_us(b);
    first->law_next_ns = at_us < 0 ? HIL_FOREVER : b->origin_ns + at_us * 1000 + LATE_NS;
}

static int64_t step(hil_core *c, hil_axis *a, int64_t until_ns)
{
    walter_board *b = &of(a)->board;
    int64_t work = 0;
    for (; a->law_next_ns <= until_ns; work++) {
        int64_t at_us = (a->law_next_ns - LATE_NS - b->origin_ns) / 1000;
        if (b->mode == WALTER_RUNS) pass(c, b, at_us);
        else b->cursor_us = poll_steps(b, at_us) + WALTER_PASS_US;
        plan(a);
    }
    return work;
}

/* ---- the firmware's face ---- */

/* Five joints that were opened one after the other, this one the first; 0: they are not all there. */
static int find_joints(hil_core *c, hil_axis *first)
{
    int found = 0;
    for (int i = c->groups[first->group].first_axis; i >= 0; i = c->axes[i].next_in_group) {
        hil_axis *a = &c->axes[i];
        if (a->law != &walter_law || a->order < first->order) continue;
        int place = a->order - first->order;
        if (place > WALTER_STEPPERS + 1) continue;
        of(a)->first = first;
        core_join(c, i);
        if (place >= WALTER_STEPPERS || !of(a)->is_stepper) continue;
        of(first)->board.axes[place] = a;
        found++;
    }
    return found == WALTER_STEPPERS;
}

static double start(hil_core *c, hil_axis *first, int64_t now_ns)
{
    walter_board *b = &of(first)->board;
    *b = (walter_board){.origin_ns = now_ns};
    if (!find_joints(c, first)) return -1;
    return 0;
}

static void set_up_drive(walter_axis *w)
{
    w->joint.ramp = (walter_ramp){0};
    w->is_up = !w->is_up;
    walter_steps_speed(&w->joint.steps, walter_full_speed(&w->joint.is));
    walter_steps_acceleration(&w->joint.steps, walter_full_acceleration(&w->joint.is));
}

/* What an encoder or a servo on its bus says to that. */
static double ask(hil_axis *a, walter_board *b, int call, int64_t now_us)
{
    walter_axis *w = a->own;
    int64_t now_ns = b->origin_ns + now_us * 1000;
    switch (call) {
    case HIL_WALTER_ANSWERS: return answers(a, now_ns);
    case HIL_WALTER_WHERE: return w->deg;
    case HIL_WALTER_READ_DEG: return (double)w->joint.filtered_deg;
    case HIL_WALTER_FULL_SPEED: return (double)walter_full_speed(&w->joint.is);
    case HIL_WALTER_FULL_ACCELERATION: return (double)walter_full_acceleration(&w->joint.is);
    case HIL_WALTER_CONNECT:
        w->is_connected = answers(a, now_ns);
        w->joint.filtered_deg = 0;
        if (!w->is_connected) return -1;
        w->joint.filtered_deg = (float)(encoder_count(a, now_ns) / 16384.0 * 360.0);
        return (double)w->joint.filtered_deg;
    default: return read_encoder(a, b, now_us, 0);
    }
}

static double set_joint(hil_axis *a, int call, double x)
{
    walter_axis *w = a->own;
    walter_setting *is = &w->joint.is;
    float value = (float)x;
    switch (call) {
    case HIL_WALTER_SET_MIN: is->min_deg = value; break;
    case HIL_WALTER_SET_MAX: is->max_deg = value; break;
    case HIL_WALTER_SET_NULL: is->null_deg = value; break;
    case HIL_WALTER_SET_SPEED: is->speed_rpm = value; break;
    case HIL_WALTER_SET_ACCELERATION: is->acceleration_rpm_per_s = value; break;
    case HIL_WALTER_SET_P: is->kP = value; break;
    case HIL_WALTER_SET_I: is->kI = value; break;
    case HIL_WALTER_PASSED: w->is_passed = x != 0; break;
    case HIL_WALTER_ENABLE:
        w->is_enabled = x != 0;
        if (w->is_enabled) w->joint.integral = 0;
        break;
    case HIL_WALTER_SET_UP: set_up_drive(w); break;
    case HIL_WALTER_DUE: w->sampled_ms = (uint16_t)-4; break; /* the firmware's timer set back by less than nothing */
    case HIL_WALTER_PLACE:
        if (can_turn(a)) w->deg = x;
        show(a);
        break;
    default: return -1;
    }
    return 0;
}

static double move_joint(walter_axis *w, int call, double x, double y, double z, uint32_t now_ms)
{
    walter_joint *j = &w->joint;
    switch (call) {
    case HIL_WALTER_MOVE: walter_joint_move(j, (float)x, now_ms, (uint32_t)y); break;
    case HIL_WALTER_MOVE_BY: walter_joint_move_by(j, (float)x, now_ms, (uint32_t)y); break;
    case HIL_WALTER_RAMP: walter_ramp_set(&j->ramp, (float)x, (float)y, now_ms, (uint32_t)z); break;
    case HIL_WALTER_RAMP_AT: return (double)walter_ramp_at(&j->ramp, now_ms + (uint32_t)x);
    case HIL_WALTER_REST: j->ramp = (walter_ramp){0}; break;
    case HIL_WALTER_MEASURE: j->measured_deg = (float)x; break;
    case HIL_WALTER_SETTLE:
        walter_joint_sample(j, walter_joint_encoder_deg(j), now_ms);
        walter_joint_move(j, j->measured_deg, now_ms, 1);
        break;
    default: return -1;
    }
    return 0;
}

/* The loop, which the first joint holds. Answers the board's microseconds after it. */
static double run_loop(hil_core *c, hil_axis *first, int call, double x, int64_t now_us)
{
    walter_board *b = &of(first)->board;
    switch (call) {
    case HIL_WALTER_NEXT_PASS: return (double)turn_at_us(b, now_us);
    case HIL_WALTER_PASS_BEFORE: return (double)ms_before(b, now_us);
    case HIL_WALTER_STOP:
    case HIL_WALTER_HOLD:
        b->mode = call == HIL_WALTER_HOLD ? WALTER_POLLS : WALTER_STOPPED;
        b->cursor_us = now_us;
        b->second_us = call == HIL_WALTER_HOLD && x > 0 ? now_us + (int64_t)(x * 1000) : 0;
        break;
    case HIL_WALTER_POLL:
        b->now_ms = now_us / 1000;
        b->mode = WALTER_STOPPED;
        b->cursor_us = poll_steps(b, now_us);
        break;
    case HIL_WALTER_POLL_AGAIN: b->cursor_us = poll_steps(b, now_us); break;
    case HIL_WALTER_FINISH: finish_pass(c, b, now_us); break;
    case HIL_WALTER_PASS: pass(c, b, now_us); break;
    case HIL_WALTER_KNOW:
        b->steppers = x != 0 ? WALTER_STEPPERS : 0;
        b->cursor_us = now_us;
        break;
    case HIL_WALTER_POWER: b->has_24V = x != 0; break;
    case HIL_WALTER_CLOCK: return (double)now_us;
    default: return -1;
    }
    plan(first);
    return (double)b->cursor_us;
}

/* Answers -1 where a call means nothing; of the loop's own the board's microseconds when it goes on. */
static double act(hil_core *c, hil_axis *a, int call, double x, double y, double z)
{
    int64_t now_ns = hil_group_now(c, a->group);
    walter_axis *w = a->own;
    if (call == HIL_WALTER_START) return start(c, a, now_ns);
    if (!w->first) return -1;
    walter_board *b = &of(w->first)->board;
    int64_t now_us = (now_ns - b->origin_ns + 1000 - LATE_NS) / 1000;
    if (b->mode == WALTER_STOPPED && now_us < b->cursor_us) now_us = b->cursor_us;
    if (call < HIL_WALTER_SET_MIN) return run_loop(c, w->first, call, x, now_us);
    if (call < HIL_WALTER_MOVE) {
        double said = set_joint(a, call, x);
        plan(w->first);
        return said;
    }
    if (call < HIL_WALTER_ANSWERS) return move_joint(w, call, x, y, z, (uint32_t)(now_us / 1000));
    return call == HIL_WALTER_CLOCK_NS ? (double)(now_ns - b->origin_ns) : ask(a, b, call, now_us);
}

/* ---- as a law ---- */

static double max_current_A(const hil_axis_params *params) { return params->phase_current_A; }

static void open_joint(hil_axis *a, const hil_axis_params *params)
{
    walter_axis *w = a->own;
    walter_setting is = {.gear = (float)params->gear_ratio, .microsteps = params->driver_microsteps,
                         .offset_deg = (float)params->encoder_offset_deg, .counts_backwards = params->counts_backwards};
    walter_joint_init(&w->joint, &is);
    w->is_stepper = params->driver_microsteps > 0;
    w->step_deg = w->is_stepper ? (double)1.8f / params->driver_microsteps / (double)is.gear : 0;
    w->deg = params->start_deg;
    w->mount_deg = params->encoder_null_deg + params->encoder_offset_deg;
    w->holding_Nm = params->torque_constant_Nm_per_A * params->phase_current_A;
    show(a);
}

static void close_joint(hil_axis *a) { (void)a; }

/* Without power the joint stays where it is, and nothing knows where that is. */
static void power_up(hil_core *c, hil_axis *a, int64_t now_ns)
{
    (void)c;
    (void)now_ns;
    walter_axis *w = a->own;
    walter_setting is = w->joint.is;
    walter_joint_init(&w->joint, &is);
    memset(&w->board, 0, sizeof w->board);
    w->first = NULL;
    w->pulses = 0;
    w->is_enabled = w->is_connected = w->is_passed = w->failures = w->sampled_ms = 0;
    w->is_up = 1;
    a->law_next_ns = HIL_FOREVER;
    show(a);
}

/* After a fault: what turned the shaft by hand turned the joint. */
static void drive(hil_axis *a)
{
    of(a)->deg += (a->plant.moving.rev - a->plant.jam_rev) * 360;
    show(a);
}

static void set_pin(hil_core *c, hil_axis *a, int pin, int level, int64_t at_ns)
{
    (void)c, (void)a, (void)pin, (void)level, (void)at_ns;
}

/* What the firmware finds around the board. */
static int set(hil_axis *a, hil_field field, double value, int64_t now_ns)
{
    (void)now_ns;
    walter_axis *w = a->own;
    /* The kind's table refuses what is beyond; but an int of a double that does not fit is undefined, whoever sets
       it. */
    if (field == HIL_FIELD_knob_counts) w->knob_counts = (int)fmin(fmax(value, 0), 1023);
    else if (field == HIL_FIELD_has_lights) w->has_lights = value != 0;
    else return -1;
    return 0;
}

static void look(hil_axis *a)
{
    const walter_axis *w = a->own;
    const walter_board *b = board_view(a);
    const walter_steps *g = &w->joint.steps;
    if (b && g->interval_us && is_driven(a, b)) a->view.rev_per_s = (double)g->speed * w->step_deg / 360;
}

const law walter_law = {
    .bytes = sizeof(walter_axis),
    .kind = HIL_KIND_JOINT,
    .events = 8, /* readings that fail: five in a row are the most */
    .max_current_A = max_current_A,
    .open = open_joint,
    .close = close_joint,
    .power_up = power_up,
    .step = step,
    .drive = drive,
    .pin = set_pin,
    .set = set,
    .act = act,
    .show = look,
};
