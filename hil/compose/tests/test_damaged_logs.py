"""Logs that were cut anywhere, or damaged: what is whole is read, and the rest is told."""

import gzip
import io
import json
import random
import zlib
from pathlib import Path

import pytest

from hil.compose.log_lines import LogLines, read_log
from hil.compose.replay import replay
from hil.sim.bench import BenchHooks
from hil.sim.input_log import InputLog, InputLogWriter
from hil.sim.inputs import InputLogError
from hil.sim.log_reading import KILLED, LogReading
from hil.testing import Bench

SEED = 11
CONFIG = {
    "bench": "b",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {}},
        "s1": {"profile": "sac", "flash": {}},
    },
}


@pytest.fixture(scope="module")
def text() -> bytes:
    """A log of eight seconds, in each of which a board is typed at; a fault begins in the fifth."""
    file = io.StringIO()
    log = InputLogWriter(file, "test", CONFIG, {})
    with Bench(CONFIG, around=BenchHooks(log=log)) as bench:
        for second in range(8):
            bench.port("m1").write(b"yp")
            bench.port("s1").write(b"vd\r")
            if second == 4:
                bench.fault("byte_flip", "m1", rate=0.001)
            bench.run(1000)
    log.end()
    return file.getvalue().encode()


def lines_of(text: bytes) -> list[bytes]:
    return text.splitlines(keepends=True)


def checks_of(text: bytes) -> list[int]:
    """Indices of the lines with a check."""
    return [index for index, line in enumerate(lines_of(text)) if b'"check":' in line]


def read(path: Path, data: bytes) -> InputLog:
    path.write_bytes(data)
    return read_log(path, strict=False)


def content(log: InputLog) -> list[object]:
    return [*log.inputs, *log.sent]


