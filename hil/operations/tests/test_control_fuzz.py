"""Random requests at the control socket: each gets an answer, and none a traceback in the log.

``HIL_FUZZ`` sets how many are tried (3,000; ``make fuzz``: 100,000), ``HIL_FUZZ_SEED`` where they start.
"""

import asyncio
import json
import logging
import os
import random
import socket
from collections.abc import Awaitable, Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from hil.compose import find_catalogue
from hil.config import parse
from hil.daemon import Daemon, Serving
from hil.operations.control_socket import ClaimedSocket, ControlServer
from hil.operations.table import OPERATIONS
from hil.sim.inputs import MAX_BURSTS
from hil.vocab.address import CONTROL_SOCKET
from hil.vocab.desk_protocol import LOCAL, Encoded
from hil.vocab.faults import FAULT_KINDS
from hil.vocab.verbs import CODES, VerbRefused
from hil.wire.step_dir import MAX_ROWS, generate

CASES = int(os.environ.get("HIL_FUZZ", "3000"))
SEED = int(os.environ.get("HIL_FUZZ_SEED", "1"))
SERVO = {"profile": "mechaduino", "flash": {"table": "identity"}}
BENCH = {
    "bench": "fuzz",
    "devices": {
        "m1": SERVO,
        "m2": {**SERVO, "plant": "full", "baud": 57600},
        "s1": {"profile": "sac"},
        "s2": {"profile": "sac"},
        "real": {"profile": "mechaduino", "at": "/dev/null/nothing"},
    },
    "segments": {"bus0": {"stations": ["s1", "s2"], "taps": {"t": {"port": "pty"}}}},
}
ASKED = [
    operation
    for operation in OPERATIONS.values()
    if operation.answer is not None and operation.name not in ("stop", "reload", "wait")
]
EXTREMES: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 2, 1.5, -0.0, 1e308, 5e-324, 2**31, 2**53, 2**62, 2**63 - 1, 2**64 - 1),
    *(-(2**63), "", " ", "m1", "\0", "\x1b[2J", "\uffff", "💥", "x" * 300, "../..", "%s", "{}", "all"),
    *([], {}, [[]], [{}], {"": ""}, [None], [0, "step", 1, 0, 0], "00" * 70_000, "NaN"),
)
BAD = (
    b"NaN",
    b"Infinity",
    b"-Infinity",
    b"1e999",
    b"9" * 401,
    b"9" * 5000,
    b'"\\ud800"',
    b"\xff",
    b"\0",
    b"01",
)
RUNS = (
    "run: r\naxes: {m1: {}}\nsteps: [{dwell_s: 0.01}]\n",
    "run: r\naxes: {m1: {}}\nsteps: [{move: {m1: 10}}]\n",
    "run: r\naxes: {real: {}}\nsteps: [{move: {real: 10}}]\n",
    *("", "{}", "[", "run: r", "&a [*a]", "a: &a {b: *a}", "!!python/object:os.system x", "\0", "\ud83d"[:0]),
    *("[" * 5000, "{a: " * 5000, "- " * 5000, "run: " + "9" * 5000, "? " * 5000, "&x " * 500, "run: !!int a"),
    "run: r\naxes: {m1: {}}\nsteps: [{dwell_s: .nan}, {dwell_s: .inf}, {dwell_s: 1e400}, {dwell_s: "
    + "9" * 401,
)
NAMES = ("m1", "m2", "s1", "s2", "real", "s1.network", "bus0", "bus0.t", "m9", "m1.network", "t", "bus0.s1")


