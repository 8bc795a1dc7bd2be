# cython: language_level=3, embedsignature=False, freethreading_compatible=False
"""The planner's binding: numbers in, numbers out; course.h, spline.h and trajectory.h of native/motion say what each
call means.
`hil.core.trajectory` is the face for the rest of the project."""

from array import array

from cpython cimport array as c_array
from libc.stdint cimport INT64_MIN, int64_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy

cdef extern from "native/motion/course.h" nogil:
    enum:
        TRAJ_AXES
        TRAJ_SEGMENTS
        TRAJ_OK
        TRAJ_NO_AXES
        TRAJ_TOO_MANY_AXES
        TRAJ_TOO_FEW_POINTS
    ctypedef int traj_error
    ctypedef int traj_kind
    ctypedef struct traj_limits:
        double velocity
        double acceleration
        double jerk
    ctypedef struct traj_state:
        double position
        double velocity
        double acceleration
    ctypedef struct traj_segment:
        double t
        double length
        double p
        double v
        double a
        double j
    ctypedef struct traj_profile:
        traj_segment *segments
        int room
        int count
        double start_position "from"  # a keyword here
        int64_t duration_ns
    ctypedef struct traj_fault:
        int axis
        int64_t least_ns
    ctypedef struct traj_violation_found:
        int axis
        int quantity
        int64_t at_ns
        double value
        double limit
    traj_state traj_at(const traj_profile *profile, int64_t at_ns)
    int traj_violation(int axes, const traj_profile *profiles, const traj_limits *limits, traj_kind kind,
                       traj_violation_found *found)
    double traj_fit(int axes, const traj_profile *profiles, const traj_limits *limits, traj_kind kind)
    traj_error traj_stretch(traj_profile *profile, double factor)

cdef extern from "native/motion/spline.h" nogil:
    traj_error traj_spline(int points, const int64_t *times_ns, const double *positions, traj_profile *out)

cdef extern from "native/motion/trajectory.h" nogil:
    traj_error traj_joint(int axes, const traj_state *starts, const double *targets, const traj_limits *limits,
                          traj_kind kind, int64_t duration_ns, traj_profile *out, traj_fault *fault)
    traj_error traj_line(int axes, const double *starts, const double *targets, const traj_limits *limits,
                         traj_kind kind, int64_t duration_ns, traj_profile *path, traj_profile *out, traj_fault *fault)
    traj_error traj_velocity(int axes, const traj_state *starts, const double *velocities, const traj_limits *limits,
                             traj_kind kind, traj_profile *out, traj_fault *fault)
    traj_error traj_stop(int axes, const traj_profile *running, const traj_profile *path, int64_t at_ns,
                         const traj_limits *limits, traj_kind kind, traj_profile *out_path, traj_profile *out,
                         traj_fault *fault)
    traj_error traj_check_limits(int axes, const traj_limits *limits, traj_kind kind, traj_fault *fault)

MAX_AXES = TRAJ_AXES
SEGMENTS = TRAJ_SEGMENTS


cdef int read_states(object states, int axes, traj_state *out) except -1:
    cdef int i
    for i in range(axes):
        state = states[i]
        out[i] = traj_state(state.position_deg, state.velocity_deg_per_s, state.acceleration_deg_per_s2)
    return 0


cdef int read_limits(object limits, int axes, traj_limits *out) except -1:
    cdef int i
    for i in range(axes):
        limit = limits[i]
        out[i] = traj_limits(limit.velocity_max, limit.acceleration_max, limit.jerk_max)
    return 0


cdef int read_numbers(object numbers, int axes, double *out) except -1:
    cdef int i
    for i in range(axes):
        out[i] = numbers[i]
    return 0


