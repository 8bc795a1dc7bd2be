"""Byte faults of a bad line, seeded: the same fate for the same byte, however the bytes are cut."""

import time
import zlib
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from hil.wire.byte_faults import ByteFault, ByteFaults

DATA = bytes(range(256)) * 16
ALL = ByteFault(bit_error_rate=0.01, drop_rate=0.05, duplicate_rate=0.05, delay_rate=0.02, delay_ns=1000)


def through(fault, data, seed=1):
    faults = ByteFaults(fault, seed)
    return b"".join(piece for _, piece in faults.apply(data)), faults.changed_bytes


def test_no_fault_changes_nothing():
    assert through(ByteFault(), DATA) == (DATA, 0)


def test_bits_flip_at_their_rate():
    out, changed = through(ByteFault(bit_error_rate=0.01), DATA)
    bits = sum((a ^ b).bit_count() for a, b in zip(out, DATA, strict=True))
    assert 0.008 < bits / (8 * len(DATA)) < 0.012
    assert changed == sum(a != b for a, b in zip(out, DATA, strict=True))


def test_dropped_and_doubled_bytes_are_counted():
    out, changed = through(ByteFault(drop_rate=0.1), DATA)
    assert len(out) == len(DATA) - changed
    assert 0.08 < changed / len(DATA) < 0.12
    out, changed = through(ByteFault(duplicate_rate=0.1), DATA)
    assert len(out) == len(DATA) + changed
    assert 0.08 < changed / len(DATA) < 0.12


def test_certainty():
    assert through(ByteFault(drop_rate=1.0), DATA) == (b"", len(DATA))
    assert through(ByteFault(bit_error_rate=1.0), b"\0\xff") == (b"\xff\0", 2)


def test_late_bytes_keep_their_order():
    pieces = list(ByteFaults(ByteFault(delay_rate=0.1, delay_ns=500), 3).apply(DATA))
    assert b"".join(piece for _, piece in pieces) == DATA
    late_bytes = sum(len(piece) for delay_ns, piece in pieces if delay_ns)
    assert {delay_ns for delay_ns, _ in pieces} == {0, 500}
    assert 0.08 < late_bytes / len(DATA) < 0.12
    assert list(ByteFaults(ByteFault(delay_rate=1.0, delay_ns=500), 3).apply(DATA)) == [(500, DATA)]
    assert pieces[0][0] in (0, 500)


@given(st.lists(st.integers(0, len(DATA)), max_size=5), st.integers(0, 2**63))
def test_cuts_make_no_difference(cuts, seed):
    whole, whole_changed = through(ALL, DATA, seed)
    faults = ByteFaults(ALL, seed)
    ends = [0, *sorted(cuts), len(DATA)]
    parts = [piece for i, j in pairwise(ends) for _, piece in faults.apply(DATA[i:j])]
    assert (b"".join(parts), faults.changed_bytes) == (whole, whole_changed)


def test_another_seed_is_another_fate():
    assert through(ALL, DATA, 1)[0] != through(ALL, DATA, 2)[0]


def test_a_seed_keeps_its_fate():
    """Logs and tests of earlier versions have seeds in them."""
    out, changed = through(ALL, DATA, 5)
    assert (zlib.crc32(out), changed) == (3350908251, 796)


def test_a_long_answer_costs_little():
    """126 kB, a look-up table as the Mechaduino prints it: a draw for each bit took 0.7 s in the step that
    prints it, and a healthy board was stopped."""
    data = bytes(126_000)
    began_s = time.thread_time()
    for fault in (ByteFault(bit_error_rate=0.0001), ByteFault(drop_rate=0.5), ByteFault(duplicate_rate=0.5)):
        through(fault, data)
    assert time.thread_time() - began_s < 0.1
