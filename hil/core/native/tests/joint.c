/* A joint of Walter's Cortex alone: settings of all kinds, extremes of its step generator, the clock's wrap. */
#include "../control/joint.h"

#include <math.h>

#include "check.h"

static walter_joint hip(void)
{
    walter_joint j;
    walter_joint_init(&j, &(walter_setting){.gear = 9, .microsteps = 8, .null_deg = 143, .min_deg = -90, .max_deg = 90, .kP = 0.4f,
                                            .speed_rpm = 100, .acceleration_rpm_per_s = 700});
    walter_steps_speed(&j.steps, walter_full_speed(&j.is));
    walter_steps_acceleration(&j.steps, walter_full_acceleration(&j.is));
    return j;
}

static void settings_become_steps(void)
{
    walter_joint j = hip();
    CHECK_NEAR(walter_full_speed(&j.is), 2666.67, 0.01);
    CHECK_NEAR(walter_full_acceleration(&j.is), 18666.67, 0.01);
}

static void a_count_is_the_nearest_of_a_turn(void)
{
    CHECK_INT(walter_count(0), 0);
    CHECK_INT(walter_count(-0.001), 0);
    CHECK_INT(walter_count(360), 0);
    CHECK_INT(walter_count(-90), 12288);
    CHECK_INT(walter_count(1e300), 0);
}

static void a_filtered_angle_comes_nearer(void)
{
    walter_joint j = hip();
    walter_joint_read(&j, walter_count(143 + 10), 1, 20);
    CHECK_NEAR(walter_joint_encoder_deg(&j), 8, 0.02);
    walter_joint_read(&j, walter_count(143 + 10), 1, 40);
    CHECK_NEAR(walter_joint_encoder_deg(&j), 9.6, 0.02);
    walter_joint_read(&j, walter_count(143 - 170), 0, 60);
    CHECK_NEAR(walter_joint_encoder_deg(&j), -170, 0.02);
}

/* Nothing but numbers comes of settings that nobody would make. */
static void odd_settings_are_survived(void)
{
    static const float ODD[] = {0, -700, 1e-30f, 1e30f, 99998};
    for (int i = 0; i < 25; i++) {
        walter_joint j = hip();
        j.is.acceleration_rpm_per_s = ODD[i % 5];
        j.is.speed_rpm = ODD[i / 5];
        walter_steps_speed(&j.steps, walter_full_speed(&j.is));
        walter_steps_acceleration(&j.steps, walter_full_acceleration(&j.is));
        walter_joint_sample(&j, 0, 1000);
        walter_joint_move(&j, 60, 1000, 500);
        for (uint32_t ms = 1020; ms < 3000; ms += 20) {
            walter_joint_sample(&j, (float)(j.steps.position * 0.025), ms);
            for (uint32_t us = ms * 1000; us < ms * 1000 + 20000; us += 500) (void)walter_steps_poll(&j.steps, us);
        }
        CHECK(isfinite(j.measured_deg));
    }
}

static void a_joint_goes_on_over_the_wrap_of_the_microseconds(void)
{
    walter_joint j = hip();
    walter_steps_target(&j.steps, 1000);
    uint32_t us = UINT32_MAX - 100000;
    int made = 0;
    for (int i = 0; i < 200000; i++, us += 10) made += walter_steps_poll(&j.steps, us);
    CHECK_INT(made, 1000);
    CHECK_INT(j.steps.position, 1000);
}

static void the_last_milliseconds_of_the_clock_are_times_too(void)
{
    walter_joint j = hip();
    walter_joint_sample(&j, 0, 5);
    walter_joint_move(&j, 10, UINT32_MAX - 50, 40);
    walter_joint_sample(&j, 0, UINT32_MAX - 5);
    CHECK_NEAR(j.last_to_be_deg, 10, 0.01);
}

void joint_tests(void)
{
    RUN(settings_become_steps);
    RUN(a_count_is_the_nearest_of_a_turn);
    RUN(a_filtered_angle_comes_nearer);
    RUN(odd_settings_are_survived);
    RUN(a_joint_goes_on_over_the_wrap_of_the_microseconds);
    RUN(the_last_milliseconds_of_the_clock_are_times_too);
}
