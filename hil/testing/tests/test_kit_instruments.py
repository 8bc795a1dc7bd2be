"""Boards by a table in a bench in memory: bytes in, bytes out, at what time."""

from collections.abc import Callable, Iterator
from functools import reduce
from io import StringIO
from operator import xor
from pathlib import Path
from typing import Any

import pytest

from hil.compose.replay import replay
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLogWriter
from hil.testing import Bench, check_profile

MS = 1_000_000
BYTE_NS = 1_041_667
"""Time of a byte of ten bits at 9600 baud, rounded."""

Made = Callable[..., Bench]


@pytest.fixture
def made(tmp_path: Path) -> Iterator[Made]:
    """Maker of a bench with an instrument ``d``, by the keys below ``dialogue``."""
    benches = []

    def make(dialogue: str, baud: int = 9600, log: StringIO | None = None, **device: Any) -> Bench:
        folder = tmp_path / "meter"
        folder.mkdir(exist_ok=True)
        indented = "".join(f"  {line}\n" for line in dialogue.strip("\n").splitlines())
        text = f"name: meter\ntitle: Meter\nuarts: {{main: {{baud: {baud}}}}}\ndialogue:\n{indented}"
        (folder / "profile.yaml").write_text(text)
        config = {
            "bench": "t",
            "profile_path": [str(tmp_path)],
            "devices": {"d": {"profile": "meter", **device}},
        }
        around = BenchHooks(log=InputLogWriter(log, "t", config, {})) if log else None
        benches.append(Bench(config, around=around) if around else Bench(config))
        return benches[-1]

    yield make
    for bench in benches:
        bench.close()


def asked(bench: Bench, text: bytes, ms: float = 300) -> bytes:
    bench.port("d").write(text)
    bench.run(ms=ms)
    return bench.port("d").read()


METER = """
answer_after_ms: 20
errors: {unknown: "?", out_of_range: "!", wrong_state: "-"}
variables:
  level_V: {unit: V, minimum: 0, maximum: 10, step: 0.5, kept: true, about: level}
  out: {type: switch, about: output}
  room_degC: {unit: degC, value: 20, input: true, about: room}
  heat_degC:
    {unit: degC, value: 20, about: heat, follows: {target: room_degC + 10 * out, time_constant_s: 1}}
  ramp_V: {unit: V, about: ramp, follows: {target: level_V, rate_per_s: 2}}
  warm: {type: switch, about: it is warm, computed: heat_degC > 25}
  way: {type: choice, choices: [SLOW, FAST], about: way}
  label: {type: text, value: none, longest: 5, about: label}
commands:
  - {asks: "L {level_V}", when: out}
  - {asks: "L?", answers: "{level_V:.1f} {ramp_V:.2f}"}
  - {asks: "ON {out}", answers: OK, takes_ms: 100}
  - {asks: "W {way}"}
  - {asks: "W?", answers: ["{way}", "{'quick' if way == 'FAST' else 'slow'}"]}
  - {asks: "N {label}"}
  - {asks: "N?", answers: "<{label}>"}
  - asks: "ADD {volts}"
    takes: {volts: {type: number, minimum: 0, maximum: 5}}
    sets: {level_V: level_V + volts}
  - {asks: "H?", answers: "{heat_degC:.2f}{warm:| warm}"}
"""


def test_it_sets_and_answers(made: Made) -> None:
    bench = made(METER)
    assert asked(bench, b"L 3\r\n") == b"-\r\n"
    assert asked(bench, b"ON 1\r\nL 3.3\nL?\r") == b"OK\r\n3.5 0.04\r\n"
    assert asked(bench, b"L 11\rwhat\rW FAST\rW?\rW NO\r") == b"!\r\n?\r\nFAST\r\nquick\r\n?\r\n"
    assert asked(bench, b"N hello\rN?\rN too long\r") == b"<hello>\r\n!\r\n"
    assert asked(bench, b"ADD 5\rL?\rADD 5\r", 1000) == b"8.5 1.64\r\n!\r\n"
    now = bench.axis("d").snapshot()
    assert (now.level_V, now.out, now.way, now.warm) == (8.5, 1, 1, 1)