def test_a_check_stands_behind_each_second_with_lines(text: bytes) -> None:
    lines = lines_of(text)
    seconds, crc = [], 0
    for number, line in enumerate(lines):
        values = json.loads(line)
        if "check" in values:
            seconds.append(values["at_ns"] // 10**9)
            assert (values["check"], values["lines"]) == (crc, number)
        crc = zlib.crc32(line, crc)
    assert seconds == sorted(seconds)
    assert len(seconds) >= 8
    last = json.loads(lines[-1])
    assert (last["end"], last["why"], last["faults"]) == (True, "stopped", {"byte_flip": 1})
    assert last["inputs"] == sum(b'"input":' in line for line in lines)


def test_a_log_cut_anywhere_is_whole_up_to_there(tmp_path: Path, text: bytes) -> None:
    path, whole = tmp_path / "cut.hil", read(tmp_path / "whole.hil", text)
    assert (whole.cut, whole.damage, whole.why) == ("", "", "stopped")
    header = len(lines_of(text)[0])
    chance = random.Random(SEED)
    for end in sorted(chance.sample(range(header, len(text) - 1), 200)):
        log = read(path, text[:end])
        assert (log.cut, log.damage) == (KILLED, "")
        assert log.inputs == whole.inputs[: len(log.inputs)]
        assert list(log.sent) == list(whole.sent)[: len(log.sent)]
        entries = [line for line in lines_of(text[:end]) if line.endswith(b"}\n") and b'"device":' in line]
        assert len(content(log)) == len(entries)
    with pytest.raises(InputLogError, match="no whole line"):
        read(path, text[: header - 1])


def test_a_packed_log_cut_anywhere_is_whole_up_to_its_last_flush(tmp_path: Path, text: bytes) -> None:
    packer, packed, flushed = zlib.compressobj(2, wbits=31), b"", []
    for line in lines_of(text):
        packed += packer.compress(line) + packer.flush(zlib.Z_SYNC_FLUSH)
        flushed.append(len(packed))
    packed += packer.flush()
    whole = read(tmp_path / "whole.hil.gz", packed)
    assert (whole.cut, whole.inputs) == ("", read(tmp_path / "plain.hil", text).inputs)
    for end in random.Random(SEED).sample(range(flushed[0], flushed[-1]), 100):
        log = read(tmp_path / "cut.hil.gz", packed[:end])
        assert (log.cut, log.damage) == (KILLED, "")
        there = [line for line, at in zip(lines_of(text), flushed, strict=True) if at <= end]
        assert len(log.inputs) >= sum(b'"input":' in line for line in there)
    path = tmp_path / "bad.hil.gz"
    damaged = bytearray(packed)
    damaged[len(packed) // 2 : len(packed) // 2 + 40] = bytes(40)
    log = read(path, bytes(damaged))
    assert log.damage
    assert log.inputs == whole.inputs[: len(log.inputs)]
    with pytest.raises(InputLogError):
        read_log(path)


@pytest.mark.parametrize("part", range(1, 7))
def test_damage_is_found_and_what_is_confirmed_before_it_stays(
    tmp_path: Path, text: bytes, part: int
) -> None:
    lines, checks = lines_of(text), checks_of(text)
    whole, path = read(tmp_path / "whole.hil", text), tmp_path / "damaged.hil"
    first, last = checks[part - 1], checks[part]
    assert last - first > 2
    chance = random.Random(SEED + part)
    target = chance.randrange(first + 1, last)
    flipped = bytearray(lines[target])
    place = chance.randrange(len(flipped) - 1)
    flipped[place] ^= 1 << chance.randrange(5)
    for damaged in (
        [*lines[:target], bytes(flipped), *lines[target + 1 :]],
        [*lines[:target], *lines[target + 1 :]],
        [*lines[: target + 1], *lines[target:]],
        [*lines[:target], lines[target + 1], lines[target], *lines[target + 2 :]],
        [*lines[: first + 1], *lines[last + 1 :]],  # a whole second is missing, with its check
        [*lines[: last + 1], *lines[last:]],
        [*lines[:target], bytes(100) + b"\n", *lines[target:]],
    ):
        log = read(path, b"".join(damaged))
        confirmed = [line for line in lines[: first + 1] if b'"input":' in line]
        more = [line for line in lines[: last + 1] if b'"input":' in line]
        assert len(log.inputs) in (len(confirmed), len(more))
        assert log.inputs == whole.inputs[: len(log.inputs)]
        assert list(log.sent) == list(whole.sent)[: len(log.sent)]
        at_s = json.loads(lines[first if len(log.inputs) == len(confirmed) else last])["at_ns"] / 1e9
        number = (first if len(log.inputs) == len(confirmed) else last) + 2
        assert log.damage.endswith(f"; all from line {number} on, after {at_s:.12g} s, is left out")
        assert replay(path, strict=False).difference() is None
        with pytest.raises(InputLogError):
            replay(path)


def test_a_log_without_checks_is_read_up_to_the_line_that_is_wrong(tmp_path: Path, text: bytes) -> None:
    lines = [line for line in lines_of(text) if b'"check":' not in line]
    lines[0] = lines[0].replace(b'"version":3', b'"version":2')
    log = read(tmp_path / "old.hil", b"".join([*lines[:9], b"{}\n", *lines[9:]]))
    assert log.damage.startswith(f"{tmp_path}/old.hil:10: ")
    assert "; all from line 10 on, after " in log.damage
    assert len(content(log)) == 8


def test_a_log_is_read_while_it_grows(tmp_path: Path, text: bytes) -> None:
    path = tmp_path / "grows.hil"
    reading = LogReading(str(path))
    with path.open("wb") as file, LogLines(path) as lines:
        for at in range(0, len(text), 777):
            file.write(text[at : at + 777])
            file.flush()
            for line in lines.more():
                reading.add(line)
            if b"\n" in text[: at + 777]:
                assert len(reading.log().inputs) == text[: at + 777].count(b'"input":') - (
                    b'"input":' in text[: at + 777].rpartition(b"\n")[2]
                )
    assert (reading.log().cut, reading.log().why) == ("", "stopped")


def test_members_of_gzip_follow_each_other(tmp_path: Path, text: bytes) -> None:
    packed = b"".join(map(gzip.compress, lines_of(text)))
    assert read(tmp_path / "members.hil.gz", packed).inputs == read(tmp_path / "plain.hil", text).inputs
