#include "joint.h"

#include <math.h>

#define FULL_STEP_DEG 1.8f
#define STEPS_PER_DEG (1.0f / FULL_STEP_DEG)
#define SAMPLE_S 0.02f
#define SAMPLES_PER_S 50.0f
#define FILTER_S 0.005f

/* ---- the step generator ---- */

static int32_t steps_to_stop(const walter_steps *g) { return walter_whole(g->speed * g->speed * g->half_per_acceleration); }

static void rest(walter_steps *g)
{
    g->interval_us = 0;
    g->speed = 0;
    g->n = 0;
}

static void update(walter_steps *g)
{
    int64_t left = (int64_t)g->target - g->position, stop = steps_to_stop(g);
    if (left == 0 && stop <= 1) {
        rest(g);
        return;
    }
    int64_t way = left > 0 ? left : -left;
    int is_wrong_way = left != 0 && g->dir == (left < 0);
    if (left != 0 && g->n > 0) {
        if (stop >= way || is_wrong_way) g->n = (int32_t)-stop;
    } else if (left != 0 && g->n < 0) {
        if (stop < way && !is_wrong_way) g->n = -g->n;
    }
    if (g->n == 0) {
        g->cn = g->c0;
        g->dir = left > 0;
    } else {
        g->cn = g->cn - (g->cn + g->cn) / (float)(4 * (int64_t)g->n + 1);
        if (!(g->cn > g->cmin)) g->cn = g->cmin;
    }
    if (g->n < INT32_MAX) g->n++;
    g->interval_us = (uint32_t)walter_whole(g->cn);
    g->speed = 1e6f / g->cn;
    if (!g->dir) g->speed = -g->speed;
}

void walter_steps_init(walter_steps *g)
{
    *g = (walter_steps){.cn = 1, .max_speed = 1, .acceleration = 1, .half_per_acceleration = 0.5f};
    g->c0 = sqrtf(2e12f);
}

void walter_steps_speed(walter_steps *g, float steps_per_s)
{
    if (g->max_speed == steps_per_s) return;
    g->max_speed = steps_per_s;
    g->cmin = 1e6f / steps_per_s;
    if (g->n <= 0) return;
    g->n = steps_to_stop(g);
    update(g);
}

void walter_steps_acceleration(walter_steps *g, float steps_per_s2)
{
    if (steps_per_s2 == 0 || g->acceleration == steps_per_s2) return;
    g->n = walter_whole((float)g->n * (g->acceleration / steps_per_s2));
    g->c0 = sqrtf(2e12f / steps_per_s2);
    g->acceleration = steps_per_s2;
    g->half_per_acceleration = 0.5f / steps_per_s2;
    update(g);
}

void walter_steps_target(walter_steps *g, int32_t target)
{
    if (g->target == target) return;
    g->target = target;
    update(g);
}

int walter_steps_poll(walter_steps *g, uint32_t now_us)
{
    if (!g->interval_us || now_us - g->last_us < g->interval_us) return 0;
    int step = g->speed > 0 ? 1 : -1;
    g->position = (int32_t)((uint32_t)g->position + (g->dir ? 1u : UINT32_MAX));
    g->last_us = now_us;
    update(g);
    return step;
}

/* ---- the ramp ---- */

void walter_ramp_set(walter_ramp *r, float start_deg, float end_deg, uint32_t now_ms, uint32_t duration_ms)
{
    if (!duration_ms) duration_ms = 1;
    *r = (walter_ramp){.start_deg = start_deg, .end_deg = end_deg, .start_ms = now_ms, .end_ms = now_ms + duration_ms,
                       .per_ms = 1.0f / (float)duration_ms};
}

float walter_ramp_at(const walter_ramp *r, uint32_t now_ms)
{
    if (now_ms >= r->end_ms) return r->end_deg;
    return fmaf((float)(now_ms - r->start_ms) * r->per_ms, r->end_deg - r->start_deg, r->start_deg);
}

