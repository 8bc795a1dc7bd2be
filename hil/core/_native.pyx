# cython: language_level=3, boundscheck=False, freethreading_compatible=False
"""The binding of the native core. Thin: ids and numbers in, numbers out; see native/hil_core.h for
what each call means and who may make it. `hil.core` is the face for the rest of the project."""

from libc.stdint cimport int8_t, int16_t, int32_t, int64_t, uint8_t, uint16_t, uint32_t, uint64_t
from cpython.bytes cimport PyBytes_FromStringAndSize
from cpython.ref cimport Py_INCREF
from cpython.tuple cimport PyTuple_New, PyTuple_SET_ITEM
from libc.stdlib cimport free, malloc
from libc.string cimport memcpy, memset

from hil.core.hil_core cimport *

FIELDS = tuple(
    (hil_field_table[i].name.decode(), hil_field_table[i].type.decode(), hil_field_table[i].unit.decode(),
     bool(hil_field_table[i].writable), hil_field_table[i].meaning.decode(), hil_field_table[i].kind)
    for i in range(HIL_FIELDS)
)


def axis_bytes(int law):
    return hil_axis_bytes(law)


cdef tuple unpack(const hil_snapshot *s):
    cdef list values = []
    cdef int i
    for i in range(HIL_FIELDS):
        values.append(unpack_one(s, i))
    return tuple(values)


cdef object unpack_one(const hil_snapshot *s, int field):
    cdef const char *at = <const char *>s + hil_field_table[field].offset
    if hil_field_table[field].type[0] == b"f":
        return (<const double *>at)[0] if hil_field_table[field].type[1] == b"6" else (<const float *>at)[0]
    return (<const int64_t *>at)[0] if hil_field_table[field].type[1] == b"6" else (<const int32_t *>at)[0]


cdef class PackedValues:
    """Values of all fields, each unpacked when it is asked for: who wants some does not pay for all."""
    cdef hil_snapshot s

    def __len__(self):
        return HIL_FIELDS

    def __getitem__(self, int field):
        if not 0 <= field < HIL_FIELDS:
            raise IndexError(field)
        return unpack_one(&self.s, field)

    def __bytes__(self):
        return (<const char *>&self.s)[:sizeof(hil_snapshot)]

    def unpacked(self):
        """All values, at once."""
        return unpack(&self.s)


