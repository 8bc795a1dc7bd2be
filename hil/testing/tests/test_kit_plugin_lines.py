"""The fixtures ``segment`` and ``fault``."""

import pytest

from device_profiles.sac.packet import encode

ACK = b"\x06"


def test_a_segment_of_nodes_answers_each_address(segment):
    b = segment(32)
    master = b.tap("bus0.master")
    for address in range(4, 36):
        master.write(encode(address, 1, b"y"))
        b.run(ms=10)
        assert master.read() == encode(1, address, ACK)
    master.write(encode(36, 1, b"y"))
    b.run(ms=10)
    assert master.read() == b""
    assert b.segment("bus0").clashes() == {}


def test_a_fast_segment(segment):
    b = segment(2, baud=1_000_000)
    b.tap("bus0.master").write(encode(4, 1, b"y"))
    b.run(ms=0.5)
    assert b.tap("bus0.master").read() == encode(1, 4, ACK)


@pytest.mark.parametrize(("nodes", "first"), [(0, 4), (253, 4), (1, 3), (2, 255)])
def test_addresses_have_to_fit(segment, nodes, first):
    with pytest.raises(ValueError, match="4 to 255"):
        segment(nodes, first=first)


def test_a_fault_ends_with_its_test(segment, fault):
    b = segment(1)
    made = fault(b, "packet_no_ack", "s4.network")
    b.tap("bus0.master").write(encode(4, 1, b"y"))
    b.run(ms=10)
    assert b.tap("bus0.master").read() == b""
    assert made.is_active
