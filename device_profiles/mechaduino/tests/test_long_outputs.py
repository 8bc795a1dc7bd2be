"""``q``, ``g``, ``j``, ``c`` and ``a``: by hash, length and selected values."""

import hashlib
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from device_profiles.mechaduino import text
from hil.testing import Bench

CALIBRATION: dict[str, Any] = json.loads((Path(__file__).parent / "data" / "calibration.json").read_text())
COUNTS = 16384
Points = list[tuple[float, float]]


def ready(points: Points | None = None) -> Bench:
    """A bench at 5000 ms with the start-up's text read; the encoder holds 4000 or follows ``points``."""
    device = {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}}
    bench = Bench({"bench": "long", "devices": {"m1": device}})
    bench.axis("m1").script_encoder(points or [(0, 4000)])
    bench.run_until(5000)
    bench.port("m1").read()
    return bench


def lookup(bench: Bench) -> "np.ndarray[Any, Any]":
    return np.frombuffer(bench.device("m1").nvm["lookup"], dtype=np.float32)


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


# ---- q ----


def test_q_is_the_firmwares_to_the_last_byte() -> None:
    # Length and hash: output of the public firmware 0.1.5 with the identity table.
    bench = ready()
    bench.port("m1").write(b"q")
    out = bench.port("m1").read()
    assert len(out) == 126682
    assert sha256(out) == "9693dfeee2582ef3c1061b61bbe705454ba265139bd1d9eb144c3c0124135266"
    assert bench.now_ns == 5000_000_000


def test_q_prints_edited_gains_with_ten_decimals_and_the_table_with_two() -> None:
    # pKi = 15 * float32(0.1 * 0.1f) = 0.1499999911 and the text around it: reference dialogue of k p.
    bench = ready()
    bench.port("m1").write(b"kpp10\ni0.15\nd20\nl60\nq")
    bench.port("m1").read()
    bench.port("m1").write(b"q")
    head, _, entries = bench.port("m1").read().decode().partition("lookup[16384] = {\r\n")
    for line in (
        "volatile float Fs = 6500.0000000000;  //Sample frequency in Hz",
        "volatile float pKp = 10.0000000000;      //position mode PID vallues.",
        "volatile float pKi = 0.1499999911;",
        "volatile float pKd = 20.0000000000;",
        "volatile float pLPF = 60.0000000000;",
        "volatile float vKp = 0.0010000000;      //velocity mode PID vallues.",
    ):
        assert f"{line}\r\n" in head
    assert entries.endswith("359.96, 359.98, \r\n};\r\n")
    assert entries.count(", ") == COUNTS


# ---- g ----


def test_g_prints_a_sine_that_is_not_the_built_in_one() -> None:
    # Hash: the numbers of the public firmware's output, whose explaining lines are not ours.
    bench = ready()
    bench.port("m1").write(b"gp")
    intro = "".join(f"{line}\r\n" for line in text.SINE_INTRO)
    assert bench.port("m1").read_timed() == [(5000_000_000, intro.encode())]
    bench.run_until(7999.999)
    assert bench.port("m1").read() == b""
    bench.run_until(8000)
    head, numbers = bench.port("m1").read().decode().split("...\r\n\r\n")
    assert head == "Printing sine look up table:"
    numbers, behind, _ = numbers.partition("stepNumber")
    assert behind, "p was typed while g waited, and comes right after the numbers"
    assert len(numbers) == 20060
    assert sha256(numbers.encode()) == "70a3992ca34033858e53ac382b7adf6f19bed0d49eec86bda5d5330325f0205a"
    values = [int(word) for word in numbers.split(", ")[:-1]]
    assert len(values) == 3601
    assert values[:4] == [0, 2, 4, 5]
    assert (values[900], values[2700], values[3600]) == (1024, -1024, 0)
    built_in = [round(1024 * math.sin(a * 3.1415 / 1800)) for a in range(3601)]
    assert sum(a != b for a, b in zip(values, built_in, strict=True)) == 206


# ---- j ----


def printed_numbers(bench: Bench) -> list[tuple[int, int]]:
    """(time in ns, number) of each sample that j prints."""
    return [
        (at_ns, int(data))
        for at_ns, data in bench.port("m1").read_timed()
        if data[:-2].lstrip(b"-").isdigit()
    ]