/* ---- a joint ---- */

void walter_joint_init(walter_joint *j, const walter_setting *setting)
{
    *j = (walter_joint){.is = *setting};
    walter_steps_init(&j->steps);
}

float walter_full_speed(const walter_setting *s) { return s->speed_rpm * 6.0f / (FULL_STEP_DEG / (float)s->microsteps); }

float walter_full_acceleration(const walter_setting *s)
{
    return s->acceleration_rpm_per_s * 6.0f * ((float)s->microsteps * STEPS_PER_DEG);
}

int walter_count(double deg)
{
    double counts = floor(deg / 360 * 16384 + 0.5);
    return fabs(counts) < 0x1p50 ? (int)((int64_t)counts & 16383) : 0;
}

void walter_joint_read(walter_joint *j, int count, int is_filtered, uint32_t now_ms)
{
    float deg = (float)(count / 16384.0 * 360.0) - j->is.null_deg;
    if (deg > 180) deg -= 360;
    if (deg < -180) deg += 360;
    if (!is_filtered) {
        j->filtered_deg = deg;
        return;
    }
    float c = FILTER_S / fmaf((float)(now_ms - j->filtered_ms), 0.001f, FILTER_S);
    j->filtered_ms = now_ms;
    j->filtered_deg = fmaf(1.0f - c, deg, c * j->filtered_deg);
}

static uint32_t whole_ms(float x) { return x >= 4294967296.0f ? UINT32_MAX : (uint32_t)x; }

static float steps_of(const walter_joint *j, float deg) { return deg * j->is.gear * (float)j->is.microsteps * STEPS_PER_DEG; }

/* Also where the limit is negative, as it can be set. */
static float cut(float x, float low, float high) { return x < low ? low : x > high ? high : x; }

void walter_joint_sample(walter_joint *j, float measured_deg, uint32_t now_ms)
{
    j->measured_deg = measured_deg;
    if (!j->is_known) {
        j->last_to_be_deg = measured_deg;
        j->is_known = 1;
    }
    if (!j->ramp.start_ms) return;
    float to_be = walter_ramp_at(&j->ramp, now_ms);
    float next = walter_ramp_at(&j->ramp, whole_ms((float)now_ms + SAMPLE_S));
    float steps = steps_of(j, to_be - j->last_to_be_deg), next_steps = steps_of(j, next - to_be);
    float error = steps_of(j, to_be - measured_deg);
    j->integral = fmaf(error, SAMPLE_S, j->integral);
    float p = j->is.kP * error, i = j->is.kI * j->integral, way = (p + i) + steps;
    float acceleration = (steps - next_steps + error) * SAMPLES_PER_S, limit = walter_full_acceleration(&j->is);
    if ((way > 0 && acceleration > 0) || (way < 0 && acceleration < 0)) acceleration *= 2;
    walter_steps_acceleration(&j->steps, fabsf(cut(acceleration, -limit, limit)));
    walter_steps_target(&j->steps, (int32_t)((uint32_t)j->steps.position + (uint32_t)walter_whole(way)));
    j->last_to_be_deg = to_be;
}

void walter_joint_move(walter_joint *j, float to_deg, uint32_t now_ms, uint32_t duration_ms)
{
    if (!j->is_known) return;
    to_deg = cut(to_deg, j->is.min_deg, j->is.max_deg);
    walter_ramp_set(&j->ramp, walter_ramp_at(&j->ramp, now_ms), to_deg, now_ms, duration_ms);
}

void walter_joint_move_by(walter_joint *j, float by_deg, uint32_t now_ms, uint32_t duration_ms)
{
    walter_ramp_set(&j->ramp, j->measured_deg, j->measured_deg + by_deg, now_ms, duration_ms);
}

void walter_joint_count(walter_joint *j, int is_up)
{
    float deg = FULL_STEP_DEG / (float)j->is.microsteps / j->is.gear;
    j->measured_deg += is_up == !j->is.counts_backwards ? deg : -deg;
}
