"""Checksums of states whose texts are kept from one to the next."""

import zlib

from hypothesis import given
from hypothesis import strategies as st

from hil.core import Snapshot
from hil.sim.state_checksum import StateChecksums, snapshot_text, state_checksum
from hil.testing import Bench

NAMES = {"at_ns": 0, "a": 2, "b": 1}
VALUES = st.sampled_from([0.0, -0.0, float("nan"), float("inf"), 1.5, 1e22, 5e-324]) | st.floats()
STATES = st.tuples(st.integers(0, 2**63 - 1), VALUES, VALUES)


@given(st.lists(st.lists(STATES, min_size=1, max_size=3), max_size=20))
def test_kept_texts_are_those_of_the_values(turns: list[list[tuple[float, ...]]]) -> None:
    checksums = StateChecksums()
    for turn in turns:
        snapshots = [Snapshot(values, NAMES) for values in turn]
        assert checksums.of("m1", snapshots) == state_checksum(snapshots)
        assert state_checksum(snapshots) == zlib.crc32("".join(map(snapshot_text, snapshots)).encode())


def test_another_kind_of_axis_in_the_same_place_has_its_own_text() -> None:
    checksums, other = StateChecksums(), {"at_ns": 0}
    for names in (NAMES, other, NAMES):
        snapshots = [Snapshot((7, 1.5, 2.5), names)]
        assert checksums.of("m1", snapshots) == state_checksum(snapshots)


def test_states_as_the_core_has_them_have_the_same_checksums() -> None:
    checksums = StateChecksums()
    with Bench({"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}) as bench:
        axis = bench._runtime.devices["m1"].axis
        for ms in (4500, 0, 1, 0, 10):
            bench.run(ms=ms)
            for state in (axis.snapshot(), axis.glance()):
                assert checksums.of("m1", [state]) == state_checksum([axis.snapshot()])
            bench.port("m1").write(b"y")  # its loop is on: the state changes


def test_the_text_has_every_field_as_python_writes_it() -> None:
    """Logs that were written have checksums of these texts."""
    assert snapshot_text(Snapshot((7, 1.5, -0.0), NAMES)) == "Snapshot(at_ns=7, a=-0.0, b=1.5)"
    assert state_checksum([Snapshot((7, 1.5, -0.0), NAMES)]) == 0x2D8DBA79
