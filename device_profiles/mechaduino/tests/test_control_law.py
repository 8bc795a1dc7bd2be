"""The control law, the commutation and the calibration against the firmware's own numbers, bit for bit."""

import csv
import hashlib
import json
import math
from array import array
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from device_profiles.mechaduino import calibration
from hil.core import _native
from hil.testing import replay_control

DATA = Path(__file__).parent / "data"
LAW: dict[str, Any] = json.loads((DATA / "control_law.json").read_text())
CALIBRATION: dict[str, Any] = json.loads((DATA / "calibration.json").read_text())
COMMUTATION = list(csv.reader((DATA / "commutation.csv").read_text().splitlines()[1:]))
FLOATS = ("y_meas", "y_excite", "yw", "e", "ITerm", "DTerm", "v", "u")
COUNTS = 16384
INTERRUPT_SINE = [round(1024 * math.sin(a * 3.1415 / 1800)) for a in range(3600)]
"""The firmware's built-in table, entry by entry the values of this formula (pi is 3.1415 there)."""


def single(bits: str) -> float:
    return float(np.frombuffer(bytes.fromhex(bits)[::-1], dtype="<f4")[0])


@cache
def table(name: str) -> "np.ndarray[Any, Any]":
    """Look-up table: ``identity``, or ``distorted`` as a calibration of an eccentric magnet has it, cut to
    0.001 deg."""
    count = np.arange(COUNTS)
    if name == "identity":
        return (count * 360 / COUNTS).astype(np.float32)
    turn = [2 * math.pi * i / COUNTS for i in range(COUNTS)]
    first = [0.8 * math.sin(t + math.radians(40)) for t in turn]
    second = [0.15 * math.sin(2 * t - math.radians(70)) for t in turn]
    angles = [360 * i / COUNTS + 137.3 + first[i] + second[i] for i in range(COUNTS)]
    return np.array([math.floor(1000 * (angle % 360)) / 1000 for angle in angles], dtype=np.float32)


def expand(text: str) -> Iterator[str]:
    for word in text.split():
        value, _, repeats = word.partition("*")
        yield from [value] * int(repeats or 1)


@cache
def columns(index: int) -> "dict[str, np.ndarray[Any, Any]]":
    case = LAW["cases"][index]
    steps = [int(word) for word in expand(case["raw_steps"])]
    return replay_control(
        "mechaduino",
        raw=(np.cumsum(steps) % COUNTS).tolist(),
        r=[single(bits) for bits in expand(case["r"])],
        mode=[int(word) for word in expand(case["mode"])],
        table=table(case["table"]).tolist(),
        gains=case["gains"],
        gain_changes=case["gain_changes"],
    )


CASES = pytest.mark.parametrize(
    "index", range(len(LAW["cases"])), ids=[case["name"] for case in LAW["cases"]]
)


@CASES
def test_every_bit_of_every_step_is_the_firmwares(index: int) -> None:
    replayed = columns(index)
    for name, expected in LAW["cases"][index]["sha256"].items():
        packed = replayed[name].astype("<f4" if name in FLOATS else "<i4").tobytes()
        assert hashlib.sha256(packed).hexdigest() == expected, name


@CASES
def test_steps_at_an_interesting_place(index: int) -> None:
    # The same numbers as under the hashes; here a deviation shows itself.
    case = LAW["cases"][index]
    for step, line in enumerate(case["rows"], case["rows_from"]):
        for name, word in zip(case["sha256"], line.split(), strict=True):
            value = columns(index)[name][step]
            shown = np.float32(value).tobytes()[::-1].hex() if name in FLOATS else str(value)
            assert shown == word, f"step {step}, {name} = {value}"


@pytest.mark.parametrize("row", COMMUTATION, ids=lambda row: f"{row[0]}-{row[1]}")
def test_commutation(row: list[str]) -> None:
    law = _native.Replay(table("identity").tobytes())
    found = law.output(single(row[0]), int(row[1]))
    pins = ("vref1", "vref2", "in1", "in2", "in3", "in4")
    assert [found[name] for name in pins] == [int(word) for word in row[2:]]  # type: ignore[literal-required]


def test_the_sine_table_of_the_interrupt_has_a_short_pi() -> None:
    law = _native.Replay(table("identity").tobytes())
    found = []
    for a in range(3600):
        # Half a unit inside the truncation of 500 * theta; at effort 1024 the current is the entry.
        row = law.output((a + 0.5) / 500, 1024)
        found.append(row["vref1"] if row["in2"] else -row["vref1"])
        second = row["vref2"] if row["in4"] else -row["vref2"]
        assert second == INTERRUPT_SINE[(a + 900) % 3600]
    assert found == INTERRUPT_SINE


def plain_readings() -> list[list[int]]:
    """Equidistant steps, from a shaft at 1000.3 counts."""
    return [[math.floor(1000.3 + 81.92 * step) % COUNTS] * 10 for step in range(200)]


def packed_readings(lines: list[str]) -> list[list[int]]:
    return [(np.cumsum([int(word) for word in line.split()]) % COUNTS).tolist() for line in lines]


def table_sha256(readings: list[list[int]]) -> str:
    angles = calibration.angles([calibration.average(ten) for ten in readings])
    return hashlib.sha256(np.array(angles, dtype="<f4").tobytes()).hexdigest()


def test_the_table_of_equidistant_steps() -> None:
    expected = "a98da1b5ad2e77cb5940ff84a52c9706e143d49860720af2f5d8be92595131a5"
    assert table_sha256(plain_readings()) == expected


@pytest.mark.parametrize("case", CALIBRATION["cases"], ids=lambda case: case["name"])
def test_the_table_of_noisy_readings(case: dict[str, Any]) -> None:
    readings = packed_readings(case["readings"])
    assert table_sha256(readings) == case["table_sha256"]
    angles = calibration.angles([calibration.average(ten) for ten in readings])
    assert [round(angle, 3) for angle in angles[:4]] == case["table_head"]


@pytest.mark.parametrize(
    ("readings", "mean"),
    [
        ([100] * 10, 100),
        # Five of 16383, five of 0 as 16384 each: 163835 / 10 = 16383.5, truncated.
        ([16383, 0] * 5, 16383),
        # From the first reading 0: 16383 counts as -1, the mean is -0.5, truncated to 0.
        ([0, 16383] * 5, 0),
        # -1 nine times and 0: -0.9 truncates to 0 as well; -20 / 10 = -2 is below zero and gets a turn.
        ([0, *[16383] * 9], 0),
        ([0, *[16382] * 8, 16380], 16382),
    ],
)
def test_readings_are_averaged_across_the_zero(readings: list[int], mean: int) -> None:
    assert calibration.average(readings) == mean


def test_only_whole_rows_are_written() -> None:
    # 100 angles are one row of 64 and a rest that stays in RAM.
    old = np.full(COUNTS, 7, dtype=np.float32).tobytes()
    packed = calibration.written(old, array("f", [1.0] * 100))
    assert np.frombuffer(packed, dtype=np.float32).tolist() == [1.0] * 64 + [7.0] * (COUNTS - 64)
    assert calibration.written(old, array("f")) == old
    assert len(calibration.written(old, array("f", [1.0] * (COUNTS + 640)))) == len(old)
