"""Damaged, foreign and forged logs: replayed, or refused with a sentence that says where.

``HIL_FUZZ`` sets how many mutated logs are tried (400; ``make fuzz``: 100,000), ``HIL_FUZZ_SEED`` where they
start.
"""

import io
import json
import os
import random
import re
from copy import deepcopy
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from hil.compose import bench_runtime, find_catalogue, start_memories
from hil.compose.replay import MemoryOptions, Replayed, replay_log
from hil.config import ConfigError, from_dict
from hil.sim.bench import BenchHooks, BenchRuntime
from hil.sim.given_fault import fault_refusal
from hil.sim.input_log import InputLogWriter
from hil.sim.inputs import (
    Bytes,
    Follow,
    InputLogError,
    Pin,
    Play,
    PulseTrain,
    Reset,
    ScriptEncoder,
    SetField,
)
from hil.sim.log_checks import without_checks
from hil.sim.log_reading import read_input_log
from hil.testing.memory_store import MemoryStore
from hil.vocab.path import PathPiece
from hil.vocab.time import NS_PER_MS, SimTimeNs
from hil.wire.step_dir import generate

CASES = int(os.environ.get("HIL_FUZZ", "400"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
LONGEST_NS = 5_000_000_000
"""Time up to which a mutated log is run; later inputs are only read, because there are so many logs."""
CONFIG = {
    "bench": "b",
    "devices": {
        "m1": {"profile": "mechaduino", "port": "memory", "flash": {"table": "identity"}},
        "s1": {"profile": "sac", "port": "memory"},
        "s2": {"profile": "sac", "port": "memory"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"t": {"port": "memory"}}}},
}
EXTREMES: tuple[Any, ...] = (
    *(None, True, 0, -1, 1.5, 2**31, 2**53, 2**61, 2**62, 2**62 + 1, 2**63 - 1, 2**64 - 1, -(2**63)),
    *(1e308, 5e-324, "", "m1", "s1", "bus0", "bus0.t", "s1.network", "\0", "💥", "x" * 300, "00", "zz"),
    *([], {}, [[]], [[0, 0]], [[2**63 - 1, "00"]], [["a", 1]], [[0, "step", 1, 10**9, 2]], {"": ""}),
)
BAD = (b"NaN", b"-Infinity", b"1e999", b"9" * 401, b"9" * 5000, b'"\\ud800"', b"\xff", b"\0", b"01", b"\r")


@cache
def catalogue() -> Any:
    return find_catalogue({"memory": MemoryOptions})


def written() -> str:
    """A log with inputs of all kinds."""
    config = from_dict(CONFIG, catalogue())
    memories = start_memories(config, catalogue())
    text = io.StringIO()
    log = InputLogWriter(text, "hil test", CONFIG, memories)
    around = BenchHooks(log=log)
    runtime: BenchRuntime = bench_runtime(config, catalogue(), memories, MemoryStore(), around)
    m1, s1, tap = runtime.devices["m1"], runtime.devices["s1"], runtime.taps["bus0.t"]
    at_ms = 4600.0

    def later(by_ms: float) -> None:
        nonlocal at_ms
        at_ms += by_ms
        runtime.advance(SimTimeNs(round(at_ms * NS_PER_MS)))

    def fault(kind: str, target: str, **given: object) -> int:
        return runtime.inject(fault_refusal(kind, target, given))

    later(0)
    runtime.apply_to(s1, Bytes(b"m30v60\r"))
    runtime.apply_to(m1, Bytes(b"Z", 9600))
    later(5)
    runtime.apply_to(m1, Pin("D0", 1))
    runtime.apply_to(m1, SetField("load_torque_Nm", 0.01))
    runtime.apply_to(m1, ScriptEncoder(((0, 5), (10**9, 77)), True))
    runtime.apply_to(m1, ScriptEncoder((), False))
    runtime.apply_to(m1, PulseTrain(generate(20, 20_000)))
    runtime.do_verb(m1, "enable", m1.verbs["enable"].filled({}))
    later(5)
    runtime.do_verb(m1, "move_abs", m1.verbs["move_abs"].filled({"position_deg": 5.0}))
    runtime.apply_to(m1, Follow(0, (PathPiece(10**7, 1.0, 2.0), PathPiece(0, 1.02))))
    runtime.apply_to(m1, Follow(1, (PathPiece(10**7, 1.0, 2.0), PathPiece(0, 1.02)), is_joined=True))
    numbers = [
        fault("byte_flip", "m1", rate=0.01),
        fault("shaft_load", "s1", torque_Nm=0.01, for_s=0.01),
        fault("node_babble", "s2.network", every_ms=5, bytes=3),
        fault("byte_drop", "s1.network", rate=0.5),
    ]
    runtime.apply_to(tap, Bytes(b"\x02hello\x03\0"))
    runtime.apply_to(tap, Play(((0, "02"), (3_000_000, "0304"))))
    later(10)
    for number in numbers:
        if number in runtime.faults.active:
            runtime.clear_fault(number)
    runtime.apply_to(s1, Reset())
    later(10)
    runtime.apply_to(m1, Bytes(b"e"))
    later(30)
    log.end()
    return text.getvalue()


def unchecked(text: str) -> list[bytes]:
    """Lines of the log as version 2 had them: a change of it is not found by its checksum."""
    return [line.encode() for line in without_checks(text)]


class Mutations:
    """Mutations of a log."""

    def __init__(self, seed: int, text: str) -> None:
        self._chance = random.Random(seed)
        self._lines = text.encode().splitlines(keepends=True)

    def one(self) -> list[bytes]:
        chance, lines = self._chance, list(self._lines)
        for _ in range(chance.choice([1, 1, 1, 2, 3])):
            place = chance.choice([0, *range(len(lines))]) if lines else 0
            match chance.randrange(10) if lines else 0:
                case 0:
                    lines = lines[:place]
                case 1:
                    lines.insert(place, chance.choice(lines))
                case 2:
                    other = chance.randrange(len(lines))
                    lines[place], lines[other] = lines[other], lines[place]
                case 3:
                    del lines[place]
                case 4:
                    lines[place] = self._bytes(lines[place])
                case _:
                    lines[place] = self._values(lines[place])
        return lines

    def _bytes(self, line: bytes) -> bytes:
        chance, at = self._chance, self._chance.randrange(len(line) + 1)
        match chance.randrange(5):
            case 0:
                return line[:at] + bytes([chance.randrange(256)]) + line[at + 1 :]
            case 1:
                return line[:at] + line[at + chance.randrange(30) :]
            case 2:
                return line[:at] + chance.choice(BAD) + line[at:]
            case 3:
                opening, closing = chance.choice([(b"[", b"]"), (b'{"a":', b"}")])
                depth = chance.choice([1, 31, 990, 100_000])
                return line.replace(b":", b":" + opening * depth + b"1" + closing * depth + b",", 1)
            case _:
                return line.replace(b"1", chance.choice(BAD), 1)

    def _values(self, line: bytes) -> bytes:
        try:
            values = json.loads(line)
        except (ValueError, RecursionError):
            return line
        within, key = values, None
        while isinstance(within, dict | list) and within:
            outer, key = (
                within,
                self._chance.choice(list(within) if isinstance(within, dict) else range(len(within))),
            )
            within = within[key]
            if self._chance.random() < 0.3:
                break
        if key is None:
            return line
        match self._chance.randrange(4):
            case 0 if isinstance(outer, dict):
                del outer[key]
            case 1 if isinstance(within, int | float):
                outer[key] = within + self._chance.choice([1, -1, 10**9, 0.5, -(10**9)])
            case 2 if isinstance(outer, dict):
                outer[self._chance.choice(["more", "port", "later_ns", "sent"])] = self._extreme()
            case _:
                outer[key] = self._extreme()
        return json.dumps(values).encode() + b"\n"

    def _extreme(self) -> Any:
        return deepcopy(self._chance.choice(EXTREMES))


def replayed(lines: list[bytes]) -> Replayed:
    """Replay the first seconds of a log, as ``replay`` does."""
    log = read_input_log(lines, "some.log")
    early = [i for i, logged in enumerate(log.inputs) if logged.at_ns <= LONGEST_NS]
    sent = [each for each in log.sent if each.at_ns <= LONGEST_NS]
    return replay_log(
        replace(log, inputs=[log.inputs[i] for i in early], lines=[log.lines[i] for i in early], sent=sent)
    )


def test_the_log_itself_is_identical_again() -> None:
    lines = written().encode().splitlines(keepends=True)
    kinds = {json.loads(line).get("input") for line in lines}
    assert len(kinds) == 12, kinds  # and None, of what was sent
    assert replayed(lines).difference() is None


def test_a_log_that_is_cut_anywhere_is_never_different() -> None:
    text = written().encode()
    ends = [at + 1 for at, byte in enumerate(text) if byte == ord("\n")]
    chance = random.Random(SEED)
    for end in (*ends, *(chance.randrange(ends[0], len(text)) for _ in range(len(ends)))):
        again = replayed(text[:end].splitlines(keepends=True))
        assert again.difference() is None, end
        assert bool(again.logged.cut) == (end < len(text))
        assert ("up to where the log ends" in again.summary()) == (end < len(text))


def test_only_a_log_with_its_end_says_that_nothing_else_was_sent() -> None:
    lines = [line for line in unchecked(written()) if b'"device":"m1","sent":' not in line]
    assert "logged nothing, now" in str(replayed(lines).difference())
    assert replayed(lines[:-1]).difference() is None
    lines[0] = lines[0].replace(b'"version":2', b'"version":1')
    old = replayed(lines[:-1])
    assert old.difference() is None
    assert "logs of version 1 do not say" in old.summary()


def test_nothing_stands_behind_the_end() -> None:
    lines = written().encode().splitlines(keepends=True)
    with pytest.raises(
        InputLogError, match=f"some.log:{len(lines) + 1}: this is a line behind the log's end"
    ):
        replayed([*lines, lines[-2]])


def test_a_fault_on_a_line_with_nobody_on_it() -> None:
    config = from_dict(CONFIG | {"segments": {"bus0": {}}}, catalogue())
    runtime = bench_runtime(config, catalogue(), {}, MemoryStore())
    number = runtime.inject(fault_refusal("wire_noise", "bus0", {"rate": 0.5}))
    runtime.advance(SimTimeNs(10**6))
    runtime.clear_fault(number)


@pytest.mark.long
def test_any_log_is_replayed_or_refused_with_its_place() -> None:
    mutations = Mutations(SEED, b"".join(unchecked(written())).decode())
    refused = 0
    for case in range(CASES):
        lines = mutations.one()
        try:
            replayed(lines).difference()
        except InputLogError as error:
            refused += 1
            if not re.fullmatch(r"some\.log:\d+: .{,1200}; .{,200}", str(error)):
                raise AssertionError(f"case {case}: {error}") from None
        except ConfigError:
            refused += 1
        except BaseException as error:
            error.add_note(f"case {case} of seed {SEED}")
            raise
    assert CASES * 0.3 < refused < CASES * 0.95


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (
            ('"at_ns":4600000000', '"at_ns":9223372036854775807'),
            "at_ns: write a whole number from 0 to 4611686018",
        ),
        (('"at_ns":4605000000', '"at_ns":1000000000'), "time goes back: 1000000000 ns, and m1 was at "),
        (
            ('"device":"m1","input":"pin"', '"device":"m9","input":"pin"'),
            "there is no device 'm9'; there are m1, ",
        ),
        (('"pin":"D0"', '"pin":"D9"'), "m1: its inputs are "),
        (('"field":"load_torque_Nm"', '"field":"at_ns"'), "m1: 'at_ns' is no field that can be set"),
        (('"input":"pin"', '"input":"needle"'), "there is no input 'needle'; there are bytes, play"),
        (('"verb":"move_abs"', '"verb":"fly"'), "m1: a mechaduino has no verb 'fly'; it has "),
        (
            ('["position_deg",5.0]', '["position_deg","far"]'),
            'move_abs: position_deg: "far" is no number',
        ),
        (
            ('"kind":"byte_flip"', '"kind":"byte_eat"'),
            "there is no fault 'byte_eat'; did you mean \"byte_delay\"? kinds are ",
        ),
        (('["rate",0.01]', '["rate",7]'), "rate: 7 is too large; write 0 to 1"),
        (('"client_baud":9600', '"client_baud":0'), "m1: client_baud: write null, or 1 to 4294967295"),
        (
            ('"client_baud":9600', '"client_baud":9600,"client_format":"9E1"'),
            "m1: client_format: write one as in 7E1",
        ),
        (
            ('"version":2', '"version":99'),
            "the log has version 99, of hil test; this program reads 1, 2 and 3",
        ),
        (('"format":"hil-inputs"', '"format":"x"'), "this is no recording"),
    ],
)
def test_what_is_wrong_is_said(change: tuple[str, str], why: str) -> None:
    text = b"".join(unchecked(written())).decode()
    assert change[0] in text
    with pytest.raises(InputLogError) as caught:
        replayed([line.encode() for line in text.replace(*change, 1).splitlines(keepends=True)])
    assert why in str(caught.value)
    number = 1 + text[: text.index(change[0])].count("\n")
    assert str(caught.value).startswith(f"some.log:{number}: ")
