/* What an axis-tick costs in the core: AXES groups of one axis, each with its own table, in closed loop with
   set-points that move as in reference_axis.c. Taken a millisecond further at a time, as the real-time thread does.

   axis_cost AXES TICKS simple|full virtual [TOGETHER [LANES]]  prints ns of CPU time per axis-tick; control steps of an axis;
                                                                degrees of axis 0
   axis_cost AXES SECONDS simple|full rt [TOGETHER [LANES]]     prints the real-time thread's share of a core; control steps of
                                                                axis 0 a second

   TOGETHER: axes a group, 1 without it. LANES: none, any, avx2 or avx512; the widest without it. */
#define _GNU_SOURCE
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "batch.h"
#include "hil_core.h"

#define WAKE_NS 1000000
#define MOVE_TICKS 650

/* device_profiles/mechaduino/profile.yaml */
static const hil_axis_params SIMPLE = {
    .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 0.004, .torque_constant_Nm_per_A = 0.225,
    .sense_resistor_ohm = 0.15, .rotor_teeth = 50,
};
static const hil_axis_params FULL = {
    .inertia_kg_m2 = 5.4e-6, .viscous_Nm_s_per_rad = 4e-5, .torque_constant_Nm_per_A = 0.155,
    .sense_resistor_ohm = 0.15, .rotor_teeth = 50, .is_full = 1,
    .full = {.phase_resistance_ohm = 1.1, .phase_inductance_H = 2.6e-3, .supply_V = 24, .detent_torque_Nm = 0.015,
             .coulomb_torque_Nm = 0.008, .full_step_error_pct = 5, .encoder_eccentricity_deg = 0.5,
             .encoder_nonlinearity_deg = 0.2, .encoder_noise_counts = 0.7},
};

static double seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

static void move(hil_core *c, int axes, int64_t tick, int owned)
{
    for (int i = 0; i < axes; i++) {
        if (!owned) hil_group_acquire(c, c->axes[i].group);
        hil_axis_set(c, i, HIL_FIELD_r, (double)((tick / MOVE_TICKS + i) % 8 * 45));
        if (!owned) hil_group_release(c, c->axes[i].group);
    }
}

static hil_core *build(int axes, int together, hil_axis_params params)
{
    int fd;
    hil_core *c = hil_core_new(axes, &fd);
    if (!c) exit(2);
    for (int i = 0; i < axes; i++) {
        int group = i % together ? c->axes[i - 1].group : hil_group_open(c, 0);
        hil_group_set_horizon(c, group, HIL_FOREVER);
        params.seed = (uint64_t)i;
        if (hil_axis_open(c, group, &params) != i) exit(2);
        for (int k = 0; k < HIL_TABLE_LEN; k++) hil_axis_table(c, i)[k] = (float)(k * 360.0 / HIL_TABLE_LEN);
        hil_axis_set(c, i, HIL_FIELD_mode, 'x');
        hil_axis_loop(c, i, 1);
    }
    return c;
}

static void print_tick_ns(hil_core *c, int axes, int64_t ticks)
{
    int n = c->groups_used, *groups = malloc((size_t)n * sizeof *groups);
    for (int i = 0; i < n; i++) groups[i] = i;
    int64_t now_ns = 0, moved = -1, done = 0;
    double began_s = seconds(CLOCK_PROCESS_CPUTIME_ID);
    for (; done < ticks; done = (int64_t)hil_axis_get(c, 0, HIL_FIELD_control_steps)) {
        if (done / MOVE_TICKS != moved) move(c, axes, done, 1);
        moved = done / MOVE_TICKS;
        now_ns += WAKE_NS;
        for (int i = 0; i < n; i += BATCH_GROUPS)
            batch_advance(c, groups + i, n - i < BATCH_GROUPS ? n - i : BATCH_GROUPS, now_ns);
    }
    double took_s = seconds(CLOCK_PROCESS_CPUTIME_ID) - began_s;
    free(groups);
    int64_t least = done, most = done;
    for (int i = 0; i < axes; i++) {
        int64_t steps = (int64_t)hil_axis_get(c, i, HIL_FIELD_control_steps);
        least = steps < least ? steps : least;
        most = steps > most ? steps : most;
    }
    if (least < most - 1) exit(3);
    printf("%.4f %lld %.3f\n", took_s * 1e9 / (double)done / axes, (long long)least, hil_axis_get(c, 0, HIL_FIELD_position_deg));
}

static void print_real_time_share(hil_core *c, int axes, int64_t run_s)
{
    for (int i = 0; i < c->groups_used; i++) hil_group_release(c, i);
    hil_rt_options options = {.period_ns = WAKE_NS, .speed = 1, .priority = 10, .cpu = -1};
    if (hil_rt_start(c, &options)) exit(2);
    clockid_t clock;
    if (pthread_getcpuclockid(c->rt.thread, &clock)) exit(2);
    double began_s = seconds(CLOCK_MONOTONIC), cpu_s = seconds(clock);
    hil_group_acquire(c, 0);
    double steps = hil_axis_get(c, 0, HIL_FIELD_control_steps);
    hil_group_release(c, 0);
    struct timespec rest = {.tv_nsec = 100000000};
    int64_t tick = 0;
    for (; seconds(CLOCK_MONOTONIC) - began_s < (double)run_s; tick += MOVE_TICKS) {
        move(c, axes, tick, 0);
        nanosleep(&rest, NULL);
    }
    double took_s = seconds(CLOCK_MONOTONIC) - began_s, share = (seconds(clock) - cpu_s) / took_s;
    hil_group_acquire(c, 0);
    steps = hil_axis_get(c, 0, HIL_FIELD_control_steps) - steps;
    hil_group_release(c, 0);
    hil_rt_stats stats;
    hil_rt_stats_read(c, &stats);
    hil_rt_stop(c);
    double lag_ns = 0;
    for (int i = 0; i < c->groups_used; i++) {
        double behind_ns = (double)stats.elapsed_ns - (double)hil_group_now(c, i);
        lag_ns = behind_ns > lag_ns ? behind_ns : lag_ns;
    }
    fprintf(stderr, "missed %lld of %lld wakes, %lld overruns, at most %.3f ms behind\n", (long long)stats.missed,
            (long long)(stats.ticks + stats.missed), (long long)stats.overruns, lag_ns * 1e-6);
    printf("%.4f %.1f\n", share, steps / took_s);
}

static void choose(hil_core *c, const char *wanted)
{
    static const char *const NAMES[] = {
#define LANES_OF(name, value, python, meaning) [value] = #python,
#include "abi.def"
    };
    for (int i = 0; i < HIL_LANES_MOST; i++)
        if (!strcmp(NAMES[i], wanted) && !hil_core_set_lanes(c, (hil_lanes)i)) return;
    exit(4);
}

int main(int argc, char **argv)
{
    if (argc < 5) return 2;
    int axes = atoi(argv[1]), together = argc > 5 ? atoi(argv[5]) : 1;
    hil_core *c = build(axes, together, strcmp(argv[3], "full") ? SIMPLE : FULL);
    if (argc > 6) choose(c, argv[6]);
    if (!strcmp(argv[4], "rt")) print_real_time_share(c, axes, atoll(argv[2]));
    else print_tick_ns(c, axes, atoll(argv[2]));
    hil_core_free(c);
    return 0;
}
