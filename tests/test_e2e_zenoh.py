"""The zenoh bridge as its users have it: plain zenoh and the client."""

import asyncio
import json
import struct
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest
from e2e_support import PATIENCE_S, Place, free_port, until
from plain_zenoh import Bench, zenoh_bench

from hil.client import ClientError, CommandError, connect, connect_sync
from hil.core.fields import OFFSETS, PACKED_BYTES

EXAMPLES = Path(__file__).parents[1] / "examples" / "zenoh"


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with zenoh_bench() as made:
        yield made


def test_a_command_is_acknowledged_then_applied_then_done(bench: Bench) -> None:
    assert bench.plain.one("axis/m1/cmd/enable")["effective_at_ns"] > 0
    replies = bench.plain.get("axis/m1/cmd/move_abs?applied=true;done=true", '{"position_deg": 90}')
    assert len(replies) == 3
    acknowledged, applied, done = replies
    assert {"v", "sim_ns", "wall_ns", "effective_at_ns", "ends_after_ns"} <= set(acknowledged)
    assert applied["applied"]
    assert applied["effective_at_ns"] == acknowledged["effective_at_ns"]
    assert done["done"]
    assert done["sim_ns"] >= acknowledged["effective_at_ns"] + acknowledged["ends_after_ns"]
    assert done["state"]["following"] == 0
    until(lambda: abs(bench.plain.one("axis/m1/state")["position_deg"] - 90) < 0.3, "the angle")


def test_a_put_is_carried_out_without_an_answer(bench: Bench) -> None:
    bench.plain.one("axis/m1/cmd/enable")
    before = bench.bridge()["commands"]
    bench.plain.session.put("hil/t/axis/m1/cmd/gains", '{"pKp": 11.0}')
    until(lambda: bench.bridge()["commands"] > before, "the command")
    assert bench.plain.one("axis/m1/param/pKp")["pKp"] == 11.0
    bench.plain.one("axis/m1/param/pKp", "15.0")
    assert bench.plain.one("axis/m1/param/pKp")["pKp"] == 15.0


BAD = [
    ("axis/m1/cmd/jump", "{}", "no_verb"),
    ("axis/m9/cmd/enable", "", "no_device"),
    ("axis/m1/cmd/move_abs", "{}", "bad_parameter"),
    ("axis/m1/cmd/move_abs", '{"position_deg": "far"}', "bad_parameter"),
    ("axis/m1/cmd/move_abs", '{"position_deg": true}', "bad_parameter"),
    ("axis/m1/cmd/move_abs", '{"position_deg": 1e7}', "bad_parameter"),
    ("axis/m1/cmd/move_abs", '{"position_deg": 1, "speed": 2}', "bad_parameter"),
    ("axis/m1/cmd/move_abs", '{"position_deg": NaN}', "bad_request"),
    ("axis/m1/cmd/move_abs", '{"position_deg": -Infinity}', "bad_request"),
    ("axis/m1/cmd/move_abs", '{"position_deg": 1e999}', "bad_request"),
    ("axis/m1/cmd/move_abs", "[90]", "bad_request"),
    ("axis/m1/cmd/move_abs", "90", "bad_request"),
    ("axis/m1/cmd/move_abs", b"\xff\x00{", "bad_request"),
    ("axis/m1/cmd/move_abs", "[" * 60_000, "bad_request"),
    ("axis/m1/cmd/move_abs", " " * 70_000, "bad_request"),
    ("axis/*/cmd/enable", "{}", "bad_request"),
    ("axis/*/param/pKp", "3", "bad_request"),
    ("axis/m1/param/pLPF", "-5", "bad_parameter"),
    ("axis/m1/param/r", "1", "no_parameter"),
    ("axis/m1/param/pKp", '"1"', "bad_request"),
    ("axis/m1/param/pKp", "1e9", "bad_parameter"),
    ("axis/m1/fault", '{"fault": "shaft_jamm"}', "bad_parameter"),
    ("segment/bus0/fault", '{"clear": 99}', "bad_parameter"),
    ("segment/bus0/fault", '{"fault": "shaft_jam", "target": "m1"}', "bad_parameter"),
]


