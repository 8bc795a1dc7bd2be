# cython: language_level=3, embedsignature=False
"""Parts of a node's turn that all nodes of a line have at each packet to everybody, in C; ``packet_wakes.py``,
``uart_rx_line.py`` and ``firmware_guard.py`` say what they mean, and do the rest."""

from collections import deque

from hil.sim.flight import end_times, heard
from hil.vocab.time import FOREVER


cdef object last_framing = None, last_flight = None, last_before = None
cdef tuple last_times_ns = ()


cdef tuple ends(framing, flight, before):
    # The same as last time for all receivers on a line but the first: a cache of one, compared by identity.
    global last_framing, last_flight, last_before, last_times_ns
    if flight is not last_flight or framing is not last_framing or before != last_before:
        last_times_ns = end_times(framing, flight, before)
        last_framing, last_flight, last_before = framing, flight, before
    return last_times_ns


cdef object last_start = None, last_data = None, last_baud = None, last_own = None, last_line = None
cdef object last_heard = None


cdef object heard_by_all(start_ns, data, baud, own_baud, framing):
    # As above: one burst comes to each receiver in turn, and mostly makes the same flight.
    global last_start, last_data, last_baud, last_own, last_line, last_heard
    if (
        data is not last_data or framing is not last_line
        or start_ns != last_start or baud != last_baud or own_baud != last_own
    ):
        last_heard = heard(start_ns, data, baud, own_baud, framing)
        last_start, last_data, last_baud, last_own, last_line = start_ns, data, baud, own_baud, framing
    return last_heard


cdef class Wakes:
    cdef public object framing
    cdef public bint is_loose, has_gap
    cdef public bytes before
    cdef readonly object times_ns

    def __cinit__(self):
        self.before = b""
        self.times_ns = deque()

    cpdef add(self, flight):
        cdef object before = None if self.has_gap or self.is_loose else self.before
        self.before = flight.tail
        if self.framing is None:
            return flight.times_ns
        cdef tuple times_ns = ends(self.framing, flight, before)
        self.times_ns.extend(times_ns)
        return times_ns


cdef class RxLine:
    cdef readonly list flights
    cdef readonly Wakes wakes
    cdef public object next_ns
    cdef public object unread
    cdef public bint is_woken
    cdef public Py_ssize_t taken
    cdef object due_changed

    def __init__(self, Wakes wakes not None, due_changed):
        self.flights = []
        self.wakes = wakes
        self.next_ns = FOREVER
        self.unread = b""
        self.due_changed = due_changed

    def __class_getitem__(cls, of):
        return cls

    def add(self, flight):
        self.put(flight)

    def hear(self, start_ns, data, baud, own_baud, framing, packets):
        flight = heard_by_all(start_ns, data, baud, own_baud, framing)
        if flight is not None:
            if packets is not None and baud == own_baud:
                flight.packets = packets
            self.put(flight)

    cdef put(self, flight):
        self.flights.append(flight)
        cdef tuple times_ns = self.wakes.add(flight)
        # It comes behind all others: where a time is known already, that one is earlier.
        if times_ns and self.next_ns == FOREVER:
            self.next_ns = times_ns[0]
            self.due_changed(self.next_ns)

    cdef object whole(self, now_ns, from_ns):
        flight = self.flights[0]
        if len(self.flights) != 1 or self.taken or flight.packets is None:
            return None
        if flight.framing is not self.wakes.framing:
            return None
        cdef tuple times_ns = flight.times_ns
        if times_ns[len(times_ns) - 1] > now_ns or times_ns[0] < from_ns:
            return None
        self.flights.clear()
        self.wakes.times_ns.clear()
        self.next_ns = FOREVER
        return flight


def offered(tuple lines, now_ns, from_ns):
    cdef RxLine line, found = None
    cdef Py_ssize_t number, of_found = 0
    for number in range(len(lines)):
        line = lines[number]
        if line.is_woken or line.wakes.is_loose or line.unread:
            return None
        if line.flights:
            # Of two it is the main program that decides which it reads first.
            if found is not None:
                return None
            found, of_found = line, number
    if found is None:
        return None
    flight = found.whole(now_ns, from_ns)
    return None if flight is None else (of_found, flight)


cdef class Nothing:
    def __enter__(self):
        return None

    def __exit__(self, kind, error, trace):
        return None
