"""Sessions at the zenoh bridge of a bench in memory: answers, commands, samples and errors."""

import json
from itertools import pairwise
from typing import Any

import pytest
import zenoh

from hil.testing import AnyBench, Bench

CONFIG: dict[str, Any] = {
    "bench": "b",
    "devices": {
        "m1": {"profile": "mechaduino", "flash": {"table": "identity"}},
        "s1": {"profile": "sac"},
    },
    "segments": {"bus0": {"stations": ["s1"], "taps": {"master": {"port": "pty"}}}},
    "bridges": {"zenoh": {}},
}
EACH = zenoh.ConsolidationMode.NONE
READINGS = (
    "sim/clock",
    "sim/health",
    "layout",
    "verbs/*",
    "axis/*/state",
    "axis/m1/state/packed",
    "axis/*/param/pKp",
    "axis/**",
    "segment/*/stats",
    "run/*/state",
    "run/none/state",
    "nothing",
)
COMMANDS = (
    ("axis/m1/cmd/enable", None),
    ("axis/m1/cmd/move_abs", '{"position_deg": 9}'),
    ("axis/m1/cmd/jump", None),
    ("axis/m1/cmd/move_abs", "{"),
    ("axis/m1/cmd/move_abs", '{"position_deg": "x"}'),
    ("axis/*/cmd/stop", None),
    ("axis/m9/cmd/stop", None),
    ("axis/m1/param/pKp", "14.5"),
    ("axis/m1/param/pKp", '"much"'),
    ("axis/m1/param/nix", "1"),
    ("axis/m1/fault", '{"fault": "shaft_jam", "for_s": 0.5}'),
    ("axis/m1/fault", '{"fault": "shaft_jm"}'),
    ("axis/m1/fault", '{"clear": "all"}'),
    ("segment/bus0/fault", '{"fault": "wire_noise", "rate": 0.01}'),
    ("segment/bus0/fault", '{"clear": "all"}'),
    ("run/submit", "steps: ["),
    ("run/none/cancel", "{}"),
)


@pytest.fixture
def b() -> Any:
    with Bench(CONFIG) as made:
        assert not made.start()
        yield made


def answers(session: Any, key: str, **options: Any) -> list[tuple[str | None, str, bytes]]:
    """Keys, encodings and payloads of all replies."""
    replies = [
        (str(reply.ok.key_expr), str(reply.ok.encoding), reply.ok.payload.to_bytes())
        if reply.ok
        else (None, str(reply.err.encoding), reply.err.payload.to_bytes())
        for reply in session.get(f"hil/b/{key}", consolidation=EACH, **options)
    ]
    return sorted(replies, key=lambda reply: (reply[0] or "", reply[2]))


def skeleton(value: Any) -> Any:
    """Structure of a document, with types in the place of numbers: times differ."""
    if isinstance(value, dict):
        return {name: skeleton(each) for name, each in value.items()}
    if isinstance(value, list):
        return [skeleton(each) for each in value]
    return "number" if isinstance(value, (int, float)) and not isinstance(value, bool) else value


def shape(reply: tuple[str | None, str, bytes]) -> Any:
    key, encoding, payload = reply
    if "json" not in encoding:
        return key, encoding, len(payload)
    content = json.loads(payload)
    if encoding.endswith("hil.health.v1"):  # what a loaded computer and a real clock say of themselves
        return key, encoding, sorted(content.keys() - {"rt"})
    content.pop("taps", None)  # those of a bench in memory have no port
    return key, encoding, skeleton(content)


@pytest.mark.thorough
@pytest.mark.long
def test_each_key_answers_as_over_a_real_session(b: Bench, live_bench: Any) -> None:
    live: AnyBench = live_bench(CONFIG | {"bridges": {"zenoh": {"listen": ["tcp/127.0.0.1:17452"]}}})
    mine, theirs = b.zenoh(), live.zenoh()
    for key in READINGS:
        assert [*map(shape, answers(mine, key))] == [*map(shape, answers(theirs, key))], key
    for key, payload in COMMANDS:
        had = [shape(each) for each in answers(mine, key, payload=payload)]
        want = [shape(each) for each in answers(theirs, key, payload=payload)]
        assert had == want, key
        assert had
    tokens = [
        sorted(str(each.ok.key_expr) for each in session.liveliness().get("hil/*/@live/**"))
        for session in (mine, theirs)
    ]
    assert tokens[0] == tokens[1]
    for key in ("axis/m1/state", "axis/s1/state/packed", "sim/clock", "sim/health", "segment/bus0/stats"):
        samples = [session.declare_subscriber(f"hil/b/{key}").recv() for session in (mine, theirs)]
        had, want = (
            shape((str(each.key_expr), str(each.encoding), each.payload.to_bytes())) for each in samples
        )
        assert had == want


def session_of_a_test() -> list[str]:
    said: list[str] = []
    with Bench(CONFIG) as bench:
        bench.start()
        session = bench.zenoh()
        session.declare_subscriber("hil/**", lambda sample: said.append(f"{bench.now_ns} {sample}"))
        for key in READINGS:
            said += map(str, answers(session, key))
        for key, payload in COMMANDS:
            said += map(str, answers(session, key, payload=payload))
        bench.tap("bus0.master").write(b"\x04\x55v")
        bench.run(ms=1500)
    return said


