/* A joint of Walter's Cortex alone, fed by calls: its pulses turn it unless it is placed, and its encoder is ideal. */
#include <math.h>
#include <stdlib.h>

#include "control/joint.h"
#include "hil_core.h"

struct hil_joint_replay {
    walter_joint joint;
    double deg, step_deg;
    int64_t origin_us, poll_us; /* looks for pulses are a whole number of poll_us from the origin */
};

hil_joint_replay *hil_joint_replay_new(const hil_axis_params *params, double min_deg, double max_deg, double kP,
                                       double speed_rpm, double acceleration_rpm_per_s, int64_t origin_us, int64_t poll_us)
{
    hil_joint_replay *p = calloc(1, sizeof *p);
    if (!p) return NULL;
    walter_setting is = {.gear = (float)params->gear_ratio, .microsteps = params->driver_microsteps, .min_deg = (float)min_deg,
                         .max_deg = (float)max_deg, .kP = (float)kP, .speed_rpm = (float)speed_rpm,
                         .acceleration_rpm_per_s = (float)acceleration_rpm_per_s};
    walter_joint_init(&p->joint, &is);
    p->deg = params->start_deg;
    p->origin_us = origin_us;
    p->poll_us = poll_us;
    p->step_deg = (double)1.8f / is.microsteps / (double)is.gear;
    return p;
}

void hil_joint_replay_set(hil_joint_replay *p, int what, double value)
{
    if (what == 0) walter_steps_speed(&p->joint.steps, (float)value);
    else if (what == 1) walter_steps_acceleration(&p->joint.steps, (float)value);
    else walter_steps_target(&p->joint.steps, walter_whole(value));
}

void hil_joint_replay_set_up(hil_joint_replay *p)
{
    walter_steps_speed(&p->joint.steps, walter_full_speed(&p->joint.is));
    walter_steps_acceleration(&p->joint.steps, walter_full_acceleration(&p->joint.is));
}

void hil_joint_replay_move(hil_joint_replay *p, double to_deg, uint32_t now_ms, uint32_t duration_ms)
{
    walter_joint_move(&p->joint, (float)to_deg, now_ms, duration_ms);
}

void hil_joint_replay_sample(hil_joint_replay *p, double measured_deg, uint32_t now_ms)
{
    if (isnan(measured_deg)) {
        walter_joint_read(&p->joint, walter_count(p->deg), 0, now_ms);
        measured_deg = (double)p->joint.filtered_deg;
    }
    walter_joint_sample(&p->joint, (float)measured_deg, now_ms);
}

int64_t hil_joint_replay_step(hil_joint_replay *p, int64_t from_us, int64_t until_us, int *dir)
{
    int64_t due_us = walter_steps_due_us(&p->joint.steps, (uint32_t)from_us);
    if (due_us < 0) return -1;
    int64_t polls = (from_us + due_us - p->origin_us + p->poll_us - 1) / p->poll_us;
    int64_t at_us = p->origin_us + polls * p->poll_us;
    if (at_us >= until_us) return -1;
    *dir = walter_steps_poll(&p->joint.steps, (uint32_t)at_us);
    p->deg += *dir * p->step_deg;
    return at_us;
}

double hil_joint_replay_deg(const hil_joint_replay *p) { return p->deg; }

void hil_joint_replay_place(hil_joint_replay *p, double deg) { p->deg = deg; }

void hil_joint_replay_read(const hil_joint_replay *p, hil_joint_row *row)
{
    const walter_joint *j = &p->joint;
    const walter_steps *g = &j->steps;
    *row = (hil_joint_row){.measured_deg = j->measured_deg, .to_be_deg = j->last_to_be_deg, .integral = j->integral,
                           .speed = g->speed, .acceleration = g->acceleration, .c0 = g->c0, .cn = g->cn, .cmin = g->cmin,
                           .position = g->position, .target = g->target, .n = g->n,
                           .interval_us = (int32_t)g->interval_us, .dir = g->dir};
}

void hil_joint_replay_free(hil_joint_replay *p) { free(p); }
