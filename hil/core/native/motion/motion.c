/* What runs: commands one after the other, their pulses, and what cuts them. */
#include "motion.h"

#include <string.h>

#include "profile.h"
#include "queue.h"

/* LOAD: 16 us to load a command that is no seamless continuation; LEAST: of a pulse's period */
enum { LOAD = 32, LEAST = 4, NO_RAMP = 99900 };

static void rest(motion *m)
{
    m->state = MOTION_STANDBY;
    m->slot = -1;
    m->what = WHAT_NOTHING;
    m->next = MOTION_NEVER;
    m->is_held = m->op_sa = 0;
}

static int is_running(const motion *m) { return m->slot >= 0 && m->what == WHAT_PULSE; }

/* While a command runs, one that preempts it waits for the end of a period. */
int64_t motion_next(const motion *m)
{
    return !is_running(m) && m->preempt_at < m->next ? m->preempt_at : m->next;
}

static int32_t between(int32_t x, int32_t least, int32_t most) { return x < least ? least : x > most ? most : x; }

/* What the EEPROM may hold, made such that it can run. */
static motion_setup usable(const motion_setup *setup)
{
    motion_setup s = *setup;
    s.steps_per_rev = between(s.steps_per_rev, 1, 60000000);
    s.slow_rpm = between(s.slow_rpm, 0, INT32_MAX);
    s.microstep_exponent = between(s.microstep_exponent, 0, 7);
    s.pulse_us = between(s.pulse_us, 0, INT32_MAX);
    s.is_cw_high = s.is_cw_high != 0;
    return s;
}

void motion_init(motion *m, const motion_setup *setup)
{
    memset(m, 0, sizeof *m);
    m->setup = usable(setup);
    m->clock_Hz = -1;
    m->preempt_slot = -1;
    m->is_gap_on = 1;
    m->in_play_rpm = m->setup.slow_rpm;
    m->sync_level = m->estop_level = 1; /* pulled up */
    m->dir_level = m->setup.is_cw_high;
    m->preempt_at = MOTION_NEVER;
    rest(m);
}

void motion_configure(motion *m, const motion_setup *setup, int64_t now)
{
    motion_stop(m, now);
    m->setup = usable(setup);
    m->in_play_rpm = m->setup.slow_rpm;
}

/* ---- from load to end ---- */

static void load(motion *m, int slot, int64_t base)
{
    m->slot = slot;
    m->now = m->entries[slot];
    if (m->now.is_sync || m->now.wait_us > 0) m->state = MOTION_STANDBY; /* else STOP lasts until it is loaded */
    m->is_held = m->now.is_sync;
    m->held_base = base;
    m->what = m->is_held ? WHAT_NOTHING : WHAT_START;
    m->next = m->is_held ? MOTION_NEVER : base + 2 * (int64_t)m->now.wait_us;
}

static void load_next(motion *m, int64_t now, int is_seamless)
{
    int slot = queue_next(m);
    if (slot < 0) {
        rest(m);
        return;
    }
    const motion_entry *e = &m->entries[slot];
    load(m, slot, is_seamless && !e->is_sync && e->wait_us == 0 ? now : now + LOAD);
}

static void end(motion *m, int64_t now, int64_t in_play_rpm)
{
    m->in_play_rpm = in_play_rpm;
    m->in_play_until = now;
    m->op_sa = 0;
    m->ended++;
    m->state = MOTION_STOP;
}

/* The pulse that comes now has which period; half-us by the board's own clock. */
static int64_t pulse_period(const motion *m)
{
    int j = m->setup.microstep_exponent;
    int64_t step = 2 * m->period_us;
    return (step * (m->pulse + 1) >> j) - (step * m->pulse >> j);
}

/* From there to simulated time: the external clock's rate, and the calibration of each pulse. */
static int64_t real_period(const motion *m, int64_t period, int64_t *rest)
{
    const motion_setup *s = &m->setup;
    int64_t correction = 2 * (s->clock_correction_us - s->interrupt_overhead_us + 8);
    if (!s->is_clock_internal && m->clock_Hz >= 0) {
        __int128 scaled = (__int128)period * s->external_clock_Hz + *rest;
        period = (int64_t)(scaled / m->clock_Hz);
        *rest = (int64_t)(scaled % m->clock_Hz);
    }
    period += correction;
    return period < LEAST ? LEAST : period;
}

static int is_clock_dead(const motion *m) { return !m->setup.is_clock_internal && m->clock_Hz == 0; }