cdef class NativeCore:
    cdef hil_core *core
    cdef readonly int event_fd
    cdef readonly int max_axes

    def __cinit__(self, int max_axes):
        if max_axes < 1:
            raise ValueError("max_axes must be at least 1")
        self.core = hil_core_new(max_axes, &self.event_fd)
        if self.core is NULL:
            raise MemoryError(f"no memory for a core of {max_axes} axes")
        self.max_axes = max_axes

    def __dealloc__(self):
        if self.core is not NULL:
            hil_core_free(self.core)

    def group_open(self, int64_t now_ns):
        cdef int group = hil_group_open(self.core, now_ns)
        if group < 0:
            raise MemoryError(f"all {self.max_axes} groups of the core are taken")
        return group

    @property
    def lanes(self):
        return hil_core_lanes(self.core)

    def set_lanes(self, int lanes):
        if hil_core_set_lanes(self.core, lanes):
            raise ValueError(f"this processor has no lanes of kind {lanes}")

    def group_close(self, int group):
        hil_group_close(self.core, group)

    def axis_open(self, int group, int law, dict motor, dict full, dict load, uint64_t seed):
        cdef hil_axis_params p
        memset(&p, 0, sizeof(p))
        fill_hil_axis_params(&p, motor)
        p.law = law
        if full is not None:
            p.is_full = 1
            p.full = full  # by name: every member has to be there
            p.load = load
            p.seed = seed
        cdef int axis = hil_axis_open(self.core, group, &p)
        if axis == -2:
            raise ValueError("the motor is too stiff to be integrated: more inertia or less friction is needed")
        if axis < 0:
            raise MemoryError(f"all {self.max_axes} axes of the core are taken")
        return axis

    def power_up(self, int axis):
        hil_axis_power_up(self.core, axis)

    def advance(self, int group, int64_t horizon_ns, int64_t until_ns):
        """Set the horizon, and advance. Answers the time, and whether there are events or a failure to look
        at."""
        cdef int64_t now_ns
        hil_group_set_horizon(self.core, group, horizon_ns)
        with nogil:
            hil_groups_advance(self.core, &group, 1, until_ns)
        now_ns = hil_group_now(self.core, group)
        return now_ns, hil_group_has_news(self.core, group) != 0

    def advance_groups(self, list groups, horizons, int64_t until_ns):
        """As ``advance`` for several groups at once. Answers the places in ``groups`` of those that have come to
        their horizon, have something to look at, or have further to go."""
        cdef int n = <int>len(groups), i
        cdef int64_t now_ns
        cdef int *ids = <int *>malloc(max(n, 1) * sizeof(int))
        if ids is NULL:
            raise MemoryError("no memory for the groups")
        try:
            for i in range(n):
                ids[i] = groups[i]
                hil_group_set_horizon(self.core, ids[i], horizons[i])
            with nogil:
                hil_groups_advance(self.core, ids, n, until_ns)
            found = []
            for i in range(n):
                now_ns = hil_group_now(self.core, ids[i])
                if now_ns < until_ns or now_ns >= <int64_t>horizons[i] or hil_group_has_news(self.core, ids[i]):
                    found.append(i)
            return found
        finally:
            free(ids)

    def has_news(self, int group):
        return hil_group_has_news(self.core, group) != 0

    def is_quiet(self, int group):
        return hil_group_is_quiet(self.core, group) != 0

    def now(self, int group):
        return hil_group_now(self.core, group)

    def failed(self, int group):
        return hil_group_failed(self.core, group) != 0

    def take_events(self, int group):
        cdef hil_event e
        events = []
        while hil_group_take_event(self.core, group, &e):
            events.append((e.at_ns, e.axis, e.kind, e.value))
        return events

    def acquire(self, int group):
        hil_group_acquire(self.core, group)

    def release(self, int group):
        hil_group_release(self.core, group)

    def get(self, int axis, int field):
        return hil_axis_get(self.core, axis, field)

    def set(self, int axis, int field, double value):
        if hil_axis_set(self.core, axis, field, value):
            raise AttributeError(f"axis field {FIELDS[field][0]} is read-only")

    def cells(self, int axis, list fields):
        cdef int32_t[HIL_FIELDS] numbers
        cdef int n = 0
        for field in fields[:HIL_FIELDS]:
            numbers[n] = field
            n += 1
        if hil_axis_cells(self.core, axis, n, numbers):
            raise MemoryError("no memory for the cells")

    def output(self, int axis, float theta_deg, int effort):
        hil_axis_output(self.core, axis, theta_deg, effort)

    def vref(self, int axis, int vref1, int vref2):
        hil_axis_vref(self.core, axis, vref1, vref2)

    def loop(self, int axis, bint on):
        hil_axis_loop(self.core, axis, on)

    def spi(self, int axis, int command):
        return hil_axis_spi(self.core, axis, command)

    def table(self, int axis):
        cdef const float *table = hil_axis_table(self.core, axis)
        if table is NULL:
            raise ValueError("this axis has no table")
        return (<const char *>table)[:HIL_TABLE_LEN * 4]

    def write_table(self, int axis, const unsigned char[::1] packed):
        if packed.shape[0] != HIL_TABLE_LEN * 4:
            raise ValueError(f"a table is {HIL_TABLE_LEN * 4} bytes, not {packed.shape[0]}")
        cdef float *table = hil_axis_table(self.core, axis)
        if table is NULL:
            raise ValueError("this axis has no table")
        memcpy(table, &packed[0], HIL_TABLE_LEN * 4)

    def pin(self, int axis, int pin, int level):
        hil_axis_pin(self.core, axis, pin, level)

    def script_encoder(self, int axis, const int64_t[::1] at_ns, const int64_t[::1] raw, bint linear):
        cdef int n = <int>at_ns.shape[0]
        if raw.shape[0] != n:
            raise ValueError("as many times as counts")
        cdef int failed = (hil_axis_script_encoder(self.core, axis, n, &at_ns[0], &raw[0], linear) if n
                           else hil_axis_script_encoder(self.core, axis, 0, NULL, NULL, 0))
        if failed:
            raise MemoryError("no memory for the encoder's script")

    def fault(self, int axis, int what, double value):
        if hil_axis_fault(self.core, axis, what, value):
            raise ValueError("this axis cannot have that")

    def supply_V(self, int axis):
        return hil_axis_supply_V(self.core, axis)

    def motion_setup(self, int axis, dict setup):
        cdef motion_setup s = setup  # by name: every member has to be there
        hil_motion_setup(self.core, axis, &s)

    def motion_write(self, int axis, int slot, dict entry):
        cdef motion_entry e = entry
        if not 0 <= slot < MOTION_SLOTS:
            raise IndexError(f"slot {slot}: there are 0 to {MOTION_SLOTS - 1}")
        hil_motion_write(self.core, axis, slot, &e)

    def motion_read(self, int axis, int slot):
        cdef motion_entry e
        if not 0 <= slot < MOTION_SLOTS:
            raise IndexError(f"slot {slot}: there are 0 to {MOTION_SLOTS - 1}")
        hil_motion_read(self.core, axis, slot, &e)
        return e

    def motion_xref_write(self, int axis, int index, int slot):
        if not 0 <= index <= MOTION_QUEUE:
            raise IndexError(f"index {index}: there are 0 to {MOTION_QUEUE}")
        hil_motion_xref_write(self.core, axis, index, slot)

    def motion_xref(self, int axis):
        return tuple(hil_motion_xref(self.core, axis, i) for i in range(MOTION_QUEUE + 1))

    def do(self, int axis, int call, double x, double y, double z):
        return hil_axis_do(self.core, axis, call, x, y, z)

    def record_edges(self, int axis, int outputs):
        hil_axis_record_edges(self.core, axis, outputs)

    def take_edges(self, int axis):
        return self._edges(axis, hil_axis_take_edges)

    def output_levels(self, int axis):
        return hil_axis_output_levels(self.core, axis)

    def record_inputs(self, int axis, int inputs):
        hil_axis_record_inputs(self.core, axis, inputs)

    def take_inputs(self, int axis):
        return self._edges(axis, hil_axis_take_inputs)

    cdef list _edges(self, int axis, int (*take)(hil_core *, int, hil_edge *, int) except *):
        cdef hil_edge edges[256]
        cdef int n, i
        taken = []
        while True:
            n = take(self.core, axis, edges, 256)
            for i in range(n):
                taken.append((edges[i].at_ns, edges[i].pin, edges[i].level))
            if n < 256:
                return taken

    def wire(self, int from_axis, int from_pin, int to_axis, int to_pin):
        if hil_wire(self.core, from_axis, from_pin, to_axis, to_pin):
            raise MemoryError("no more wires at this axis")

    def magnet(self, int axis, int of_axis, bint is_reversed, double zero_deg):
        if hil_magnet(self.core, axis, of_axis, is_reversed, zero_deg):
            raise ValueError("this axis reads no magnet")

    def switch_add(self, int axis, dict given):
        cdef hil_switch s = given  # by name: every member has to be there
        cdef int number = hil_switch_add(self.core, axis, &s)
        if number < 0:
            raise MemoryError(f"an axis has at most {HIL_SWITCHES} switches")
        return number

    def switch_fault(self, int axis, int which, int held, double shift_deg):
        if hil_switch_fault(self.core, axis, which, held, shift_deg):
            raise ValueError("the axis has no such switch, or it cannot be so")

    def switch_is_active(self, int axis, int which):
        return hil_switch_is_active(self.core, axis, which)

    def bank_write(self, int axis, int pin, int level):
        hil_bank_write(self.core, axis, pin, level)

    def bank_read(self, int axis, int pin):
        return hil_bank_read(self.core, axis, pin)

    def bank_pulses(self, int axis, int pin, list rows):
        cdef hil_pulses *pulses = <hil_pulses *>malloc(max(len(rows), 1) * sizeof(hil_pulses))
        cdef int i, failed
        if pulses is NULL:
            raise MemoryError("no memory for the pulses")
        try:
            for i in range(len(rows)):
                count, period_ns, high_ns = rows[i]
                if not (count >= 0 and 0 < high_ns < period_ns):
                    raise ValueError(f"{count} pulses of {high_ns} in {period_ns} ns")
                pulses[i] = hil_pulses(count, period_ns, high_ns)
            failed = hil_bank_pulses(self.core, axis, pin, <int>len(rows), pulses)
        finally:
            free(pulses)
        if failed:
            raise MemoryError("no memory for the pulses")

    def processor_load(self, int axis, int at, bytes data):
        hil_processor_load(self.core, axis, at, <int>len(data), <const uint8_t *><const char *>data)

    def processor_load_eeprom(self, int axis, int at, bytes data):
        hil_processor_load_eeprom(self.core, axis, at, <int>len(data), <const uint8_t *><const char *>data)

    def processor_set_fuses(self, int axis, int low, int high, int extended, int lock, bint has_boot):
        cdef uint8_t[4] fuses = [low, high, extended, lock]
        hil_processor_set_fuses(self.core, axis, fuses, has_boot)

    def processor_reset(self, int axis, int causes, int64_t start_up_cycles):
        hil_processor_reset(self.core, axis, causes, start_up_cycles)

    def processor_hold(self, int axis):
        hil_processor_hold(self.core, axis)

    def processor_clock(self, int axis, int64_t hz):
        hil_processor_clock(self.core, axis, hz)

    def processor_supply(self, int axis, double vcc_V, double aref_V):
        hil_processor_supply(self.core, axis, vcc_V, aref_V)

    def processor_start_up(self, int axis):
        return hil_processor_start_up(self.core, axis)

    def processor_read(self, int axis, int memory, int at, int n):
        out = PyBytes_FromStringAndSize(NULL, n)
        hil_processor_read(self.core, axis, memory, at, n, <uint8_t *><char *>out)
        return out

    def processor_poke(self, int axis, int address, int value):
        hil_processor_poke(self.core, axis, address, value)

    def processor_cycles(self, int axis):
        return hil_processor_cycles(self.core, axis)

    def processor_baud(self, int axis):
        return hil_processor_baud(self.core, axis)

    def processor_framing(self, int axis):
        return hil_processor_framing(self.core, axis)

    def processor_pc(self, int axis):
        return hil_processor_pc(self.core, axis)

    def processor_pin(self, int axis, int pin):
        cdef double duty
        cdef int seen = hil_processor_pin(self.core, axis, pin, &duty)
        return seen & 3, seen >> 2, duty

    def processor_hear(self, int axis, int64_t start_ns, double bit_ns, int bits, int length, bint is_broken):
        return hil_processor_hear(self.core, axis, start_ns, bit_ns, bits, length, is_broken) == 0

    def processor_retract(self, int axis, int64_t after_ns):
        hil_processor_retract(self.core, axis, after_ns)

    def processor_volts(self, int axis, int channel, double volts):
        hil_processor_volts(self.core, axis, channel, volts)

    def processor_measure(self, int axis, int channel, int of_axis, int field, double gain, double volts):
        hil_processor_measure(self.core, axis, channel, of_axis, <hil_field>field, gain, volts)

    def processor_smooth(self, int axis, int channel, int of_axis, int pin, double rc_s, double gain, double volts):
        if hil_processor_smooth(self.core, axis, channel, of_axis, pin, rc_s, gain, volts):
            raise MemoryError("a board has 16 filters at the most")

    def processor_drives_line(self, int axis, int pin):
        hil_processor_drives_line(self.core, axis, pin)

    def processor_break(self, int axis, int byte, bint is_on):
        hil_processor_break(self.core, axis, byte, is_on)

    def processor_halt(self, int axis):
        hil_processor_halt(self.core, axis)

    def processor_go(self, int axis, bint is_step):
        hil_processor_go(self.core, axis, is_step)

    def processor_is_halted(self, int axis):
        return hil_processor_is_halted(self.core, axis) != 0

    def processor_jump(self, int axis, int byte):
        hil_processor_jump(self.core, axis, byte)

    def processor_stack_floor(self, int axis, int address):
        hil_processor_stack_floor(self.core, axis, address)

    def processor_stack_lowest(self, int axis):
        return hil_processor_stack_lowest(self.core, axis)

    def processor_count(self, int axis, list starts, int lap_at):
        cdef uint16_t words[512]
        cdef int n = 0
        for start in starts[:512]:
            words[n] = start
            n += 1
        hil_processor_count(self.core, axis, n, words, lap_at)

    def processor_counted(self, int axis):
        cdef uint64_t spent[512]
        cdef uint32_t calls[512]
        cdef int n = hil_processor_counted(self.core, axis, 512, spent, calls)
        return hil_processor_counted_clocks(self.core, axis), [(spent[i], calls[i]) for i in range(n)]

    def processor_laps(self, int axis):
        cdef uint32_t laps[1024]
        cdef int n = hil_processor_laps(self.core, axis, 1024, laps)
        return [laps[i] for i in range(n)]

    def drive(self, int axis, list rows):
        cdef hil_edges *edges = <hil_edges *>malloc(max(len(rows), 1) * sizeof(hil_edges))
        cdef int i, failed
        if edges is NULL:
            raise MemoryError("no memory for the signal source")
        try:
            for i in range(len(rows)):
                at_ns, pin, level, steps, duration_ns = rows[i]
                edges[i] = hil_edges(at_ns, steps, duration_ns, pin, level)
            failed = hil_axis_drive(self.core, axis, <int>len(rows), edges)
        finally:
            free(edges)
        if failed:
            raise MemoryError("no memory for the signal source")

    def follow(self, int axis, int64_t start_ns, list pieces):
        cdef int i, n = <int>len(pieces), failed
        cdef hil_path_piece *rows = <hil_path_piece *>malloc(max(n, 1) * sizeof(hil_path_piece))
        if rows is NULL:
            raise MemoryError("no memory for the path")
        try:
            for i in range(n):
                duration_ns, r, per_s, per_s2, per_s3 = pieces[i]
                rows[i] = hil_path_piece(duration_ns, r, per_s, per_s2, per_s3)
            failed = hil_axis_follow(self.core, axis, start_ns, n, rows)
        finally:
            free(rows)
        if failed == -3:
            raise ValueError("this axis follows no paths")
        if failed == -2:
            raise ValueError("a path's pieces are finite and shorter than 146 years")
        if failed:
            raise MemoryError("no memory for the path")

    def watch(self, int axis, int slot, int64_t num_ns, int64_t den, int capacity, int points):
        if not 0 <= slot < HIL_WATCHES or capacity < 1 or points < 1:
            raise ValueError(f"slot {slot} of {HIL_WATCHES}, for {capacity} samples of {points}")
        if not (num_ns == 0 or 1 <= den <= num_ns < 1 << 62):
            raise ValueError(f"an interval of {num_ns} / {den} ns")
        if hil_axis_watch_extremes(self.core, axis, slot, num_ns, den, points, capacity):
            raise MemoryError("no memory for the axis's samples")

    def take_samples(self, int axis, int slot):
        if not 0 <= slot < HIL_WATCHES:
            raise ValueError(f"slot {slot} of {HIL_WATCHES}")
        cdef hil_snapshot s
        samples = []
        while hil_axis_take_samples(self.core, axis, slot, &s, 1):
            samples.append(PyBytes_FromStringAndSize(<const char *>&s, sizeof(s)))
        return samples

    def take_rows(self, int axis, int slot, list fields):
        """Some fields of the samples since the last call, by their numbers in the table: a tuple of each."""
        if not 0 <= slot < HIL_WATCHES:
            raise ValueError(f"slot {slot} of {HIL_WATCHES}")
        if not all(0 <= field < HIL_FIELDS for field in fields):
            raise ValueError(f"fields {fields} of {HIL_FIELDS}")
        cdef hil_snapshot samples[16]
        cdef int i, k, n = <int>len(fields), taken, field[HIL_FIELDS]
        cdef tuple row
        cdef list rows = []
        if n > HIL_FIELDS:
            raise ValueError(f"{n} fields of {HIL_FIELDS}")
        for i in range(n):
            field[i] = fields[i]
        while True:
            taken = hil_axis_take_samples(self.core, axis, slot, samples, 16)
            for k in range(taken):
                row = PyTuple_New(n)
                for i in range(n):
                    value = unpack_one(&samples[k], field[i])
                    Py_INCREF(value)
                    PyTuple_SET_ITEM(row, i, value)
                rows.append(row)
            if taken < 16:
                return rows

    def lost_samples(self, int axis, int slot):
        if not 0 <= slot < HIL_WATCHES:
            raise ValueError(f"slot {slot} of {HIL_WATCHES}")
        return hil_axis_lost_samples(self.core, axis, slot)

    def snapshot(self, int axis):
        cdef hil_snapshot s
        hil_axis_snapshot(self.core, axis, &s)
        return unpack(&s)

    def packed_values(self, int axis):
        cdef PackedValues values = PackedValues.__new__(PackedValues)
        hil_axis_snapshot(self.core, axis, &values.s)
        return values

    def published(self, int axis):
        cdef hil_snapshot s
        hil_axis_published(self.core, axis, &s)
        return unpack(&s)

    def rt_start(self, int64_t period_ns, double speed, int priority, int cpu):
        cdef hil_rt_options o = hil_rt_options(period_ns, speed, priority, cpu)
        cdef int error
        with nogil:
            error = hil_rt_start(self.core, &o)
        if error:
            raise OSError(error, "the real-time thread could not be started")

    def rt_stop(self):
        with nogil:
            hil_rt_stop(self.core)

    def rt_now(self):
        return hil_rt_now(self.core)

    def rt_stats(self):
        cdef hil_rt_stats s
        hil_rt_stats_read(self.core, &s)
        return s

    def take_due(self):
        cdef int groups[64]
        cdef int n, i
        due = []
        while True:
            n = hil_rt_take_due(self.core, groups, 64)
            for i in range(n):
                due.append(groups[i])
            if n < 64:
                return due