cdef class Course:
    """Profiles of the axes and, for a line, of its path. The calls that plan answer a traj_error, and are
    made once; nothing else changes a course."""

    cdef traj_profile *profiles  # the path's is the last
    cdef traj_segment *segments
    cdef readonly int axes
    cdef readonly bint is_line
    cdef traj_fault fault

    def __cinit__(self, Py_ssize_t axes, Py_ssize_t room=TRAJ_SEGMENTS):
        cdef int i
        self.fault = traj_fault(-1, 0)
        self.axes = <int>min(axes, TRAJ_AXES + 1)
        if not 1 <= axes <= TRAJ_AXES:
            return
        self.profiles = <traj_profile *>calloc(axes + 1, sizeof(traj_profile))
        self.segments = <traj_segment *>calloc((axes + 1) * room, sizeof(traj_segment))
        if self.profiles == NULL or self.segments == NULL:
            raise MemoryError
        for i in range(self.axes + 1):
            self.profiles[i].segments = self.segments + i * room
            self.profiles[i].room = <int>room

    def __dealloc__(self):
        free(self.profiles)
        free(self.segments)

    cdef traj_error refuse(self):
        return TRAJ_OK if self.profiles != NULL else TRAJ_NO_AXES if self.axes == 0 else TRAJ_TOO_MANY_AXES

    @property
    def fault_axis(self):
        return self.fault.axis

    @property
    def least_ns(self):
        return self.fault.least_ns

    def joint(self, starts, targets, limits, bint is_s_curve, int64_t duration_ns=INT64_MIN):
        cdef traj_state start[TRAJ_AXES]
        cdef traj_limits limit[TRAJ_AXES]
        cdef double target[TRAJ_AXES]
        if self.refuse():
            return self.refuse()
        read_states(starts, self.axes, start)
        read_numbers(targets, self.axes, target)
        read_limits(limits, self.axes, limit)
        return traj_joint(self.axes, start, target, limit, is_s_curve, duration_ns, self.profiles, &self.fault)

    def line(self, starts, targets, limits, bint is_s_curve, int64_t duration_ns=INT64_MIN):
        cdef double start[TRAJ_AXES]
        cdef double target[TRAJ_AXES]
        cdef traj_limits limit[TRAJ_AXES]
        if self.refuse():
            return self.refuse()
        read_numbers(starts, self.axes, start)
        read_numbers(targets, self.axes, target)
        read_limits(limits, self.axes, limit)
        self.is_line = True
        return traj_line(self.axes, start, target, limit, is_s_curve, duration_ns, &self.profiles[self.axes],
                         self.profiles, &self.fault)

    def velocity(self, starts, velocities, limits, bint is_s_curve):
        cdef traj_state start[TRAJ_AXES]
        cdef traj_limits limit[TRAJ_AXES]
        cdef double velocity[TRAJ_AXES]
        if self.refuse():
            return self.refuse()
        read_states(starts, self.axes, start)
        read_numbers(velocities, self.axes, velocity)
        read_limits(limits, self.axes, limit)
        return traj_velocity(self.axes, start, velocity, limit, is_s_curve, self.profiles, &self.fault)

    def stop(self, Course running not None, int64_t at_ns, limits, bint is_s_curve):
        cdef traj_limits limit[TRAJ_AXES]
        read_limits(limits, self.axes, limit)
        self.is_line = running.is_line
        return traj_stop(self.axes, running.profiles, &running.profiles[self.axes] if self.is_line else NULL, at_ns,
                         limit, is_s_curve, &self.profiles[self.axes], self.profiles, &self.fault)

    def spline(self, times_ns, points):
        cdef c_array.array times = array("q", times_ns)
        cdef c_array.array column
        cdef traj_error error = self.refuse()
        cdef int i
        if error == TRAJ_OK and len(times) == 0:
            error = TRAJ_TOO_FEW_POINTS
        for i in range(self.axes if error == TRAJ_OK else 0):
            column = array("d", [point[i] for point in points])
            error = traj_spline(<int>len(times), <const int64_t *>times.data.as_longlongs, column.data.as_doubles,
                                &self.profiles[i])
            if error:
                self.fault.axis = i
                break
        return error

    def stretched(self, double factor):
        """Stretch the course to factor times the time; answers (traj_error, Course)."""
        cdef Course other = Course(self.axes, self.profiles[0].room)
        cdef traj_error error = TRAJ_OK
        cdef traj_profile *to
        cdef traj_segment *segments
        cdef int i, room
        other.is_line = self.is_line
        for i in range(self.axes + 1):
            to = &other.profiles[i]
            memcpy(to.segments, self.profiles[i].segments, self.profiles[i].count * sizeof(traj_segment))
            segments = to.segments
            room = to.room
            to[0] = self.profiles[i]
            to.segments = segments
            to.room = room
            error = error or traj_stretch(to, factor)
        return error, other

    @property
    def duration_ns(self):
        """Duration of the axis that takes longest."""
        cdef int64_t longest = 0
        cdef int i
        for i in range(self.axes):
            longest = max(longest, self.profiles[i].duration_ns)
        return longest

    def at(self, int axis, int64_t at_ns):
        if not 0 <= axis < self.axes:
            raise IndexError(axis)
        cdef traj_state s = traj_at(&self.profiles[axis], at_ns)
        return s.position, s.velocity, s.acceleration

    def positions(self, int64_t from_ns, int64_t step_ns, Py_ssize_t count):
        cdef c_array.array out = c_array.clone(array("d"), count * self.axes, False)
        cdef Py_ssize_t k
        cdef int i
        for k in range(count):
            for i in range(self.axes):
                out.data.as_doubles[k * self.axes + i] = traj_at(&self.profiles[i], from_ns + k * step_ns).position
        return out

    def segments_of(self, int axis):
        """Segments as (seconds from the start, length, position, velocity, acceleration, jerk)."""
        if not 0 <= axis < self.axes:
            raise IndexError(axis)
        cdef traj_profile *p = &self.profiles[axis]
        cdef traj_segment *s = p.segments
        return [(s[i].t, s[i].length, p.start_position + s[i].p, s[i].v, s[i].a, s[i].j) for i in range(p.count)]

    def check(self, limits, bint is_s_curve):
        """Check limits, before the two calls after this one; answers a traj_error."""
        cdef traj_limits limit[TRAJ_AXES]
        read_limits(limits, self.axes, limit)
        return traj_check_limits(self.axes, limit, is_s_curve, &self.fault)

    def violation(self, limits, bint is_s_curve):
        cdef traj_limits limit[TRAJ_AXES]
        cdef traj_violation_found found
        read_limits(limits, self.axes, limit)
        if not traj_violation(self.axes, self.profiles, limit, is_s_curve, &found):
            return None
        return found.axis, found.quantity, found.at_ns, found.value, found.limit

    def fit(self, limits, bint is_s_curve):
        cdef traj_limits limit[TRAJ_AXES]
        read_limits(limits, self.axes, limit)
        return traj_fit(self.axes, self.profiles, limit, is_s_curve)