int64_t motion_tells(const motion *m)
{
    int64_t next = motion_next(m), rest = 0;
    if (!is_running(m) || m->preempt_at != MOTION_NEVER || next == MOTION_NEVER || is_clock_dead(m)) return next;
    if (m->cruise_left < 0) return MOTION_NEVER;
    /* A pulse is no shorter than its share of a cruise's step, or than all may be. */
    int64_t period = real_period(m, 2 * profile_period(m, m->now.cycle_us) >> m->setup.microstep_exponent, &rest);
    __int128 tells = next + (__int128)m->cruise_left * period + (__int128)(m->accel_left + m->decel_left) * LEAST;
    return tells < MOTION_NEVER ? (int64_t)tells : MOTION_NEVER;
}

/* A pulse rises; m->next becomes the end of its period. */
static void pulse(motion *m, int64_t now)
{
    int j = m->setup.microstep_exponent;
    if (m->accel_left > 0) {
        m->state = MOTION_ACCEL;
        if (m->pulse == 0) m->period_us = profile_period(m, ramp_next_us(&m->accel));
        m->accel_left--;
    } else if (m->cruise_left != 0) {
        if (m->state != MOTION_CRUISE) {
            m->state = MOTION_CRUISE;
            m->pulse = 0;
        }
        m->period_us = profile_period(m, m->now.cycle_us);
        if (m->cruise_left > 0) m->cruise_left--;
    } else {
        m->state = MOTION_DECEL;
        if (!m->is_decel_set) {
            m->is_decel_set = 1;
            /* Anchored at its end: a ramp of pulses begins within a step. */
            m->pulse = (int32_t)(-m->decel_left & ((1 << j) - 1));
            profile_decel(m);
            m->period_us = profile_period(m, ramp_next_us(&m->decel));
        } else if (m->pulse == 0)
            m->period_us = profile_period(m, ramp_next_us(&m->decel));
        m->decel_left--;
    }
    int64_t period = real_period(m, pulse_period(m), &m->rest);
    m->pulse = (m->pulse + 1) & ((1 << j) - 1);
    m->fall_after = 2 * m->setup.pulse_us < period - 2 ? 2 * m->setup.pulse_us : period - 2;
    if (m->fall_after < 1) m->fall_after = 1;
    m->pulses += m->now.is_ccw ? -1 : 1;
    m->next = now + period;
}

static void start(motion *m, int64_t now)
{
    int64_t from_rpm = m->in_play_rpm;
    if (m->is_gap_on && now > m->in_play_until) from_rpm = m->setup.slow_rpm;
    m->op_sa = 1;
    m->begun++;
    m->dir_level = m->now.is_ccw ? !m->setup.is_cw_high : m->setup.is_cw_high;
    m->pulse = 0;
    m->rest = 0;
    m->period_us = 0;
    m->state = MOTION_ACCEL;
    profile_begin(m, from_rpm);
    m->what = WHAT_PULSE;
}

/* What was running, waiting or held is gone; the queue and the loops go on with their next entry later. */
static void preempt(motion *m, int64_t now)
{
    m->slot = m->preempt_slot;
    m->now = m->entries[m->slot];
    m->preempt_slot = -1;
    m->preempt_at = MOTION_NEVER;
    m->is_held = 0;
    m->what = WHAT_START;
    m->next = now;
}

/* The end of a pulse's period: the next pulse, the command's end, or another command. */
static int boundary(motion *m, int64_t now)
{
    if (m->preempt_at <= now) {
        end(m, now, profile_rpm(m));
        preempt(m, now);
        return 0;
    }
    if (m->accel_left == 0 && m->cruise_left == 0 && m->decel_left == 0) {
        int is_stopped = m->decel_steps > 0;
        end(m, now, is_stopped ? m->setup.slow_rpm : (int64_t)m->now.rpm);
        load_next(m, now, !is_stopped);
        return 0;
    }
    if (is_clock_dead(m)) {
        m->next = MOTION_NEVER;
        return 0;
    }
    pulse(m, now);
    return 1;
}

int motion_run(motion *m)
{
    int64_t now = motion_next(m);
    if (!is_running(m) && m->preempt_at <= now) {
        preempt(m, now);
        return 0;
    }
    if (m->what == WHAT_START) {
        start(m, now);
        if (m->accel_left == 0 && m->cruise_left == 0 && m->decel_left == 0) m->next = now + LOAD; /* no step at all */
        return 0;
    }
    return boundary(m, now);
}

/* ---- what the firmware asks for ---- */

static void wake(motion *m, int64_t now)
{
    if (m->slot >= 0) return;
    load_next(m, now, 0);
    if (m->slot >= 0 && !m->is_held) m->next -= LOAD; /* from STANDBY a command comes at once */
    if (m->slot >= 0) m->held_base = now;
}