cdef extern from "Python.h":
    int PyErr_SetInterruptEx(int) noexcept nogil


cdef void interrupt(int signal_number) noexcept nogil:
    PyErr_SetInterruptEx(signal_number)


cdef class Watchdog:
    cdef hil_watchdog *watchdog
    cdef bytes work

    def __cinit__(self, int signal_number, bytes file):
        self.watchdog = hil_watchdog_new(signal_number, interrupt, file)
        if self.watchdog is NULL:
            raise OSError("no CPU-time timer for this thread")

    def __dealloc__(self):
        if self.watchdog is not NULL:
            hil_watchdog_free(self.watchdog)

    def arm(self, int64_t cpu_ns, int64_t wall_ns):
        hil_watchdog_arm(self.watchdog, cpu_ns, wall_ns)

    def close(self):
        hil_watchdog_close(self.watchdog)

    def enter(self, bytes work):
        self.work = work
        hil_watchdog_enter(self.watchdog, work)

    def aside(self):
        hil_watchdog_aside(self.watchdog)

    def resume(self):
        hil_watchdog_resume(self.watchdog, self.work)

    def leave(self):
        return hil_watchdog_leave(self.watchdog) != 0

    def bells(self):
        return hil_watchdog_bells(self.watchdog)

    def bells_in_work(self):
        return hil_watchdog_bells_in_work(self.watchdog, 0), hil_watchdog_bells_in_work(self.watchdog, 1)