class Grammar:
    """Requests that mean something, mostly."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance

    def value(self, verb: str, argument: str) -> Any:
        chance = self.chance
        match argument:
            case "device" | "target" | "tap":
                return chance.choice(NAMES)
            case "ports":
                return chance.sample(NAMES, chance.randrange(3))
            case "pin":
                return chance.choice(["D0", "D1", "step", "enable", "sync", "Estop", "RST", "EnA"])
            case "on":
                return chance.choice(["", *NAMES])
            case "level" | "check" | "fresh":
                return chance.randrange(2) if argument == "level" else chance.random() < 0.5
            case "field":
                return chance.choice(["load_torque_Nm", "diaagc", "errfl", "r", "at_ns"])
            case "value":
                return chance.choice([0, 0.1, -3, 1e5, 999999.9, 1e6, 40000, *filter(_is_number, EXTREMES)])
            case "data":
                return bytes(chance.choices(b"xvmqpyrske0123456789.\r\n", k=chance.randrange(9))).hex()
            case "train":
                rows = [list(vars(edges).values()) for edges in generate(chance.randint(1, 50), 20_000, 1e6)]
                return [[at_ns, pin, level, steps, ns] for at_ns, pin, level, steps, ns in rows]
            case "signals":
                return chance.choice([[], ["r"], ["r", "yw"], ["speed_rpm"], ["at_ns"], ["nothing"]])
            case "interval_ns":
                return chance.choice(
                    [10**6, 10**6 + 1, 50_000, 49_999, 10**9, 2**63, 2**63 - 1, 3600 * 10**9]
                )
            case "watch" | "number":
                return chance.randrange(20)
            case "fault":
                return chance.choice([*FAULT_KINDS, "nothing"])
            case "parameters" if verb == "inject":
                names = (
                    "rate",
                    "seed",
                    "start_s",
                    "for_s",
                    "counts",
                    "torque_Nm",
                    "every_ms",
                    "bytes",
                    "coil",
                )
                return {name: self.extreme() for name in chance.sample(names, chance.randrange(4))}
            case "parameters":
                names = ("position_deg", "velocity_rpm", "text", "pin", "level", "pKp", "at_ns", "steps")
                return {name: self.extreme() for name in chance.sample(names, chance.randrange(3))}
            case "bursts":
                return [[i * 10**6, "04" * chance.randrange(5)] for i in range(chance.randrange(4))]
            case "name" if verb == "do":
                return chance.choice(
                    ["enable", "move_abs", "stop", "type", "pin", "reset", "velocity", "jump"]
                )
            case "name" | "how":
                return chance.choice(["r", "", "nothing", "grace", "prejudice"])
            case "text":
                return chance.choice(RUNS)
            case _:
                return chance.choice(["a.yaml", ""])

    def extreme(self) -> Any:
        chosen = self.chance.choice(EXTREMES) if self.chance.random() < 0.6 else self.chance.random() * 10
        return deepcopy(chosen)

    def request(self) -> bytes:
        chance = self.chance
        operation = chance.choice(ASKED)
        request: dict[str, Any] = {"verb": operation.name}
        for argument in operation.arguments:
            request[argument] = self.value(operation.name, argument)
        while chance.random() < 0.4:
            self.spoil(request)
        line = json.dumps(request, ensure_ascii=chance.random() < 0.5).encode()
        while chance.random() < 0.25:
            line = self.spoil_bytes(line)
        return line.replace(b"\n", b" ") + b"\n"

    def spoil(self, request: dict[str, Any]) -> None:
        chance, name = self.chance, self.chance.choice(list(request) or [""])
        what = chance.randrange(6)
        if what == 0:
            request.pop(name, None)
        elif what == 1:
            request[chance.choice(["verb", "more", "device", ""])] = self.extreme()
        elif what == 2 and isinstance(request.get(name), list) and request[name]:
            rows = request[name]
            row = chance.randrange(len(rows))
            if isinstance(rows[row], list) and rows[row] and chance.random() < 0.8:
                rows[row][chance.randrange(len(rows[row]))] = self.extreme()
            else:
                rows[row] = self.extreme()
        else:
            request[name] = self.extreme()

    def spoil_bytes(self, line: bytes) -> bytes:
        chance, at = self.chance, self.chance.randrange(len(line) + 1)
        match chance.randrange(6):
            case 0:
                return line[:at] + bytes([chance.randrange(256)]) + line[at + 1 :]
            case 1:
                return line[:at] + line[at + chance.randrange(20) :]
            case 2:
                return line[:at] + chance.choice(BAD) + line[at:]
            case 3:
                return line.replace(chance.choice([b"1", b"0", b'"m1"', b"{}", b"[]"]), chance.choice(BAD), 1)
            case 4:
                opening, closing = chance.choice([(b"[", b"]"), (b'{"a":', b"}")])
                depth = chance.choice([1, 31, 33, 990, 100_000])
                return line.replace(b":", b":" + opening * depth + b"1" + closing * depth + b",", 1)
            case _:
                return line[:at] + line + line[at:]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)


def in_a_daemon(folder: Path, use: Callable[[Serving], Awaitable[None]]) -> None:
    """Run what is awaited with a daemon that has started."""

    async def main() -> None:
        config = parse(json.dumps(BENCH), "fuzz.yaml", find_catalogue())
        daemon = Daemon(
            config, config_folder=folder, runtime_base=folder / "run", state_base=folder / "state"
        )
        started: asyncio.Future[Serving] = asyncio.get_running_loop().create_future()
        running = asyncio.create_task(daemon.run(started.set_result))
        await asyncio.wait({running, started}, return_when=asyncio.FIRST_COMPLETED, timeout=30)
        try:
            assert started.done()
            await use(started.result())
        finally:
            daemon.stop()
            await running

    asyncio.run(main())


def check(answer: dict[str, Any], line: bytes) -> None:
    assert answer["ok"] in (True, False), line[:300]
    if not answer["ok"]:
        assert isinstance(answer["error"], str)
        assert answer["error"], line[:300]
        assert len(answer["error"]) <= 4000, line[:300]
        assert answer["code"] in CODES, line[:300]


@pytest.mark.thorough
@pytest.mark.long
def test_every_request_gets_an_answer(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    grammar = Grammar(random.Random(SEED))
    accepted = 0

    async def use(serving: Serving) -> None:
        nonlocal accepted
        claimed = ClaimedSocket(tmp_path / "unused", "fuzz")
        server = ControlServer(serving.desk, claimed)
        for case in range(CASES):
            line = grammar.request()
            answer = await server.answer(line)
            answer.pop("carry", None)
            if isinstance(result := answer.get("result"), Encoded):
                answer["result"] = json.loads(b"".join(result.parts))
            check(answer, line)
            assert json.dumps(answer)
            assert not caplog.records or not caplog.records[-1].exc_info, line[:300]
            accepted += answer["ok"]
            if case % 50 == 49:
                for row in serving.live.faults.listed():
                    serving.live.faults.clear(row["number"])
                for name in ("m1", "m2", "s1", "s2"):
                    await server.answer(json.dumps({"verb": "reset", "device": name}).encode())
                await asyncio.sleep(0.001)
        await server.close()
        claimed.release()

    with caplog.at_level(logging.ERROR):
        in_a_daemon(tmp_path, use)
    assert [record for record in caplog.records if record.exc_info] == []
    assert CASES * 0.1 < accepted < CASES * 0.9, "some mean something, and some do not"


LONG = {
    "a train": {
        "verb": "drive",
        "device": "m1",
        "train": [[i * 10**4, "step", 0, 1, 10**4] for i in range(50_000)],
    },
    "bursts": {"verb": "play", "tap": "bus0.t", "bursts": [[10**15 + i, "04"] for i in range(50_000)]},
    "a train of nobody": {"verb": "drive", "device": "m9", "train": [[0, "dir", 0, 0, 0]] * 50_000},
    "no train": {"verb": "drive", "device": "m1", "train": [[9 - i, "dir", 0, 0, 0] for i in range(10_000)]},
    "nothing": [0] * 50_000,
}


@pytest.mark.parametrize("kind", LONG)
def test_nobody_waits_for_a_long_request_to_be_read(tmp_path: Path, kind: str) -> None:
    answered = []

    async def use(serving: Serving) -> None:
        claimed = ClaimedSocket(tmp_path / "unused", "fuzz")
        server = ControlServer(serving.desk, claimed)

        async def ask(name: str, request: object) -> None:
            answer = await server.answer(json.dumps(request).encode())
            answered.append((name, answer["ok"]))

        await asyncio.gather(ask("long", LONG[kind]), ask("short", {"verb": "health"}))
        await server.close()
        claimed.release()

    in_a_daemon(tmp_path, use)
    assert answered == [("short", True), ("long", kind in ("a train", "bursts"))]


@pytest.mark.parametrize(
    ("operation", "target", "given", "told"),
    [
        ("drive", "m1", {"train": [[0, "dir", 0, 0, 0]] * (MAX_ROWS + 1)}, "at most 200,000 rows"),
        ("play", "bus0.t", {"bursts": [[0, ""]] * (MAX_BURSTS + 1)}, "at most 50,000 rows"),
    ],
    ids=["drive", "play"],
)
def test_more_rows_than_can_be_taken_at_once_are_refused(
    tmp_path: Path, operation: str, target: str, given: dict[str, Any], told: str
) -> None:
    async def use(serving: Serving) -> None:
        with pytest.raises(VerbRefused, match=told):
            await serving.desk.ask(LOCAL, operation, target, given)

    in_a_daemon(tmp_path, use)


def test_a_connection_outlives_whatever_was_no_request(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    grammar = Grammar(random.Random(SEED + 1))
    lines = [line for _ in range(300) if b"capture" not in (line := grammar.request())]
    lines += [b"\n", b"null\n", b"[" * 100_000 + b"\n", b"x" * (17 << 20) + b"\n", b"{}\n", b"\0\n"]
    answers: list[bytes] = []

    def talk(path: Path) -> None:
        with socket.socket(socket.AF_UNIX) as client:
            client.settimeout(60)
            client.connect(str(path))
            replies = client.makefile("rb")
            for line in lines:
                client.sendall(line)
                answers.append(replies.readline())
            client.sendall(b'{"verb": "list"}')  # no end: the client hangs up
            client.shutdown(socket.SHUT_WR)
            answers.append(replies.readline())
            assert replies.readline() == b""

    async def use(serving: Serving) -> None:
        await asyncio.to_thread(talk, tmp_path / "run" / "fuzz" / CONTROL_SOCKET)

    with caplog.at_level(logging.ERROR):
        in_a_daemon(tmp_path, use)
    assert len(answers) == len(lines) + 1
    for line, answer in zip([*lines, b""], answers, strict=True):
        check(json.loads(answer), line)
    refusals = [json.loads(answer).get("error", "") for answer in answers]
    assert refusals[-4] == "not a request: longer than 12582912 bytes"
    assert refusals[-5].startswith("not a request: more than 32 objects and arrays in each other")
    assert json.loads(answers[-1])["ok"]
    assert [record for record in caplog.records if record.exc_info] == []
