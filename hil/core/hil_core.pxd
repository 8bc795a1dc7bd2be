# cython: language_level=3
# What _native.pyx uses of native/hil_core.h.
from libc.stdint cimport int8_t, int16_t, int32_t, int64_t, uint8_t, uint32_t, uint64_t

cdef extern from "native/hil_core.h" nogil:
    int HIL_TABLE_LEN, HIL_HISTOGRAM_LEN, HIL_FIELDS
    ctypedef struct hil_core
    ctypedef int hil_field
    ctypedef struct hil_snapshot:
        pass
    ctypedef struct hil_field_info:
        const char *name
        const char *type
        const char *unit
        const char *meaning
        size_t offset
        int writable
        int kind
    const hil_field_info hil_field_table[]
    ctypedef struct hil_event:
        int64_t at_ns
        int32_t axis
        int32_t kind
        double value
    ctypedef struct hil_edges:
        int64_t at_ns
        int64_t steps
        int64_t duration_ns
        int32_t pin
        int32_t level
    ctypedef struct hil_full_params:
        double phase_resistance_ohm
        double phase_inductance_H
        double supply_V
        double detent_torque_Nm
        double coulomb_torque_Nm
        double full_step_error_pct
        double encoder_eccentricity_deg
        double encoder_nonlinearity_deg
        double encoder_noise_counts
    ctypedef struct hil_load:
        double inertia_kg_m2
        double torque_Nm
        double stiffness_Nm_per_rad
        double pendulum_Nm
        double centre_deg
        double min_deg
        double max_deg
        int32_t end_stops
    ctypedef struct motion_entry:
        uint32_t steps
        uint32_t rpm
        uint32_t cycle_us
        uint32_t wait_us
        int32_t acc_hundredths
        int32_t dec_hundredths
        uint8_t is_ccw
        uint8_t is_linear
        uint8_t extra_pulses
        uint8_t is_sync
        uint8_t is_pulses
    ctypedef struct motion_setup:
        int32_t steps_per_rev
        int32_t slow_rpm
        int32_t microstep_exponent
        int32_t pulse_us
        int32_t interrupt_overhead_us
        int32_t clock_correction_us
        int32_t is_clock_internal
        int32_t is_cw_high
        int32_t ops
        int32_t mode_pins
        int64_t external_clock_Hz
    ctypedef int hil_motion_call
    ctypedef struct hil_edge:
        int64_t at_ns
        int32_t pin
        int32_t level
    void hil_motion_setup(hil_core *, int, const motion_setup *)
    void hil_motion_write(hil_core *, int, int, const motion_entry *)
    void hil_motion_read(hil_core *, int, int, motion_entry *)
    void hil_motion_xref_write(hil_core *, int, int, int)
    int hil_motion_xref(hil_core *, int, int)
    void hil_motion_do(hil_core *, int, hil_motion_call, int64_t, int64_t)
    void hil_axis_record_edges(hil_core *, int, int)
    int hil_axis_take_edges(hil_core *, int, hil_edge *, int)
    int hil_wire(hil_core *, int, int, int, int)
    ctypedef struct hil_axis_params:
        int32_t law
        int32_t driver
        double phase_current_A
        double inertia_kg_m2
        double viscous_Nm_s_per_rad
        double torque_constant_Nm_per_A
        double sense_resistor_ohm
        double start_deg
        double load_torque_Nm
        int32_t rotor_teeth
        int32_t is_full
        hil_full_params full
        hil_load load
        uint64_t seed
    ctypedef struct hil_rt_options:
        int64_t period_ns
        double speed
        int priority
        int cpu
    ctypedef struct hil_rt_stats:
        int64_t ticks
        int64_t missed
        int64_t elapsed_ns
        int64_t overruns
        uint64_t wake_latency[320]
        int64_t longest_latency_ns
        int64_t latency_total_ns
        int fifo_errno
        int pin_errno
        int lock_errno
        int running
    hil_core *hil_core_new(int, int *)
    void hil_core_free(hil_core *)
    int hil_group_open(hil_core *, int64_t)
    void hil_group_close(hil_core *, int)
    int hil_axis_open(hil_core *, int, const hil_axis_params *)
    void hil_axis_power_up(hil_core *, int)
    int64_t hil_group_advance(hil_core *, int, int64_t)
    int64_t hil_group_now(const hil_core *, int)
    void hil_group_set_horizon(hil_core *, int, int64_t)
    int hil_group_failed(const hil_core *, int)
    int hil_group_has_news(const hil_core *, int)
    int hil_group_take_event(hil_core *, int, hil_event *)
    void hil_group_acquire(hil_core *, int)
    void hil_group_release(hil_core *, int)
    double hil_axis_get(hil_core *, int, hil_field)
    int hil_axis_set(hil_core *, int, hil_field, double)
    void hil_axis_output(hil_core *, int, float, int)
    void hil_axis_vref(hil_core *, int, int, int)
    void hil_axis_loop(hil_core *, int, int)
    int hil_axis_spi(hil_core *, int, int)
    float *hil_axis_table(hil_core *, int)
    void hil_axis_pin(hil_core *, int, int, int)
    int hil_axis_fault(hil_core *, int, int, double)
    double hil_axis_supply_V(const hil_core *, int)
    int hil_axis_script_encoder(hil_core *, int, int, const int64_t *, const int64_t *, int)
    int hil_axis_drive(hil_core *, int, int, const hil_edges *)
    ctypedef struct hil_path_piece:
        int64_t duration_ns
        double r
        double per_s
        double per_s2
        double per_s3
    int hil_axis_follow(hil_core *, int, int64_t, int, const hil_path_piece *)
    int HIL_WATCHES
    int hil_axis_watch(hil_core *, int, int, int64_t, int64_t, int)
    int hil_axis_take_samples(hil_core *, int, int, hil_snapshot *, int)
    int64_t hil_axis_lost_samples(const hil_core *, int, int)
    void hil_axis_snapshot(hil_core *, int, hil_snapshot *)
    void hil_axis_published(const hil_core *, int, hil_snapshot *)
    int hil_rt_start(hil_core *, const hil_rt_options *)
    void hil_rt_stop(hil_core *)
    int64_t hil_rt_now(const hil_core *)
    void hil_rt_stats_read(const hil_core *, hil_rt_stats *)
    int hil_rt_take_due(hil_core *, int *, int)
    ctypedef struct hil_watchdog
    hil_watchdog *hil_watchdog_new(int, void (*)(int) noexcept nogil, const char *)
    void hil_watchdog_arm(hil_watchdog *, int64_t, int64_t)
    void hil_watchdog_enter(hil_watchdog *, const char *)
    int hil_watchdog_leave(hil_watchdog *)
    void hil_watchdog_aside(hil_watchdog *)
    void hil_watchdog_resume(hil_watchdog *, const char *)
    int64_t hil_watchdog_bells(const hil_watchdog *)
    int hil_watchdog_bells_in_work(const hil_watchdog *, int)
    void hil_watchdog_close(hil_watchdog *w)
    void hil_watchdog_free(hil_watchdog *)
    ctypedef struct hil_replay_row:
        float y_meas, y_excite, yw, e, ITerm, DTerm, v, u
        int32_t U, wrap_count
        int16_t vref1, vref2
        int8_t in1, in2, in3, in4, led
    ctypedef struct hil_replay
    hil_replay *hil_replay_new(const float *)
    int hil_replay_set(hil_replay *, hil_field, double)
    void hil_replay_step(hil_replay *, int, hil_replay_row *)
    void hil_replay_output(hil_replay *, float, int, hil_replay_row *)
    void hil_replay_free(hil_replay *)
