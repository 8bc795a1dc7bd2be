"""Lines of Walter's command port, as captures show them."""

from device_profiles.walter.line_framing import LINES
from hil.vocab.time import SimTimeNs


def test_a_line_that_does_not_end_is_given_in_pieces() -> None:
    splitter, given = LINES.splitter(), []
    for at_ns in range(100):
        given += splitter.burst(b"x" * 100, SimTimeNs(at_ns), 115200).items
        assert len(splitter.pending) < 1024
    given += splitter.burst(b"GET 1\r", SimTimeNs(100), 115200).items
    assert b"".join(item.raw for item in given) == b"x" * 10_000 + b"GET 1\r"
    assert [item.is_packet for item in given[-2:]] == [False, True]
