/* One joint of Walter's Cortex without its motor: the step generator (an AccelStepper with changes), the ramp that a
   command makes, the encoder's filter and the drive law of a sample. In float32, each operation rounded; fused only
   where fmaf is written. Times are microseconds and milliseconds since power-up, in the board's 32 bits. */
#ifndef HIL_CONTROL_JOINT_H
#define HIL_CONTROL_JOINT_H

#include <stdint.h>

typedef struct walter_steps {
    int32_t position, target, n;
    uint32_t interval_us, last_us;
    int dir; /* 1: up */
    float max_speed, speed, acceleration, c0, cn, cmin, half_per_acceleration;
} walter_steps;

void walter_steps_init(walter_steps *g);
void walter_steps_speed(walter_steps *g, float steps_per_s);
void walter_steps_acceleration(walter_steps *g, float steps_per_s2);
void walter_steps_target(walter_steps *g, int32_t target);
/* The step that is due, 1 or -1 by the sign of the speed; 0: none. */
int walter_steps_poll(walter_steps *g, uint32_t now_us);

/* Microseconds until a poll makes a step; -1: never. */
static inline int64_t walter_steps_due_us(const walter_steps *g, uint32_t now_us)
{
    uint32_t since_us = now_us - g->last_us;
    if (!g->interval_us) return -1;
    return since_us >= g->interval_us ? 0 : (int64_t)(g->interval_us - since_us);
}

/* From one angle to another; start_ms 0: none. */
typedef struct walter_ramp {
    float start_deg, end_deg, per_ms;
    uint32_t start_ms, end_ms;
} walter_ramp;

void walter_ramp_set(walter_ramp *r, float start_deg, float end_deg, uint32_t now_ms, uint32_t duration_ms);
float walter_ramp_at(const walter_ramp *r, uint32_t now_ms);

/* What a joint is and how it is set; the angles are the joint's. */
typedef struct walter_setting {
    float gear, null_deg, offset_deg, min_deg, max_deg, kP, kI;
    float speed_rpm, acceleration_rpm_per_s;
    int32_t microsteps;
    int32_t counts_backwards; /* its motor turns the other way, and its own count of pulses does */
} walter_setting;

typedef struct walter_joint {
    walter_setting is;
    walter_steps steps;
    walter_ramp ramp;
    int is_known; /* an angle was measured once */
    float measured_deg; /* by the latest sample, and by own pulses since */
    float filtered_deg; /* of the encoder, without offset */
    float last_to_be_deg, integral;
    uint32_t filtered_ms; /* of the encoder's latest filtered reading */
} walter_joint;

void walter_joint_init(walter_joint *j, const walter_setting *setting);
float walter_full_speed(const walter_setting *s);        /* micro-steps/s */
float walter_full_acceleration(const walter_setting *s); /* micro-steps/s2 */
/* A reading of the encoder, already the right way round. */
void walter_joint_read(walter_joint *j, int count, int is_filtered, uint32_t now_ms);
static inline float walter_joint_encoder_deg(const walter_joint *j) { return j->filtered_deg - j->is.offset_deg; }
void walter_joint_sample(walter_joint *j, float measured_deg, uint32_t now_ms);
/* To an angle within a time, from where the ramp is now; cut to the limits. Nothing before the first sample. */
void walter_joint_move(walter_joint *j, float to_deg, uint32_t now_ms, uint32_t duration_ms);
/* From the measured angle by so much; not cut. */
void walter_joint_move_by(walter_joint *j, float by_deg, uint32_t now_ms, uint32_t duration_ms);
void walter_joint_count(walter_joint *j, int is_up); /* a pulse that its driver takes */

static inline int32_t walter_whole(double x) /* as the processor's conversion: cut, saturated, 0 for no number */
{
    if (x != x) return 0;
    if (x >= 2147483647.0) return INT32_MAX;
    return x <= -2147483648.0 ? INT32_MIN : (int32_t)x;
}

/* The count of 16384 nearest to an angle. */
int walter_count(double deg);

#endif