@pytest.mark.parametrize(("key", "payload", "code"), BAD, ids=[f"{k}-{i}" for i, (k, _, _) in enumerate(BAD)])
def test_a_bad_command_gets_a_typed_error_and_moves_nothing(
    bench: Bench, key: str, payload: str | bytes, code: str
) -> None:
    bench.plain.one("axis/m1/cmd/stop", '{"how": "prejudice"}')
    before = bench.plain.one("axis/m1/state")
    answer = bench.plain.one(key, payload)
    assert (answer["code"], answer["v"]) == (code, 1)
    assert len(answer["error"]) > 10
    assert answer["sim_ns"] > 0
    assert answer["wall_ns"] > 0
    after = bench.plain.one("axis/m1/state")
    assert after["r"] == before["r"]
    assert abs(after["position_deg"] - before["position_deg"]) < 0.5


def test_refusals_are_published_and_counted(bench: Bench) -> None:
    heard, subscriber = bench.plain.listen("sim/rejected")
    with subscriber:
        before = bench.bridge()["rejected"]

        def told() -> bool:
            bench.plain.session.put("hil/t/axis/m1/cmd/jump", "{}")
            return bool(heard)

        until(told, "a refusal that is told")
        assert json.loads(heard[0].payload.to_string())["code"] == "no_verb"
        assert bench.bridge()["rejected"] > before
        assert bench.plain.one("sim/health")["rejected"] > before


def test_what_can_be_read_is_read_by_a_wildcard_too(bench: Bench) -> None:
    assert len(bench.plain.get("axis/*/state")) == 3
    assert {"collisions", "packets", "segment"} <= set(bench.plain.one("segment/bus0/stats"))
    verbs = bench.plain.one("verbs/s1")
    assert verbs["profile"] == "sac"
    assert {"move_rel", "type", "reset"} <= {row["verb"] for row in verbs["verbs"]}
    assert bench.plain.one("sim/health")["failed"] == {}
    assert bench.plain.get("axis/m1/nothing") == []


def test_states_come_at_exact_multiples_in_both_forms(bench: Bench) -> None:
    layout = {row["name"]: row for row in bench.plain.one("layout")["fields"]}
    assert {name: row["offset"] for name, row in layout.items()} == {name: OFFSETS[name] for name in layout}
    packed, first = bench.plain.listen("axis/m1/state/packed")
    texts, second = bench.plain.listen("axis/m1/state")
    with first, second:
        until(lambda: len(packed) > 500 and len(texts) > 20, "states")
    for sample in packed:
        assert len(sample.payload.to_bytes()) == PACKED_BYTES
    times = [struct.unpack_from("<q", sample.payload.to_bytes())[0] for sample in packed]
    gaps = [b - a for a, b in pairwise(times)]
    assert all(gap > 0 and gap % 1_000_000 == 0 for gap in gaps), gaps
    assert gaps.count(1_000_000) > 0.9 * len(gaps), "zenoh drops some where this machine has other work"
    assert str(texts[0].encoding) == "application/json;hil.state.v1"
    by_time = {json.loads(text.payload.to_string())["at_ns"]: text for text in texts}
    common = set(by_time) & set(times)
    assert len(common) >= 5
    for at_ns in common:
        text = json.loads(by_time[at_ns].payload.to_string())
        data = packed[times.index(at_ns)].payload.to_bytes()
        for name in ("position_deg", "r", "mode"):
            code = {"f32": "f", "f64": "d", "i32": "i", "i64": "q"}[layout[name]["type"]]
            assert text[name] == struct.unpack_from("<" + code, data, layout[name]["offset"])[0]


def test_presence(bench: Bench) -> None:
    with connect_sync("t", bench.endpoint) as client:
        assert client.alive() == ["axis/m1", "axis/s1", "axis/s2", "daemon", "segment/bus0"]


def test_packets_and_bytes_are_told(bench: Bench) -> None:
    packets, first = bench.plain.listen("segment/bus0/packets")
    sent, second = bench.plain.listen("port/s1/tx")
    with first, second:

        def told() -> bool:
            bench.plain.one("axis/s1/cmd/type", json.dumps({"text": r"86 hello\r"}))
            return bool(packets) and b"86 hello" in b"".join(each.payload.to_bytes() for each in sent)

        until(told, "a packet and an echo")
    packet = json.loads(packets[0].payload.to_string())
    assert bytes.fromhex(packet["data"])[0] == 2
    assert packet["about"].startswith("s1")
    assert json.loads(sent[0].attachment.to_string())["sim_ns"] > 0  # type: ignore[union-attr]


