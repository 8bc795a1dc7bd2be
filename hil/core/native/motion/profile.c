#include "profile.h"

static int64_t f_of(const motion *m) { return 60000000 / m->setup.steps_per_rev; }

static int64_t n_of(const motion *m, int64_t rpm, int64_t acc) { return ramp_linear_steps(rpm, acc, m->setup.steps_per_rev); }

/* Sets the ramp from one speed up or down to the target; answers its steps. */
static int64_t accel_ramp(motion *m, int64_t from_rpm, int64_t to_rpm)
{
    int64_t acc = m->now.acc_hundredths, slow = m->setup.slow_rpm;
    if (to_rpm <= slow || acc <= 0 || acc >= 99900) return 0;
    int is_from_stop = from_rpm <= slow;
    if (is_from_stop) from_rpm = slow;
    if (!m->now.is_linear) {
        ramp_harmonic(&m->accel, f_of(m), 100 * from_rpm, to_rpm > from_rpm ? acc : -acc);
        return ramp_harmonic_steps(from_rpm, to_rpm, acc);
    }
    int64_t n1 = is_from_stop ? 0 : n_of(m, from_rpm, acc), n2 = n_of(m, to_rpm, acc);
    if (n2 >= n1) {
        if (is_from_stop) ramp_linear_from_stop(&m->accel, acc, m->setup.steps_per_rev);
        else ramp_linear_from(&m->accel, f_of(m) / from_rpm, n1);
        return n2 - n1;
    }
    ramp_linear_from(&m->accel, f_of(m) / to_rpm, n2);
    ramp_reverse(&m->accel, n1 - n2, &m->list);
    return n1 - n2;
}

/* A ramp of more steps than a move can have is as good as one of 2^48. */
static int64_t bounded(int64_t steps) { return steps < INT64_C(1) << 48 ? steps : INT64_C(1) << 48; }

static int64_t decel_steps(const motion *m, int64_t from_rpm)
{
    int64_t dec = m->now.dec_hundredths, slow = m->setup.slow_rpm;
    if (from_rpm <= slow || dec <= 0 || dec >= 99900) return 0;
    return m->now.is_linear ? n_of(m, from_rpm, dec) : ramp_harmonic_steps(slow, from_rpm, dec);
}

void profile_decel(motion *m)
{
    int64_t dec = m->now.dec_hundredths, steps = m->decel_steps;
    if (m->now.is_linear) {
        ramp_linear_from_stop(&m->decel, dec, m->setup.steps_per_rev);
        ramp_reverse(&m->decel, steps, &m->list);
    } else
        ramp_harmonic(&m->decel, f_of(m), 100 * (int64_t)m->setup.slow_rpm + (steps - 1) * dec, -dec);
}

/* a * total / (a + d) without overflow: the ramps of a slow acceleration may have 2^62 steps. */
static int64_t share(int64_t part, int64_t total, int64_t of) { return (int64_t)((__int128)part * total / of); }

void profile_begin(motion *m, int64_t from_rpm)
{
    int j = m->setup.microstep_exponent, is_endless = m->slot == MOTION_CONTINUOUS_SLOT;
    int64_t a = bounded(accel_ramp(m, from_rpm, m->now.rpm));
    m->accel_left = m->cruise_left = m->decel_left = m->decel_steps = 0;
    m->is_decel_set = 0;
    if (is_endless) {
        m->accel_left = a << j;
        m->cruise_left = -1;
        return;
    }
    int64_t d = bounded(decel_steps(m, m->now.rpm)), total = m->now.steps;
    if (m->now.is_pulses) { /* a step of a ramp has 2^j pulses here too */
        a <<= j;
        d <<= j;
    }
    int is_truncated = a + d > total;
    if (is_truncated) {
        int64_t all = a + d;
        a = share(a, total, all);
        d = share(d, total, all);
        if (d >= 1) d = total - a;
        else a = total;
    }
    int shift = m->now.is_pulses ? 0 : j;
    m->accel_left = a << shift;
    m->decel_left = d << shift;
    m->cruise_left = is_truncated ? 0 : ((total - a - d) << shift) + m->now.extra_pulses;
    m->decel_steps = (m->decel_left + (1 << j) - 1) >> j;
}

int profile_stop(motion *m, int64_t from_rpm)
{
    int64_t d = bounded(decel_steps(m, from_rpm));
    m->accel_left = m->cruise_left = 0;
    m->decel_left = d << m->setup.microstep_exponent;
    m->decel_steps = d;
    m->is_decel_set = 0;
    return d > 0;
}

int64_t profile_rpm(const motion *m)
{
    if (!m->op_sa) return m->in_play_rpm;
    if (m->state == MOTION_CRUISE || m->period_us <= 0) return m->now.rpm;
    return f_of(m) / m->period_us;
}