void motion_enqueue(motion *m, int slot, int64_t now)
{
    if (queue_add(m, slot)) wake(m, now);
}

void motion_once(motion *m, int slot, int64_t now)
{
    const motion_entry *e = &m->entries[slot];
    m->preempt_slot = slot;
    m->preempt_held = e->is_sync;
    m->preempt_at = e->is_sync ? MOTION_NEVER : now + 2 * (int64_t)e->wait_us;
}

void motion_retarget(motion *m, uint32_t rpm, uint32_t cycle_us, int64_t now)
{
    (void)now;
    if (!is_running(m) || m->slot != MOTION_CONTINUOUS_SLOT || m->cruise_left >= 0) return; /* >= 0: it stops already */
    int64_t from_rpm = profile_rpm(m);
    m->now.rpm = rpm;
    m->now.cycle_us = cycle_us;
    m->pulse = 0;
    m->state = MOTION_ACCEL;
    profile_begin(m, from_rpm);
}

int motion_single(motion *m, int is_ccw, int64_t now)
{
    (void)now;
    if (m->slot >= 0) return 0;
    m->dir_level = is_ccw ? !m->setup.is_cw_high : m->setup.is_cw_high;
    m->pulses += is_ccw ? -1 : 1;
    m->fall_after = 2 * m->setup.pulse_us > 0 ? 2 * m->setup.pulse_us : 1;
    return 1;
}

static void drop_all(motion *m)
{
    queue_drop(m);
    m->preempt_slot = -1;
    m->preempt_at = MOTION_NEVER;
}

/* At once: no further pulse. */
static void cut(motion *m, int64_t now)
{
    if (m->op_sa) end(m, now, m->setup.slow_rpm);
    m->in_play_rpm = m->setup.slow_rpm;
    rest(m);
}

void motion_stop(motion *m, int64_t now)
{
    drop_all(m);
    cut(m, now);
}

/* Decelerates from the end of the present period on; 0: there is nothing to ramp down. */
static int decelerate(motion *m, int32_t dec_hundredths)
{
    if (!is_running(m) || dec_hundredths <= 0 || dec_hundredths >= NO_RAMP) return 0;
    if (m->state == MOTION_DECEL) return 1;
    m->now.dec_hundredths = dec_hundredths;
    return profile_stop(m, profile_rpm(m));
}

void motion_stop_gracefully(motion *m, int32_t dec_hundredths, int64_t now)
{
    drop_all(m);
    if (!decelerate(m, dec_hundredths)) cut(m, now);
}

void motion_next_command(motion *m, int is_graceful, int64_t now)
{
    if (m->slot < 0) return;
    if (is_graceful && decelerate(m, m->now.dec_hundredths)) return;
    cut(m, now);
    load_next(m, now, 0);
}

void motion_finish(motion *m, int64_t now)
{
    drop_all(m);
    if (!is_running(m)) {
        cut(m, now);
        return;
    }
    if (m->slot == MOTION_CONTINUOUS_SLOT && !decelerate(m, m->now.dec_hundredths)) cut(m, now);
}

void motion_loop_bounds(motion *m, int start, int finish, int64_t now)
{
    motion_loop next = m->loop;
    if (start) next.start = start;
    if (finish) next.finish = finish;
    if (next.start == next.finish) return; /* equal ends are refused */
    m->loop = next;
    if (next.is_on || next.start == 0 || next.finish == 0) return;
    m->loop.is_on = 1;
    m->loop.at = next.start;
    wake(m, now);
}

void motion_loop_passes(motion *m, int64_t passes) { m->loop.passes = passes; }

void motion_loop_array(motion *m, int64_t passes, int64_t now)
{
    if (m->xref[0] == 0) return;
    m->array = (motion_loop){.is_on = 1, .passes = passes};
    wake(m, now);
}

void motion_release_sync(motion *m, int64_t now)
{
    if (m->preempt_slot >= 0 && m->preempt_held) {
        m->preempt_held = 0;
        m->preempt_at = now + 2 * (int64_t)m->entries[m->preempt_slot].wait_us;
    }
    if (m->slot >= 0 && m->is_held) {
        m->is_held = 0;
        m->what = WHAT_START;
        int64_t base = now > m->held_base ? now : m->held_base;
        m->next = base + 2 * (int64_t)m->now.wait_us;
    }
}

void motion_clock(motion *m, int64_t clock_Hz, int64_t now)
{
    m->clock_Hz = clock_Hz;
    if (m->slot >= 0 && m->what == WHAT_PULSE && m->next == MOTION_NEVER && !is_clock_dead(m)) m->next = now;
}