def test_a_stepper_and_its_faults(bench: Bench) -> None:
    with connect_sync("t", bench.endpoint) as client:
        s2 = client.axis("s2")
        turned = s2.move_rel(90, 120, wait=True)
        assert turned.answer["pulses"] == 100
        assert turned.answer["state"]["commanded_deg"] == 90
        number = s2.fault("shaft_jam")
        assert bench.server.ask("faults")[0]["number"] == number
        s2.clear_fault()
        assert bench.server.ask("faults") == []


def test_the_stream_of_set_points_ends_and_the_axis_stops(bench: Bench) -> None:
    with connect_sync("t", bench.endpoint) as client:
        m1 = client.axis("m1")
        m1.mode("velocity")
        m1.enable()
        for _ in range(3):
            m1.put("velocity", velocity_rpm=60)
        until(lambda: m1.state().r > 0, "the set-point")
        until(lambda: m1.state().r == 0 and not m1.state().following, "the stop")
        assert client.read("sim/health")["starved"]["m1"] >= 1
        assert "no set-point for 200 ms" in bench.server.status("m1")["note"]


def test_the_client_for_asyncio(bench: Bench) -> None:
    async def script() -> list[float]:
        async with connect("t", bench.endpoint) as client:
            m1, s1 = client.axis("m1"), client.axis("s1")
            await m1.enable()
            await asyncio.gather(m1.move_abs(45, 120, wait=True), s1.move_rel(18, 60, wait=True))
            seen = []
            async for state in m1.states():
                seen.append(state.position_deg)
                if len(seen) == 3:
                    break
            with pytest.raises(CommandError, match="has no 'jump'") as refused:
                await m1.do("jump")
            assert refused.value.code == "no_verb"
            return seen

    assert all(abs(position - 45) < 1 for position in asyncio.run(script()))


def test_a_packed_state_is_read_too(bench: Bench) -> None:
    (reply,) = bench.plain.session.get("hil/t/axis/m1/state/packed", timeout=PATIENCE_S)
    assert reply.ok is not None
    assert len(reply.ok.payload.to_bytes()) == PACKED_BYTES


def test_users_of_a_site_may_what_their_roles_say(place: Place) -> None:
    port, folder = free_port(), place.folder / "site"
    users = ("--user", "vera:viewer", "--user", "otto:operator", "--user", "anna:admin")
    where = ("--bench", "t", "--host", "127.0.0.1", "--port", str(port))
    place.cli("zenoh", "keys", str(folder), *where, *users)
    snippet = (folder / "bridge.yaml").read_text()
    head = "bench: t\ndevices:\n  m1: {profile: mechaduino, flash: {table: identity}}\n"
    server = place.serve(head + snippet).ready()
    done: dict[str, list[str]] = {}
    for who in ("vera", "otto", "anna"):
        with connect_sync("t", config=folder / "clients" / who / "zenoh.json") as client:
            m1 = client.axis("m1")
            assert client.alive() == ["axis/m1", "daemon"]
            assert m1.state().at_ns > 0
            for name, attempt in (
                ("enable", m1.enable),
                ("pKp", lambda axis=m1: axis.set_parameter("pKp", 14.0)),
                ("fault", lambda axis=m1: axis.fault("shaft_jam")),
            ):
                try:
                    attempt()
                except ClientError:
                    continue
                done.setdefault(who, []).append(name)
    assert done == {"otto": ["enable", "pKp"], "anna": ["enable", "pKp", "fault"]}
    with pytest.raises(ClientError, match="wants certificates"):
        connect_sync("t", f"tls/127.0.0.1:{port}", timeout_s=1)
    assert server.ask("status")["bridges"]["zenoh"]["rejected"] >= 1


def test_the_examples(bench: Bench) -> None:
    def run(program: str) -> str:
        command = [sys.executable, str(EXAMPLES / program), "t", bench.endpoint]
        return subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout

    bench.plain.one("axis/s1/cmd/reset")
    until(
        lambda: "code" not in bench.plain.one("axis/s1/cmd/move_abs", '{"position_deg": 0}'),
        "the SAC's start",
    )
    said = run("two_axes.py")
    assert said.startswith("m1 at 90 deg\ns1 at ")
    assert run("plain.py").splitlines()[1:] == ["axis/m1/cmd/move_abs 90", "axis/m1/cmd/jump no_verb"]
    assert len((EXAMPLES / "two_axes.py").read_text().splitlines()) <= 22  # under 20 without its docstring