def test_it_takes_its_time_and_bytes_wait_meanwhile(made: Made) -> None:
    bench = made(METER)
    bench.port("d").write(b"ON 1\rH?\r")
    bench.run(ms=400)
    times = [at_ns for at_ns, _ in bench.port("d").read_timed()]
    assert times[0] == pytest.approx(5 * BYTE_NS + 100 * MS, abs=2 * BYTE_NS)
    assert times[-1] == pytest.approx(times[0] + 20 * MS, abs=BYTE_NS)
    # The buffer has 64 bytes: of 40 commands that come while it is busy, most are lost.
    bench.port("d").write(b"ON 1\r" + b"H?\r" * 40)
    bench.run(ms=3000)
    assert 19 <= bench.port("d").read().count(b"\r\n") < 30


def test_slow_values_go_on_by_themselves(made: Made) -> None:
    bench = made(METER)
    asked(bench, b"ON 1\r", 125.0)
    start = bench.axis("d").snapshot().heat_degC
    bench.run(ms=1000)
    heat = bench.axis("d").snapshot().heat_degC
    assert heat == pytest.approx(30 - (30 - start) * 0.3679, abs=0.6)
    assert bench.axis("d").snapshot().warm == 1
    bench.axis("d").set("room_degC", 0)
    bench.run(ms=10_000)
    assert bench.axis("d").snapshot().heat_degC == pytest.approx(10, abs=0.01)
    assert asked(bench, b"H?\r") == b"10.00\r\n"


def test_what_is_kept_stays_without_power(made: Made) -> None:
    bench = made(METER)
    assert asked(bench, b"ON 1\rL 4\rW FAST\rN abc\r") == b"OK\r\n"
    bench.device("d").reset()
    assert asked(bench, b"L?\rW?\rN?\r") == b"4.0 0.05\r\nSLOW\r\nslow\r\n<none>\r\n"


def test_two_runs_and_a_replay_are_the_same(made: Made) -> None:
    heard = []
    for _ in range(2):
        log = StringIO()
        bench = made(METER, log=log)
        asked(bench, b"ON 1\rL 4\r")
        bench.axis("d").set("room_degC", 30)
        bench.device("d").reset()
        with bench.fault("byte_flip", "d", rate=0.3):
            asked(bench, b"ON 1\rL 5\rL?\rH?\r" * 5, 1000)
        heard.append(bench.port("d").timeline)
        assert replay(log.getvalue().splitlines(keepends=True)).difference() is None
    assert heard[0] == heard[1]


def test_faults_of_the_line_lose_commands_and_answers(made: Made) -> None:
    bench = made(METER)
    with bench.fault("byte_drop", "d", rate=1):
        assert asked(bench, b"ON 1\r") == b""
    assert bench.axis("d").snapshot().out == 1
    with bench.fault("byte_drop", "d", rate=1, towards="board"):
        assert asked(bench, b"ON 0\r") == b""
    assert bench.axis("d").snapshot().out == 1
    assert asked(bench, b"\rL?\r") == b"0.0 0.00\r\n"


SCPI = """
scpi: true
queue: 2
answers_end_with: LF
variables:
  level_V: {unit: V, minimum: 1, maximum: 10, value: 2, many: 2, about: level}
  out: {type: switch, about: output}
commands:
  - {asks: "*IDN?", answers: "ACME,1"}
  - {asks: "[SOURce{n}:]VOLTage {level_V[n]}"}
  - {asks: "SOURce{n}:VOLTage?", answers: "{level_V[n]:.2f}"}
  - {asks: "OUTPut[:STATe] {out}", when: "level_V[1] > 2"}
  - {asks: "OUTPut[:STATe]?", answers: "{out}"}
"""


def test_scpi(made: Made) -> None:
    bench = made(SCPI)
    assert asked(bench, b"*idn?\n") == b"ACME,1\n"
    assert asked(bench, b"SOUR2:VOLT 5;VOLT?;:source1:voltage?\n") == b"5.00;2.00\n"
    assert asked(bench, b"OUTP ON;OUTP?\n") == b"0\n"
    assert asked(bench, b"SOUR1:VOLT 2500 mV;:OUTP ON;:OUTP:STAT?\n") == b"1\n"
    assert asked(bench, b"SOUR3:VOLT 2;:SYST:ERR?;ERR?\n") == (
        b'-221,"Settings conflict";-222,"Data out of range"\n'
    )
    assert asked(bench, b"A;B;:C;SYST:ERR?;:SYST:ERR:NEXT?;:SYST:ERR?\n") == (
        b'-113,"Undefined header";-350,"Queue overflow";0,"No error"\n'
    )
    assert asked(bench, b"A\n*CLS\nSOUR:VOLT x;:SYST:ERR?\n") == b'-104,"Data type error"\n'
    assert asked(bench, b"SOUR1:VOLT MAX;VOLT?;VOLT DEF;VOLT?\n") == b"10.00;2.00\n"
    assert bench.axis("d").snapshot().level2_V == 5.0


