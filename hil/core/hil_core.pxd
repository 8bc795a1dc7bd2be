# cython: language_level=3
# Written by `make abi` from native/abi.def and the C headers: change those.
from libc.stdint cimport int8_t, int16_t, int32_t, int64_t, uint8_t, uint16_t, uint32_t, uint64_t

cdef extern from "native/hil_core.h" nogil:
    enum:
        HIL_TABLE_LEN
        HIL_HISTOGRAM_LEN
        HIL_WATCHES
        HIL_WIRES
        HIL_SWITCHES
        HIL_CONTACT_OPEN
        HIL_CONTACT_CLOSED
        HIL_LIMIT_TEETH_RPM
        HIL_LIMIT_RPM
        MOTION_QUEUE
        MOTION_SLOTS
        MOTION_CONTINUOUS_SLOT
        MOTION_ONE_SHOT_SLOT
        HIL_FIELDS
    ctypedef int hil_field
    ctypedef int hil_law
    ctypedef int hil_lanes
    ctypedef struct hil_core:
        pass
    ctypedef struct hil_snapshot:
        pass
    ctypedef struct hil_watchdog:
        pass
    ctypedef struct hil_replay:
        pass
    ctypedef struct hil_joint_replay:
        pass
    ctypedef struct hil_field_info:
        const char *name
        const char *type
        const char *unit
        const char *meaning
        size_t offset
        int writable
        int kind
    ctypedef struct hil_event:
        int64_t at_ns
        int32_t axis
        int32_t kind
        double value
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
        double stop_Nm_per_rad
        int32_t end_stops
    ctypedef struct hil_edges:
        int64_t at_ns
        int64_t steps
        int64_t duration_ns
        int32_t pin
        int32_t level
    ctypedef struct hil_pulses:
        int64_t pulses
        int64_t period_ns
        int64_t high_ns
    ctypedef struct hil_axis_params:
        int32_t law
        int32_t driver
        double phase_current_A
        double ambient_degC
        double fast_decay_pct
        double inertia_kg_m2
        double viscous_Nm_s_per_rad
        double torque_constant_Nm_per_A
        double sense_resistor_ohm
        double start_deg
        double load_torque_Nm
        int32_t rotor_teeth
        int32_t driver_microsteps
        int32_t counts_backwards
        double gear_ratio
        double encoder_null_deg
        double encoder_offset_deg
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
    ctypedef struct hil_path_piece:
        int64_t duration_ns
        double r
        double per_s
        double per_s2
        double per_s3
    ctypedef struct hil_switch:
        double from_deg
        double to_deg
        double hysteresis_deg
        double every_deg
        int32_t opens
        int32_t closed_level
        int32_t to_axis
        int32_t to_pin
        int64_t bounce_ns
        uint64_t seed
    ctypedef struct hil_edge:
        int64_t at_ns
        int32_t pin
        int32_t level
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
    ctypedef struct hil_replay_row:
        float y_meas
        float y_excite
        float yw
        float e
        float ITerm
        float DTerm
        float v
        float u
        int32_t U
        int32_t wrap_count
        int16_t vref1
        int16_t vref2
        int8_t in1
        int8_t in2
        int8_t in3
        int8_t in4
        int8_t led
    ctypedef struct hil_joint_row:
        float measured_deg
        float to_be_deg
        float integral
        float speed
        float acceleration
        float c0
        float cn
        float cmin
        int32_t position
        int32_t target
        int32_t n
        int32_t interval_us
        int32_t dir
    const hil_field_info hil_field_table[]
    hil_core *hil_core_new(int max_axes, int *event_fd)
    int hil_core_set_lanes(hil_core *c, hil_lanes lanes)
    hil_lanes hil_core_lanes(const hil_core *c)
    void hil_core_free(hil_core *c)
    int hil_group_open(hil_core *c, int64_t now_ns)
    void hil_group_close(hil_core *c, int group)
    int hil_axis_open(hil_core *c, int group, const hil_axis_params *params)
    int64_t hil_axis_bytes(hil_law law)
    void hil_axis_power_up(hil_core *c, int axis)
    int64_t hil_group_advance(hil_core *c, int group, int64_t until_ns)
    void hil_groups_advance(hil_core *c, const int *groups, int n, int64_t until_ns)
    int hil_group_is_quiet(const hil_core *c, int group)
    int64_t hil_group_now(const hil_core *c, int group)
    void hil_group_set_horizon(hil_core *c, int group, int64_t horizon_ns)
    int hil_group_failed(const hil_core *c, int group)
    int hil_group_has_news(const hil_core *c, int group)
    int hil_group_take_event(hil_core *c, int group, hil_event *out)
    void hil_group_acquire(hil_core *c, int group)
    void hil_group_release(hil_core *c, int group)
    double hil_axis_get(hil_core *c, int axis, hil_field field)
    int hil_axis_set(hil_core *c, int axis, hil_field field, double value)
    int hil_axis_cells(hil_core *c, int axis, int n, const int32_t *fields)
    void hil_axis_output(hil_core *c, int axis, float theta_deg, int effort)
    void hil_axis_vref(hil_core *c, int axis, int vref1, int vref2)
    void hil_axis_loop(hil_core *c, int axis, int on)
    int hil_axis_spi(hil_core *c, int axis, int command)
    float *hil_axis_table(hil_core *c, int axis)
    void hil_axis_pin(hil_core *c, int axis, int pin, int level)
    int hil_axis_fault(hil_core *c, int axis, int what, double value)
    double hil_axis_do(hil_core *c, int axis, int call, double x, double y, double z)
    double hil_axis_supply_V(const hil_core *c, int axis)
    int hil_axis_script_encoder(hil_core *c, int axis, int n, const int64_t *at_ns, const int64_t *raw, int linear)
    int hil_axis_drive(hil_core *c, int axis, int n, const hil_edges *rows)
    int hil_axis_follow(hil_core *c, int axis, int64_t start_ns, int n, const hil_path_piece *pieces)
    void hil_motion_setup(hil_core *c, int axis, const motion_setup *setup)
    void hil_motion_write(hil_core *c, int axis, int slot, const motion_entry *entry)
    void hil_motion_read(hil_core *c, int axis, int slot, motion_entry *out)
    void hil_motion_xref_write(hil_core *c, int axis, int index, int slot)
    int hil_motion_xref(hil_core *c, int axis, int index)
    void hil_axis_record_edges(hil_core *c, int axis, int outputs)
    int hil_axis_take_edges(hil_core *c, int axis, hil_edge *out, int max)
    int hil_axis_output_levels(hil_core *c, int axis)
    void hil_axis_record_inputs(hil_core *c, int axis, int inputs)
    int hil_axis_take_inputs(hil_core *c, int axis, hil_edge *out, int max)
    int hil_wire(hil_core *c, int from_axis, int from_pin, int to_axis, int to_pin)
    int hil_magnet(hil_core *c, int axis, int of_axis, int is_reversed, double zero_deg)
    int hil_switch_add(hil_core *c, int axis, const hil_switch *given)
    int hil_switch_fault(hil_core *c, int axis, int which, int held, double shift_deg)
    int hil_switch_is_active(const hil_core *c, int axis, int which)
    void hil_bank_write(hil_core *c, int axis, int pin, int level)
    int hil_bank_read(const hil_core *c, int axis, int pin)
    int hil_bank_pulses(hil_core *c, int axis, int pin, int n, const hil_pulses *rows)
    void hil_processor_load(hil_core *c, int axis, int at, int n, const uint8_t *data)
    void hil_processor_load_eeprom(hil_core *c, int axis, int at, int n, const uint8_t *data)
    void hil_processor_set_fuses(hil_core *c, int axis, const uint8_t fuses[4], int has_boot)
    void hil_processor_reset(hil_core *c, int axis, int causes, int64_t start_up_cycles)
    void hil_processor_hold(hil_core *c, int axis)
    void hil_processor_clock(hil_core *c, int axis, int64_t hz)
    void hil_processor_supply(hil_core *c, int axis, double vcc_V, double aref_V)
    int64_t hil_processor_start_up(hil_core *c, int axis)
    void hil_processor_read(hil_core *c, int axis, int memory, int at, int n, uint8_t *out)
    int64_t hil_processor_cycles(hil_core *c, int axis)
    int64_t hil_processor_baud(hil_core *c, int axis)
    int hil_processor_framing(hil_core *c, int axis)
    int hil_processor_pc(hil_core *c, int axis)
    int hil_processor_pin(hil_core *c, int axis, int pin, double *duty)
    void hil_processor_poke(hil_core *c, int axis, int address, int value)
    int hil_processor_hear(hil_core *c, int axis, int64_t start_ns, double bit_ns, int bits, int length, int is_broken)
    void hil_processor_retract(hil_core *c, int axis, int64_t after_ns)
    void hil_processor_measure(hil_core *c, int axis, int channel, int of_axis, hil_field field, double gain, double volts)
    void hil_processor_volts(hil_core *c, int axis, int channel, double volts)
    int hil_processor_smooth(hil_core *c, int axis, int channel, int of_axis, int pin, double rc_s, double gain, double volts)
    void hil_processor_drives_line(hil_core *c, int axis, int pin)
    void hil_processor_break(hil_core *c, int axis, int byte, int is_on)
    void hil_processor_halt(hil_core *c, int axis)
    void hil_processor_go(hil_core *c, int axis, int is_step)
    int hil_processor_is_halted(hil_core *c, int axis)
    void hil_processor_jump(hil_core *c, int axis, int byte)
    void hil_processor_stack_floor(hil_core *c, int axis, int address)
    int hil_processor_stack_lowest(hil_core *c, int axis)
    void hil_processor_count(hil_core *c, int axis, int n, const uint16_t *starts, int lap_at)
    int hil_processor_counted(hil_core *c, int axis, int n, uint64_t *spent, uint32_t *calls)
    int64_t hil_processor_counted_clocks(hil_core *c, int axis)
    int hil_processor_laps(hil_core *c, int axis, int n, uint32_t *laps)
    int hil_axis_watch(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int capacity)
    int hil_axis_watch_extremes(hil_core *c, int axis, int slot, int64_t num_ns, int64_t den, int points, int capacity)
    int hil_axis_take_samples(hil_core *c, int axis, int slot, hil_snapshot *out, int max)
    int64_t hil_axis_lost_samples(const hil_core *c, int axis, int slot)
    void hil_axis_snapshot(hil_core *c, int axis, hil_snapshot *out)
    void hil_axis_published(const hil_core *c, int axis, hil_snapshot *out)
    int hil_rt_start(hil_core *c, const hil_rt_options *options)
    void hil_rt_stop(hil_core *c)
    int64_t hil_rt_now(const hil_core *c)
    void hil_rt_stats_read(const hil_core *c, hil_rt_stats *out)
    int hil_rt_take_due(hil_core *c, int *groups, int max)
    hil_watchdog *hil_watchdog_new(int signal_number, void (*interrupt)(int) noexcept nogil, const char *file)
    void hil_watchdog_arm(hil_watchdog *w, int64_t cpu_ns, int64_t wall_ns)
    void hil_watchdog_enter(hil_watchdog *w, const char *work)
    int hil_watchdog_leave(hil_watchdog *w)
    void hil_watchdog_aside(hil_watchdog *w)
    void hil_watchdog_resume(hil_watchdog *w, const char *work)
    int64_t hil_watchdog_bells(const hil_watchdog *w)
    int hil_watchdog_bells_in_work(const hil_watchdog *w, int wall)
    void hil_watchdog_close(hil_watchdog *w)
    void hil_watchdog_free(hil_watchdog *w)
    hil_replay *hil_replay_new(const float *table)
    int hil_replay_set(hil_replay *p, hil_field field, double value)
    void hil_replay_step(hil_replay *p, int raw, hil_replay_row *row)
    void hil_replay_output(hil_replay *p, float theta_deg, int effort, hil_replay_row *row)
    void hil_replay_free(hil_replay *p)
    hil_joint_replay *hil_joint_replay_new(const hil_axis_params *params, double min_deg, double max_deg, double kP, double speed_rpm, double acceleration_rpm_per_s, int64_t origin_us, int64_t poll_us)
    void hil_joint_replay_set(hil_joint_replay *p, int what, double value)
    void hil_joint_replay_set_up(hil_joint_replay *p)
    void hil_joint_replay_move(hil_joint_replay *p, double to_deg, uint32_t now_ms, uint32_t duration_ms)
    void hil_joint_replay_sample(hil_joint_replay *p, double measured_deg, uint32_t now_ms)
    int64_t hil_joint_replay_step(hil_joint_replay *p, int64_t from_us, int64_t until_us, int *dir)
    double hil_joint_replay_deg(const hil_joint_replay *p)
    void hil_joint_replay_place(hil_joint_replay *p, double deg)
    void hil_joint_replay_read(const hil_joint_replay *p, hil_joint_row *row)
    void hil_joint_replay_free(hil_joint_replay *p)

cdef inline int fill_hil_axis_params(hil_axis_params *p, dict given) except -1:
    p.driver = int(given.get("driver", 0))
    p.phase_current_A = given.get("phase_current_A", 0)
    p.ambient_degC = given.get("ambient_degC", 0)
    p.fast_decay_pct = given.get("fast_decay_pct", 0)
    p.inertia_kg_m2 = given.get("inertia_kg_m2", 0)
    p.viscous_Nm_s_per_rad = given.get("viscous_Nm_s_per_rad", 0)
    p.torque_constant_Nm_per_A = given.get("torque_constant_Nm_per_A", 0)
    p.sense_resistor_ohm = given.get("sense_resistor_ohm", 0)
    p.start_deg = given.get("start_deg", 0)
    p.load_torque_Nm = given.get("load_torque_Nm", 0)
    p.rotor_teeth = int(given.get("rotor_teeth", 0))
    p.driver_microsteps = int(given.get("driver_microsteps", 0))
    p.counts_backwards = int(given.get("counts_backwards", 0))
    p.gear_ratio = given.get("gear_ratio", 0)
    p.encoder_null_deg = given.get("encoder_null_deg", 0)
    p.encoder_offset_deg = given.get("encoder_offset_deg", 0)
    return 0
