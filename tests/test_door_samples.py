"""Bytes that a page gets of an axis that turns, in virtual time: nothing swings slower there than it is."""

import struct
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import pairwise

import pytest

from bridges.web.streams import AxisSamples
from hil.core import FIELDS
from hil.core.fields import OFFSETS
from hil.telemetry import Sampler
from hil.testing import Bench, RecordingDesk
from hil.vocab.desk_protocol import AxisField, DeviceInfo, Source, Watch, Watched
from hil.vocab.verbs import Role, table_of

CONFIG = {"bench": "t", "devices": {"m1": {"profile": "mechaduino", "flash": {"table": "identity"}}}}
TURNING_S = 4
PAGE = Source("page", Role.VIEWER)


class _Samples:
    """Watch on the samples of an axis in virtual time."""

    def __init__(self, sampler: Sampler, axis: str, call: Callable[..., object], *every: object) -> None:
        self._sampler, self._call = sampler, call
        self._subscription = sampler.subscribe(axis, (), *every)  # type: ignore[arg-type]

    @property
    def lost(self) -> int:
        return self._subscription.lost

    def flush(self) -> None:
        self._sampler.poll()
        for packed in self._subscription.take_packed():
            self._call(packed)

    def close(self) -> None:
        self._sampler.unsubscribe(self._subscription)


class _SampledDesk(RecordingDesk):
    """Desk whose samples are those of a bench in virtual time."""

    def __init__(self, bench: Bench) -> None:
        super().__init__({})
        self._sampler = Sampler(bench.runtime)
        fields = {
            each.name: AxisField(each.name, each.type, each.unit, "", OFFSETS[each.name], False, True)
            for each in FIELDS.values()
        }
        self.devices["m1"] = DeviceInfo("m1", "mechaduino", False, table_of(()), fields)

    def watch(
        self,
        source: Source,
        what: Watched,
        target: str,
        call: Callable[..., object],
        *,
        interval_ns: int | Fraction = 0,
        points: int = 1,
    ) -> Watch:
        return _Samples(self._sampler, target, call, interval_ns, points)


def taken(stream: AxisSamples) -> bytes | None:
    """Take what there is: of two turns of the page the second."""
    assert stream.next_message(0.0) is None
    return stream.next_message(1.0)


def rows_of(block: bytes | None) -> list[tuple[float, ...]]:
    assert block is not None
    _, fields, _, _, lost, rows = struct.unpack_from("<BBHIII", block)
    assert lost == 0
    return [struct.unpack_from(f"<{1 + fields}d", block, 16 + 8 * row * (1 + fields)) for row in range(rows)]


@pytest.fixture(scope="module")
def told() -> dict[tuple[int, int], list[tuple[float, ...]]]:
    """Rows of the time and the currents of both coils by rate and points, of an axis that turns at 60 rpm."""
    bench = Bench(CONFIG)
    bench.run(ms=4500)
    bench.port("m1").write(b"vy")
    bench.run(ms=500)
    bench.port("m1").write(b"r60\n")
    bench.run(ms=2000)
    desk = _SampledDesk(bench)
    asked = [(60, 1), (60, 12), (1000, 1), (1000, 7)]
    streams = [
        AxisSamples(desk, PAGE, 1, "m1", ["current_a_A", "current_b_A"], rate_Hz, points)
        for rate_Hz, points in asked
    ]
    bench.run(ms=1000 * TURNING_S)
    return {each: rows_of(taken(stream)) for each, stream in zip(asked, streams, strict=True)}


def swings_Hz(rows: Sequence[tuple[float, ...]], column: int) -> float:
    """Frequency at which a column passes zero upwards."""
    ups = [later[0] for row, later in pairwise(rows) if row[column] < 0 <= later[column]]
    return (len(ups) - 1) / (ups[-1] - ups[0])


def turned(rows: Sequence[tuple[float, ...]]) -> float:
    """Sense of rotation of the currents: above 0 forwards."""
    return sum(a * later_b - b * later_a for (_, a, b), (_, later_a, later_b) in pairwise(rows))


TRUE_HZ = 50.0
"""A motor of 50 teeth at a turn each second."""


def test_plain_samples_at_the_rate_of_pictures_alias(
    told: dict[tuple[int, int], list[tuple[float, ...]]],
) -> None:
    """Why a page has to ask for something else; that the axis turns as fast as it should."""
    assert swings_Hz(told[60, 1], 1) == pytest.approx(10, abs=0.6)
    assert swings_Hz(told[1000, 1], 1) == pytest.approx(TRUE_HZ, rel=0.01)


@pytest.mark.parametrize("asked", [(1000, 1), (1000, 7)])
def test_an_axis_in_sight_has_its_currents(
    told: dict[tuple[int, int], list[tuple[float, ...]]], asked: tuple[int, int]
) -> None:
    rows = told[asked]
    assert len(rows) == TURNING_S * 1000 * (1 if asked[1] == 1 else 2)
    for column in (1, 2):
        assert swings_Hz(rows, column) == pytest.approx(TRUE_HZ, rel=0.01)
    assert abs(turned(rows)) > 1
    assert (turned(rows) > 0) is (turned(told[1000, 1]) > 0)


def test_extremes_have_the_size_of_what_swings(told: dict[tuple[int, int], list[tuple[float, ...]]]) -> None:
    rows, exact = told[60, 12], told[1000, 1]
    assert len(rows) == TURNING_S * 60 * 2
    most_A = max(row[1] for row in exact)
    for first, last in zip(rows[::2], rows[1::2], strict=True):
        low, high = sorted((first[1], last[1]))
        assert last[0] - first[0] == pytest.approx(11 / 720, abs=1e-6)
        assert high - low > 1.5 * most_A  # five sixths of a period, in each interval
        assert high <= most_A * 1.1