def test_bytes_with_an_address_and_a_check_sum(made: Made) -> None:
    bench = made(
        """
encoding: hex
prefix: "{=address}"
answer_prefix: "{address}"
command_bytes: 6
checksum: {kind: crc16, form: bytes}
variables:
  address: {type: whole, value: 7, minimum: 1, maximum: 250, about: address on the line}
  count: {type: whole, minimum: 0, maximum: 65535, about: count}
commands:
  - {asks: "06 {count:2}", answers: "06 {count:2}"}
  - {asks: "03 00 00", answers: "03 {count:2le}"}
""",
        fields={"address": 3},
    )
    # Sums: CRC-16 of Modbus by a table of another make.
    assert asked(bench, bytes.fromhex("030601028b28")) == b""
    good = bytes.fromhex("03060102")
    good += crc16(good)
    assert asked(bench, good) == good
    other = bytes.fromhex("04060103")
    assert asked(bench, other + crc16(other)) == b""
    ask = bytes.fromhex("03030000")
    answer = bytes.fromhex("03030201")
    assert asked(bench, ask + crc16(ask)) == answer + crc16(answer)


def crc16(data: bytes) -> bytes:
    """CRC-16 of Modbus, by polynomial division from the high end of reversed bits."""
    register = 0xFFFF
    for byte in data:
        register ^= byte
        for _ in range(8):
            register = (register >> 1) ^ (0xA001 if register & 1 else 0)
    return register.to_bytes(2, "little")


def test_silence_ends_a_command_and_messages_come_by_themselves(made: Made) -> None:
    bench = made(
        """
ends_after_ms: 20
answers_end_with: ""
echo: true
ready_after_ms: 50
greeting: "READY;"
variables:
  n1: {type: whole, minimum: 0, maximum: 99, about: count}
  logs: {type: switch, about: it logs}
commands:
  - {asks: "VSET{n1}", answers: "={n1};"}
  - {asks: "LOG{logs}"}
messages:
  - {every_ms: 100, says: "#{n1};", when: logs}
"""
    )
    bench.run(ms=60)
    assert bench.port("d").read() == b"READY;"
    assert asked(bench, b"VSET12") == b"VSET12=12;"
    assert asked(bench, b"VSET") == b"VSET"
    assert asked(bench, b"LOG1", 380) == b"LOG1#12;#12;#12;"


def test_a_line_that_is_too_long_is_unknown(made: Made) -> None:
    bench = made('longest: 8\nerrors: {unknown: "?"}\ncommands: [{asks: "A", answers: "a"}]', baud=115200)
    assert asked(bench, b"A" * 3000 + b"\rA\r", 1000) == b"?\r\na\r\n"


def test_it_passes_the_checks_of_all_boards(made: Made, tmp_path: Path) -> None:
    made(METER)
    check_profile(tmp_path / "meter")


LINE = """
prefix: "#{=address:02d}"
answer_prefix: "!{address:02d}"
answer_after_ms: 3
checksum: {kind: xor}
variables:
  address: {type: whole, value: 1, minimum: 1, maximum: 99, kept: true, about: address}
  count: {type: whole, minimum: 0, maximum: 999, about: count}
commands:
  - {asks: "C?", answers: "{count:03d}"}
  - {asks: "C{count}"}
  - {asks: "A{address:02d}", answers: OK}
"""


def test_boards_with_addresses_share_a_line(made: Made, tmp_path: Path) -> None:
    made(LINE)
    meters = {"a": {"profile": "meter"}, "b": {"profile": "meter", "fields": {"address": 2}}}
    segment = {"stations": ["a.main", "b.main"], "taps": {"master": {"port": "memory"}}}
    with Bench(
        {"bench": "l", "profile_path": [str(tmp_path)], "devices": meters, "segments": {"bus": segment}}
    ) as bench:
        tap = bench.tap("bus.master")
        said = []
        for text in ("#01C7", "#02C8", "#01C?", "#02C?", "#03C?", "#02A05", "#05C?"):
            tap.write(f"{text}{reduce(xor, text.encode()):02X}\r".encode())
            bench.run(ms=60)
            said.append(tap.read())
        tap.write(b"#01C?00\r")
        bench.run(ms=60)
        assert tap.read() == b""
    assert said == [b"", b"", b"!0100717\r\n", b"!020081B\r\n", b"", b"!05OK20\r\n", b"!050081C\r\n"]