def test_two_runs_say_the_same() -> None:
    first = session_of_a_test()
    assert len(first) > 200
    assert first == session_of_a_test()


def test_a_motion_is_told_at_its_end(b: Bench) -> None:
    session = b.zenoh()
    answers(session, "axis/m1/cmd/enable")
    begin_ns = b.now_ns
    key = "axis/m1/cmd/move_abs?applied=true;done=true"
    told = [json.loads(each[2]) for each in answers(session, key, payload='{"position_deg": 90}')]
    assert len(told) == 3
    assert b.now_ns - begin_ns > 300e6
    assert b.axis("m1").snapshot().position_deg == pytest.approx(90, abs=1)
    (last,) = session.get(f"hil/b/{key}", payload='{"position_deg": 80}')
    assert json.loads(last.ok.payload.to_bytes())["done"]


def test_samples_are_at_multiples_of_the_interval(b: Bench) -> None:
    with b.zenoh() as session, session.declare_subscriber("hil/b/axis/m1/state") as states:
        times_ns = [json.loads(states.recv().payload.to_bytes())["at_ns"] for _ in range(20)]
        assert {later - now for now, later in pairwise(times_ns)} == {100_000_000}
        assert times_ns[0] % 100_000_000 == 0
        assert 0 <= b.now_ns - times_ns[-1] < 200_000_000


def test_a_put_is_carried_out_and_a_refusal_published(b: Bench) -> None:
    session = b.zenoh()
    refused = session.declare_subscriber("hil/b/sim/rejected")
    with session.declare_publisher("hil/b/axis/m1/cmd/enable") as publisher:
        assert publisher.matching_status.matching
        publisher.put(b"")
    session.put("hil/b/axis/m1/cmd/jump", "{}")
    assert json.loads(refused.recv().payload.to_bytes())["code"] == "no_verb"
    assert refused.try_recv() is None
    assert b.axis("m1").snapshot().loop_on == 1
    refused.undeclare()
    for call in (refused.recv, refused.undeclare):
        with pytest.raises(zenoh.ZError, match="Undeclared subscriber"):
            call()


def test_packets_come_in_time_to_whoever_waits(b: Bench) -> None:
    session = b.zenoh()
    packets = session.declare_subscriber("hil/b/segment/*/packets")
    b.run(ms=600)  # the bridge looks each half second whether somebody listens
    b.tap("bus0.master").write(b"\x04\x55v")
    sent_ns = b.now_ns
    sample = packets.recv()
    assert json.loads(sample.payload.to_bytes())["data"] == "045576"
    assert b.now_ns - sent_ns < 5_000_000


def test_sessions_hear_each_other_and_end(b: Bench) -> None:
    one, other = b.zenoh(), b.zenoh()
    heard = other.declare_subscriber("mine/**")
    one.put("mine/a", "x", attachment=b"y", encoding="text/plain")
    sample = heard.recv()
    assert (sample.payload.to_string(), sample.attachment.to_bytes()) == ("x", b"y")
    assert (str(sample.encoding), sample.kind) == ("text/plain", zenoh.SampleKind.PUT)
    one.close()
    assert one.is_closed()
    with pytest.raises(zenoh.ZError, match="session closed"):
        one.put("mine/a", "x")
    with other.declare_querier("hil/b/sim/clock") as querier:
        assert [str(reply.ok.key_expr) for reply in querier.get()] == ["hil/b/sim/clock"]
    b.close()
    assert other.is_closed()


def test_a_question_that_nobody_answers_times_out_in_simulated_time(b: Bench) -> None:
    session, kept = b.zenoh(), []
    b.zenoh().declare_queryable("silent", kept.append)
    begin_ns = b.now_ns
    (reply,) = session.get("silent", timeout=2)
    assert reply.err.payload.to_string() == "Timeout"
    assert b.now_ns - begin_ns == 2_000_000_000
    assert kept


def test_bad_input_is_refused_as_by_zenoh(b: Bench) -> None:
    session = b.zenoh()
    for call in (session.get, session.declare_subscriber, lambda key: session.put(key, b"")):
        with pytest.raises(zenoh.ZError, match="empty chunks are forbidden"):
            call("hil//b")
    with pytest.raises(TypeError, match="expected bytes/str type, found 'int'"):
        session.put("hil/b/x", 3)
    with pytest.raises(TypeError, match="timout"):
        session.get("hil/b/x", timout=3)
    with pytest.raises(TypeError, match="give a function"):
        session.declare_subscriber("hil/b/x", zenoh.handlers.RingChannel(3))
    with pytest.raises(zenoh.ZError, match="in memory ports publish no bytes"):
        session.declare_subscriber("hil/b/port/m1/tx")
    with (
        Bench({**CONFIG, "bridges": {}}) as bare,
        pytest.raises(KeyError, match="the bench has no bridge zenoh"),
    ):
        bare.zenoh()


def test_a_stop_of_all_benches_is_answered_under_the_key_of_each(b: Bench) -> None:
    with b.zenoh() as session:
        for key in ("hil/*/halt", "hil/b/halt"):
            (reply,) = session.get(key, payload='{"how": "prejudice"}')
            assert reply.ok, reply.err
            assert str(reply.ok.key_expr) == "hil/b/halt"
        (refused,) = session.get("hil/*/halt", payload='{"how": "later"}')
        assert refused.err
        assert json.loads(refused.err.payload.to_string())["key"] == "hil/b/halt"
