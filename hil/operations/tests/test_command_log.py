"""Tests of the log of commands: a line for each command, streams in sums, and the proof that came with it."""

import base64
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from hil.operations.command_log import EACH, KINDS, CommandLog
from hil.operations.event_log import DONE, NOT_ENDED, REFUSED, Wish
from hil.operations.table import Asked
from hil.vocab.desk_protocol import LOCAL, Proof, Source
from hil.vocab.verbs import Role, VerbRefused
from hil.wire.command_lines import checked_lines

ANN = Source("ann", Role.OPERATOR, via="zenoh")


class Rig:
    """Log with a clock of its own."""

    def __init__(self) -> None:
        self.now_ns = 0
        self.lines: list[str] = []
        self.calls: list[tuple[int, Callable[[], None]]] = []
        self.log = CommandLog("b", lambda: (self.now_ns, 10**18 + self.now_ns), self.later, self)
        self.log.begin()

    def later(self, after_s: float, call: Callable[[], None]) -> None:
        self.calls.append((self.now_ns + round(after_s * 1e9), call))

    def keep(self, line: str, wall_ns: int) -> None:
        self.lines.append(line)

    def go(self, ms: int) -> None:
        end_ns = self.now_ns + ms * 1_000_000
        while self.calls and self.calls[0][0] <= end_ns:
            self.now_ns, call = self.calls.pop(0)
            call()
        self.now_ns = end_ns

    @property
    def rows(self) -> list[dict[str, Any]]:
        checked = list(checked_lines(self.lines))
        assert not any(line.wrong for line in checked)
        return [dict(line.row) for line in checked[1:]]


def wish(source: Source = ANN, name: str = "move_abs", *, streams: bool = False, **given: Any) -> Wish:
    return Wish(Asked(source, "m1"), "do", name, given, streams)


def test_a_command_has_user_door_role_and_outcome() -> None:
    rig = Rig()
    rig.log.put(wish(position_deg=90, program="x" * 100, angle=float("nan")), DONE)
    rig.log.put(
        wish(replace(LOCAL, user="eve"), "enable"), REFUSED, VerbRefused("not_now", "calibrate it\nfirst")
    )
    rig.log.put(wish(), NOT_ENDED)
    first, second, third = rig.rows
    assert [first[key] for key in ("number", "user", "door", "role", "operation", "target")] == [
        *(1, "ann", "zenoh", "operator", "move_abs", "m1")
    ]
    assert (first["given"], first["outcome"]) == ({"position_deg": 90}, "done")
    assert (second["user"], second["door"]) == ("eve", "control socket")
    assert (second["outcome"], second["code"], second["why"]) == ("refused", "not_now", "calibrate it")
    assert third["outcome"] == "not ended"


def test_a_stream_is_told_at_once_and_then_once_a_second() -> None:
    rig = Rig()
    for value in range(250):
        rig.log.put(wish(name="set_point", streams=True, value=value), DONE)
        rig.go(10)
    rig.go(5000)
    assert [(row.get("count", 1), row["given"]["value"]) for row in rig.rows] == [
        *((1, 0), (99, 99), (100, 199), (50, 249))
    ]
    assert not rig.calls
    rig.log.put(wish(name="set_point", streams=True, value=7), DONE)
    assert rig.rows[-1]["given"] == {"value": 7}


def test_a_flood_is_summed_in_bounded_memory_and_nothing_is_lost() -> None:
    rig = Rig()
    for number in range(3000):
        rig.log.put(Wish(Asked(ANN, f"x{number}"), "do", "move_abs", {}), DONE)
    rig.go(2000)
    assert len(rig.rows) == EACH + KINDS + 1
    assert sum(row.get("count", 1) for row in rig.rows) == 3000


def test_the_signature_is_kept_with_what_it_signs() -> None:
    rig = Rig()
    proof = Proof("hil/b/axis/m1/cmd/move_abs", b"{}", b'{"user":"ann"}')
    rig.log.put(wish(Source("ann", Role.OPERATOR, via="zenoh", proof=proof)), DONE)
    told = rig.rows[0]["proof"]
    assert (told["key"], json.loads(told["attachment"])) == (proof.key, {"user": "ann"})
    assert base64.b64decode(told["payload_base64"]) == b"{}"
    long = Proof("hil/b/run/submit", b"x" * 100_000, b"{}")
    rig.log.put(wish(Source("ann", Role.OPERATOR, via="zenoh", proof=long)), DONE)
    assert len(rig.rows[1]["proof"]["payload_sha256"]) == 64


def test_what_benches_say_twice_a_second_is_left_out() -> None:
    rig = Rig()
    for do in ("look", "beat", "go"):
        rig.log.put(Wish(Asked(ANN, "r1"), "part", "part", {"given": {"do": do}}), DONE)
    rig.log.put(
        Wish(Asked(ANN, "r1"), "part", "part", {"given": {"do": "beat"}}), REFUSED, VerbRefused("x", "y")
    )
    assert [row["outcome"] for row in rig.rows] == ["done", "refused"]
