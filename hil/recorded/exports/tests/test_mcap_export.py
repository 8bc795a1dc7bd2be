"""A file of MCAP is read by its library, and each message is as its channel's schema says."""

import json
from contextlib import suppress
from io import BytesIO
from typing import Any

import pytest
from exported_bench import READ, opened, recorded

from hil.recorded.exports.export_names import wanted_of_all
from hil.recorded.recorded_run import RecordedRun
from hil.sim.input_log import InputLog
from hil.testing import Bench
from hil.vocab.time import NS_PER_MS, NS_PER_S, SimTimeNs
from hil.vocab.verbs import VerbRefused

pytest.importorskip("mcap", reason="the extra mcap is not installed: make .venv/.dev")
jsonschema = pytest.importorskip("jsonschema")

Message = tuple[int, dict[str, Any]]


@pytest.fixture(scope="module")
def log() -> InputLog:
    return recorded()


def written(log: InputLog, names: list[str], from_ns: int = 0, to_ns: int | None = None) -> bytes:
    from hil.recorded.exports.mcap_export import McapContent, write_mcap

    run, end_ns = opened(log)
    file = BytesIO()
    content = McapContent(*wanted_of_all(run, names))
    write_mcap(file, run, content, SimTimeNs(from_ns), SimTimeNs(to_ns or end_ns), 10 * NS_PER_MS)
    return file.getvalue()


def validator(schema: dict[str, Any]) -> Any:
    """Validator of a schema that is itself a valid one."""
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    return kind(schema)


def channels(data: bytes) -> dict[str, list[Message]]:
    """Messages by topic, each checked against its schema."""
    from mcap.reader import make_reader

    reader = make_reader(BytesIO(data), validate_crcs=True)
    summary = reader.get_summary()
    assert summary is not None
    found: dict[str, list[Message]] = {channel.topic: [] for channel in summary.channels.values()}
    valid = {number: validator(json.loads(schema.data)) for number, schema in summary.schemas.items()}
    for schema, channel, message in reader.iter_messages():
        assert schema is not None
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        value = json.loads(message.data)
        valid[schema.id].validate(value)
        found[channel.topic].append((message.log_time, value))
    assert summary.statistics is not None
    assert summary.statistics.message_count == sum(map(len, found.values()))
    assert {
        summary.channels[number].topic: count
        for number, count in summary.statistics.channel_message_counts.items()
    } == {topic: len(messages) for topic, messages in found.items() if messages}
    return found


def test_all_of_a_run(log: InputLog) -> None:
    found = channels(written(log, []))
    state = found["/axis/m1/state"]
    run, end_ns = opened(log)
    assert len(state) == end_ns // (10 * NS_PER_MS) + 1
    at_ns, values = state[500]
    assert at_ns == values["at_ns"] == 5 * NS_PER_S
    run.run_until(SimTimeNs(at_ns))
    snapshot = run.runtime.snapshot("m1")
    assert values["position_deg"] == snapshot.position_deg
    assert values["r"] == pytest.approx(snapshot.r, rel=1e-8)
    given = "".join(each["text"] for _, each in found["/port/s1/rx"])
    assert given == "m100v60\rm-20v30\r"
    assert "".join(each["text"] for _, each in found["/port/s1/tx"]).startswith("SAC 1.0\r\nSAC>m100v60")
    request, answer = (each for _, each in found["/segment/bus1/packets"])
    assert (request["kind"], request["data"]) == ("packet", READ.hex())
    assert answer["text"]
    assert {each["can_id"] for _, each in found["/can/can0/frames"]} == {0x705, 0x706}
    begun, cleared = (each for _, each in found["/faults"])
    assert (begun["kind"], begun["at"], begun["is_on"]) == ("shaft_load", "m1", True)
    assert json.loads(begun["parameters"])["torque_Nm"] == 0.1
    assert (cleared["kind"], cleared["is_on"]) == ("shaft_load", False)
    ((_, verb),) = found["/verbs"]
    assert (verb["verb"], verb["at"], verb["refused"]) == ("move_abs", "m2", "")
    assert [each["level"] for _, each in found["/log"]][:2] == [3, 3]
    assert {each["name"] for _, each in found["/log"]} == {"m1", "m2"}


def test_a_window_of_what_is_named(log: InputLog) -> None:
    found = channels(written(log, ["m1.e", "bus1"], 4 * NS_PER_S, 7 * NS_PER_S))
    assert [topic for topic in found if topic.startswith(("/axis", "/port", "/segment", "/can"))] == [
        "/axis/m1/state",
        "/segment/bus1/packets",
    ]
    times_ns = [at_ns for messages in found.values() for at_ns, _ in messages]
    assert min(times_ns) >= 4 * NS_PER_S
    assert max(times_ns) <= 7 * NS_PER_S
    assert {*found["/axis/m1/state"][0][1]} == {"at_ns", "e"}


def test_times_count_from_the_walls_where_the_log_has_it(log: InputLog) -> None:
    from dataclasses import replace

    begun = replace(log, begun="2026-11-29T00:09:16.123456Z")
    state = channels(written(begun, ["m1.e"], 0, NS_PER_S))["/axis/m1/state"]
    assert state[1][0] - state[1][1]["at_ns"] == 1795910956_123456000


def test_a_value_that_json_has_not_is_left_out() -> None:
    from hil.recorded.exports.mcap_messages import AxisTexts

    ((at_ns, text),) = AxisTexts(["r", "position_deg"]).texts([(5, float("nan"), 1.5)], 10)
    assert (at_ns, json.loads(text)) == (15, {"at_ns": 5, "position_deg": 1.5})


def test_a_refused_verb_says_why() -> None:
    def drive(bench: Bench) -> None:
        bench.run(100)
        with suppress(VerbRefused):
            bench.axis("m1").do("move_abs", position_deg=45)  # its loop is off
        bench.run(100)

    config = {"bench": "t", "devices": {"m1": {"profile": "mechaduino"}}}
    found = channels(written(recorded(drive, config), []))
    ((_, verb),) = found["/verbs"]
    assert verb["refused"]
    ((_, line),) = found["/log"]
    assert line["level"] == 3
    assert line["message"].endswith(f": refused: {verb['refused']}")


def test_large_files_have_several_chunks(monkeypatch: pytest.MonkeyPatch, log: InputLog) -> None:
    from mcap.reader import make_reader

    from hil.recorded.exports import mcap_chunks

    monkeypatch.setattr(mcap_chunks, "CHUNK_BYTES", 20_000)
    data = written(log, [])
    summary = make_reader(BytesIO(data)).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) > 10
    found = channels(data)
    assert len(found["/axis/m2/state"]) == RecordedRun(log).end_ns // (10 * NS_PER_MS) + 1
    one = [*make_reader(BytesIO(data)).iter_messages(topics=["/axis/m1/state"])]
    assert len(one) == len(found["/axis/m1/state"])