cdef class Replay:
    """The Mechaduino's law alone; one call a control step."""
    cdef hil_replay *replay

    def __cinit__(self, const unsigned char[::1] table):
        if table.shape[0] != HIL_TABLE_LEN * 4:
            raise ValueError(f"a table is {HIL_TABLE_LEN * 4} bytes, not {table.shape[0]}")
        cdef float aligned[HIL_TABLE_LEN]
        memcpy(aligned, &table[0], sizeof(aligned))
        self.replay = hil_replay_new(aligned)
        if self.replay is NULL:
            raise MemoryError

    def __dealloc__(self):
        if self.replay is not NULL:
            hil_replay_free(self.replay)

    def set(self, int field, double value):
        if hil_replay_set(self.replay, field, value):
            raise AttributeError(f"the law has no writable {FIELDS[field][0]}")

    def step(self, int raw):
        cdef hil_replay_row row
        hil_replay_step(self.replay, raw, &row)
        return row

    def output(self, float theta_deg, int effort):
        cdef hil_replay_row row
        hil_replay_output(self.replay, theta_deg, effort, &row)
        return row


cdef class JointReplay:
    """A joint of Walter's Cortex alone: step generator and drive law."""
    cdef hil_joint_replay *replay

    def __cinit__(self, dict joint, int64_t origin_us, int64_t poll_us):
        cdef hil_axis_params p
        if poll_us < 1:
            raise ValueError("looks for pulses are at least 1 us apart")
        memset(&p, 0, sizeof(p))
        p.gear_ratio = joint["gear"]
        p.driver_microsteps = joint["micro"]
        p.start_deg = joint["start_deg"]
        self.replay = hil_joint_replay_new(&p, joint["min"], joint["max"], joint["kP"], joint["maxSpeed"], joint["maxAcc"], origin_us, poll_us)
        if self.replay is NULL:
            raise MemoryError

    def __dealloc__(self):
        if self.replay is not NULL:
            hil_joint_replay_free(self.replay)

    def set(self, int what, double value):
        hil_joint_replay_set(self.replay, what, value)

    def set_up(self):
        hil_joint_replay_set_up(self.replay)

    def move(self, double to_deg, uint32_t now_ms, uint32_t duration_ms):
        hil_joint_replay_move(self.replay, to_deg, now_ms, duration_ms)

    def sample(self, double measured_deg, uint32_t now_ms):
        hil_joint_replay_sample(self.replay, measured_deg, now_ms)

    def steps(self, int64_t from_us, int64_t until_us):
        cdef int dir
        cdef int64_t at_us = from_us
        steps = []
        while (at_us := hil_joint_replay_step(self.replay, at_us, until_us, &dir)) >= 0:
            steps.append((at_us, dir))
            at_us += 1
        return steps

    @property
    def deg(self):
        return hil_joint_replay_deg(self.replay)

    def place(self, double deg):
        hil_joint_replay_place(self.replay, deg)

    def row(self):
        cdef hil_joint_row row
        hil_joint_replay_read(self.replay, &row)
        return row
