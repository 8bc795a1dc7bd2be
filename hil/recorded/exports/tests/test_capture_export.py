"""An export as pcapng equals a capture of the bench in the same run."""

from io import BytesIO
from pathlib import Path

from exported_bench import CONFIG, drive

from hil.recorded.exports.capture_export import write_capture
from hil.recorded.exports.run_records import record_sources
from hil.recorded.recorded_run import RecordedRun
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.wire.pcapng import Record, read


def records(data: bytes) -> list[tuple[object, ...]]:
    """Records, in the order of time, without their places in the file."""
    found = [(each.at_ns, each.line, each.event, each.data, each.comment) for each in read(data)]
    return sorted(found, key=repr)


def captured(file: Path) -> tuple[bytes, RecordedRun, SimTimeNs]:
    with Bench(CONFIG) as bench:
        with bench.capture(file):
            drive(bench)
        return file.read_bytes(), RecordedRun(bench.inputs.log()), SimTimeNs(bench.now_ns)


def test_it_equals_a_capture_of_the_run(tmp_path: Path) -> None:
    expected, run, end_ns = captured(tmp_path / "run.pcapng")
    file = BytesIO()
    count = write_capture(file, run, [*record_sources(run.runtime)], SimTimeNs(0), end_ns)
    found = records(file.getvalue())
    names = {each.interface for each in read(file.getvalue())}
    assert names == {"m1", "m2", "s1", "s2", "s3", "bus1", "bus0", "can0"}
    assert found == records(expected)
    assert count == len(found) > 20
    times_ns = [each.at_ns for each in read(file.getvalue())]
    assert times_ns == sorted(times_ns)


def test_a_window_and_some_sources(tmp_path: Path) -> None:
    expected, run, end_ns = captured(tmp_path / "run.pcapng")
    from_ns = SimTimeNs(end_ns - 450 * NS_PER_MS)
    file = BytesIO()
    write_capture(file, run, ["bus1", "s1"], from_ns, end_ns)

    def is_meant(each: Record) -> bool:
        return each.interface in ("bus1", "s1") and each.at_ns >= from_ns

    kept = [each for each in read(expected) if is_meant(each)]
    assert [each.data for each in read(file.getvalue())] == [each.data for each in kept]
    assert len(kept) == 2