def test_j_counts_down_and_prints_650_samples() -> None:
    # The loop starts at 5000 ms, so its step k is at 5000 ms + k * 7385 / 48 MHz. The first after 15000 ms
    # is k = 64997; every fifth prints, the first of them k = 65001 at 15000.674688 ms (reference too).
    bench = ready()
    bench.port("m1").write(b"j")
    bench.run_until(14999)
    assert bench.axis("m1").snapshot().loop_on == 1
    countdown = bench.port("m1").read_timed()
    assert countdown[0][1].endswith(b"You have 10 seconds...\r\n")
    assert countdown[1:] == [
        ((5000 + 1000 * n) * 1_000_000, f"{10 - n}...\r\n".encode()) for n in range(1, 10)
    ]
    bench.run_until(15100)
    assert bench.axis("m1").snapshot().r == np.float32(97.65)
    bench.run_until(15999)
    samples = printed_numbers(bench)
    assert samples == [
        (5000_000_000 + (65001 + 5 * n) * 7385 * 1000 // 48, 90000) for n in range(650)
    ]  # 4000 * 360 / 16384 * 1024
    assert bench.axis("m1").snapshot().r == 0
    assert bench.axis("m1").snapshot().loop_on == 1
    bench.run_until(16000)
    assert bench.axis("m1").snapshot().loop_on == 0
    assert bench.axis("m1").snapshot().mode == 0


def test_j_truncates_towards_zero_below_zero() -> None:
    # Hash: the 650 numbers of the public firmware for an encoder that runs backwards through its zero.
    points: Points = [(0, 300), (15100, 300), (15600, -3000), (20000, -3000)]
    bench = ready()
    bench.axis("m1").script_encoder(points, "linear")
    bench.port("m1").write(b"x")
    bench.run(100)
    bench.port("m1").write(b"j")
    bench.run_until(17500)
    samples = printed_numbers(bench)
    numbers = "".join(f"{number}\r\n" for _, number in samples)
    assert len(samples) == 650
    assert sha256(numbers.encode()) == "483548aed107dde1c0133fb4dcbcff93f211f40f26b2da12f8630fcad7c62aff"
    assert abs(samples[0][0] - 15100_674_688) <= 1


def test_j_keeps_the_phase_of_its_samples_in_a_static_counter() -> None:
    # 500 ms hold 3249 or 3250 steps. The loop is on since y's end at 5100 ms and j's window is
    # (15900.57, 16400.57] ms: steps 70201 (5100 + 10800.716 ms) to 73449 (5100 + 11300.435 ms) are in it,
    # 3249 of them: 649 samples and 4 steps over. The second j starts the loop again at 17400.57 ms, and the
    # first step in its window, 64997, is the fifth already.
    def step_ns(start_ns: int, k: int) -> int:
        return start_ns + k * 7385 * 1000 // 48

    bench = ready()
    bench.port("m1").write(b"y")
    bench.run_until(5900.57)
    bench.port("m1").write(b"j")
    bench.run_until(17400.57)
    first = [at_ns for at_ns, _ in printed_numbers(bench)]
    assert first == [step_ns(5100_000_000, 70205 + 5 * n) for n in range(649)]
    bench.port("m1").write(b"j")
    bench.run_until(29000)
    second = [at_ns for at_ns, _ in printed_numbers(bench)]
    assert second == [step_ns(17400_570_000, 64997 + 5 * n) for n in range(650)]


def test_bytes_wait_while_j_runs() -> None:
    bench = ready()
    bench.port("m1").write(b"j")
    bench.run(3000)
    bench.port("m1").write(b"p")
    bench.run_until(16000)
    *_, last = bench.port("m1").read_timed()
    assert last == (16000_000_000, b"stepNumber: 0 , Angle: ")


# ---- c ----


def reading_points(readings: list[list[int]], first_ms: float = 5640) -> Points:
    """Encoder points for the readings of each step: a count stands from half a millisecond before it is
    read."""
    points: Points = [(0, readings[0][0])]
    for step, ten in enumerate(readings):
        points += [(first_ms + 130 * step + 10 * k - 0.5, count) for k, count in enumerate(ten)]
    return points


def equidistant(first: float = 1000.3, step: float = 81.92) -> list[list[int]]:
    return [[math.floor(first + step * n) % COUNTS] * 10 for n in range(200)]


def progress_times(start_ms: int) -> list[int]:
    """Times in ns at which each step's mark is printed: 20 ms wait, ten readings of 10 ms, 10 ms for the next
    step."""
    return [(start_ms + 130 * n + 120) * 1_000_000 for n in range(200)]


def check_timeline(bench: Bench, start_ms: int, first_reading_ms: int) -> None:
    timed = bench.port("m1").read_timed()
    assert timed[0] == (start_ms * 1_000_000, b"Beginning calibration routine...\r\n")
    assert [at_ns for at_ns, _ in timed[1:201]] == progress_times(first_reading_ms - 20)
    assert [data for _, data in timed[1:201]] == [
        f"\r\n{n // 2}% ".encode() if n % 20 == 0 else b"." for n in range(200)
    ]
    assert timed[201][0] == (first_reading_ms - 20 + 26000) * 1_000_000
    assert timed[201][1].startswith(b"\r\nWriting to flash 0xB900 page size PSZ=3")
    assert len(timed) == 202


def test_c_with_equidistant_steps() -> None:
    # 510 ms for the first step, 110 ms back to 0, then the readings. Hashes: table and text that the
    # public firmware makes of these readings.
    bench = ready(reading_points(equidistant()))
    bench.port("m1").write(b"c")
    bench.run_until(40000)
    out = b"".join(data for at_ns, data in bench.port("m1").timeline if at_ns >= 5000_000_000)
    check_timeline(bench, 5000, 5640)
    assert sha256(out) == "075e20d704482e21048859c0061f40d1a3ffb899b0c6d54310191c2fa7e22dd9"
    packed = bench.device("m1").nvm["lookup"]
    assert sha256(packed) == "a98da1b5ad2e77cb5940ff84a52c9706e143d49860720af2f5d8be92595131a5"


@pytest.mark.parametrize("case", CALIBRATION["cases"], ids=lambda case: case["name"])
def test_c_with_noisy_readings(case: dict[str, Any]) -> None:
    readings = [(np.cumsum([int(w) for w in line.split()]) % COUNTS).tolist() for line in case["readings"]]
    bench = ready(reading_points(readings))
    bench.port("m1").write(b"c")
    bench.run_until(40000)
    assert sha256(bench.port("m1").read()) == case["output_sha256"]
    assert sha256(bench.device("m1").nvm["lookup"]) == case["table_sha256"]


def test_c_with_an_encoder_that_stands_still_writes_nothing_and_reports_success() -> None:
    bench = ready()
    bench.port("m1").write(b"c")
    bench.run_until(36000)
    before = lookup(ready())
    timed = bench.port("m1").read_timed()
    assert timed[-1][0] == 31620_000_000
    assert timed[-1][1].decode() == "\r\nWriting to flash 0xB900 page size PSZ=3" + "".join(
        f"{line}\r\n" for line in text.CALIBRATION_DONE
    )
    assert (lookup(bench) == before).all()
    # Left with dir = true and stepNumber = -200: s makes -201 of it.
    bench.port("m1").write(b"s")
    bench.run_until(36010)
    assert bench.port("m1").read() == b"stepNumber: -201 , Angle: "


def test_c_twice_walks_back_200_steps_first() -> None:
    # The first leaves stepNumber = -200. The second steps to -201 (10 ms + 500 ms), then 201 steps of
    # 110 ms back to 0: 22110 ms. The readings are the same, so the table is, too.
    readings = equidistant()
    second = [(t_ms, count) for t_ms, count in reading_points(readings, 40000 + 510 + 22110 + 20)[1:]]
    points = [*reading_points(readings), (39000, readings[0][0]), *second]
    bench = ready(points)
    bench.port("m1").write(b"c")
    bench.run_until(40000)
    check_timeline(bench, 5000, 5640)
    first_table = bench.device("m1").nvm["lookup"]
    bench.port("m1").write(b"c")
    bench.run_until(95000)
    check_timeline(bench, 40000, 62640)
    assert bench.device("m1").nvm["lookup"] == first_table


def test_c_with_a_falling_encoder_makes_a_rising_table() -> None:
    # The first step does not fall, so the wiring test passes. The firmware looks for the zero among the
    # steps counted from the end: reading 13 is floor(1000.3 - 13 * 81.92) = -65, and 65 counts above it
    # is the zero, so it starts the table at step 199 - 13 = 186 with j = 65. That step has 82 counts
    # (readings -14237 and -14319), of which j = 82 ... 66 are written: 17 entries from 186 * 1.8 deg on;
    # step 187 follows. Left out is most of a step, which shows as a jump.
    bench = ready(reading_points(equidistant(step=-81.92)))
    bench.port("m1").write(b"c")
    bench.run_until(40000)
    assert bench.port("m1").read().count(b"0x") == 17  # all rows, as with a rising encoder
    table = lookup(bench)
    assert table[0] == np.float32(334.8)
    assert table[17] == np.float32(336.6)
    rise = np.unwrap(table.astype(float), period=360) - np.arange(COUNTS) * 360 / COUNTS - table[0]
    assert np.abs(rise).max() < 1.8 + 360 / COUNTS


def test_c_does_not_stop_a_running_loop() -> None:
    bench = ready(reading_points(equidistant()))
    bench.port("m1").write(b"y")
    bench.run_until(5100)
    bench.axis("m1").script_encoder(reading_points(equidistant(), 5740))
    bench.port("m1").read()
    bench.port("m1").write(b"c")
    bench.run_until(20000)
    assert bench.axis("m1").snapshot().loop_on == 1
    bench.run_until(40000)
    check_timeline(bench, 5100, 5740)
    snapshot = bench.axis("m1").snapshot()
    assert snapshot.loop_on == 1
    # 34.9 s of steps of 153.854167 us each.
    assert snapshot.control_steps == 34_900_000_000 * 48 // (7385 * 1000)


@pytest.mark.parametrize("start_deg", [6.3, 100.0, 200.0])
def test_c_on_the_motor_finds_its_encoder(start_deg: float) -> None:
    # Open-loop steps of the plain motor land within a count or two of the true angle, so the table is
    # the encoder's own angle plus one constant offset.
    axis = {"start_deg": start_deg}
    device = {"profile": "mechaduino", "port": "memory", "flash": {"table": "empty"}, "axis": axis}
    bench = Bench({"bench": "long", "devices": {"m1": device}})
    bench.run_until(5000)
    bench.port("m1").write(b"c")
    bench.run_until(40000)
    assert b"Calibration complete!\r\n" in bench.port("m1").read()
    table = lookup(bench)
    offset = np.unwrap(table.astype(float), period=360) - np.arange(COUNTS) * 360 / COUNTS
    assert offset.max() - offset.min() < 0.1
    bench.port("m1").write(b"p")
    bench.run(100)
    angle = float(bench.port("m1").read().split(b"Angle: ")[1].split(b",")[0])
    raw = bench.axis("m1").snapshot().raw
    assert abs(angle - table[raw]) <= 0.03


# ---- a ----


def test_a_holds_656_angles_there_and_back() -> None:
    # With pKp = 1, pKi = pKd = 0 and the encoder at 0 the effort is the set-point. Entry 8 n of the
    # identity table is n * 45 / 256, exact in ten decimals.
    bench = ready([(0, 0)])
    port = bench.port("m1")
    port.write(b"kpp1\ni0\nd0\nq\n")
    port.read()
    port.write(b"a")
    bench.run_until(5000 + 1000 + 2 * 65600 - 0.001)
    timed = port.read_timed()
    assert timed[0] == (5000_000_000, f"{text.ANTICOGGING_BEGIN}\r\n".encode())
    assert [at_ns for at_ns, _ in timed[1:]] == [(6000 + 100 * n) * 1_000_000 for n in range(1312)]
    assert bench.axis("m1").snapshot().loop_on == 1
    assert bench.axis("m1").snapshot().mode == ord("x")
    bench.run_until(5000 + 1000 + 2 * 65600)
    timed += port.read_timed()
    assert bench.axis("m1").snapshot().loop_on == 0
    lines = b"".join(data for _, data in timed).decode().split("\r\n")
    assert lines[0] == text.ANTICOGGING_BEGIN
    assert lines[657] == text.ANTICOGGING_REVERSE
    assert lines[1314:] == [text.ANTICOGGING_DONE, ""]
    there, back = lines[1:657], lines[658:1314]
    assert back == there[::-1]
    assert there[7] == "0.1757812500 , 0.1757812500"
    assert there[655] == "14.4140625000 , 14.4140625000"
    for entry, line in enumerate(there, 1):
        assert [abs(float(word) - entry * 360 / COUNTS) < 1e-6 for word in line.split(" , ")] == [True] * 2
