"""Lines of the input log: there and back, and what is no line."""

import io
import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.sim.input_log import InputLogWriter
from hil.sim.input_reading import LATEST_NS, decode, read_line
from hil.sim.inputs import (
    KINDS,
    Bytes,
    CommitDone,
    Inject,
    Input,
    InputLogError,
    Logged,
    Pin,
    Reset,
    ScriptEncoder,
    SetField,
    Stopped,
    encode_line,
)
from hil.sim.log_checks import without_checks
from hil.sim.log_format import CHECK, END, EVENT, HEADER, LINES, RELOAD, SENT, input_lines
from hil.sim.log_reading import read_input_log
from hil.sim.noted_events import NotedEvent, encode_event, latest_events, without_names
from hil.sim.reloads import Begun, Reloaded, decode_reload, encode_reload
from hil.vocab.time import SimTimeNs

TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=10)
INT64 = st.integers(-(2**63), 2**63 - 1)
INPUTS: st.SearchStrategy[Input] = st.one_of(
    st.builds(Bytes, st.binary(max_size=100), st.none() | st.integers(50, 4_000_000)),
    st.builds(Pin, st.sampled_from(["D0", "D1", "D2", "D3", "step"]), st.integers(0, 1)),
    st.builds(SetField, TEXT, st.floats(allow_nan=False, allow_infinity=False)),
    st.builds(ScriptEncoder, st.lists(st.tuples(INT64, INT64), max_size=8).map(tuple), st.booleans()),
    st.builds(Reset),
    st.builds(CommitDone, st.booleans(), st.booleans()),
    st.builds(
        Stopped,
        st.integers(0, 2**63 - 1),
        TEXT,
        st.lists(
            st.tuples(TEXT, st.none() | st.integers(50, 2**32), st.binary(max_size=9).map(bytes.hex)),
            max_size=3,
        ).map(tuple),
    ),
)
LOGGED = st.builds(Logged, st.integers(0, LATEST_NS).map(SimTimeNs), TEXT, INPUTS)
GOOD = '{"at_ns":5,"device":"m1","input":"bytes","data":"7079","client_baud":null}'


@given(LOGGED)
def test_a_line_reads_back(logged: Logged) -> None:
    line = encode_line(logged)
    assert "\n" not in line
    assert decode(read_line(line)) == logged


def test_a_line_is_what_the_format_says() -> None:
    logged = Logged(SimTimeNs(5), "m1", Bytes(b"py"))
    assert encode_line(logged) == GOOD
    assert decode(read_line(GOOD)) == logged


@pytest.mark.parametrize(
    "line",
    [
        "",
        "[]",
        "7",
        "null",
        "{}",
        GOOD[:-1],
        GOOD.replace("5", '"soon"'),
        GOOD.replace("bytes", "octets"),
        GOOD.replace("7079", "707"),
        GOOD.replace("7079", "py"),
        GOOD.replace("}", ',"more":1}'),
        GOOD.replace(',"client_baud":null', ""),
        '{"at_ns":5,"device":"m1","input":"script_encoder","points":[[1]],"linear":true}',
        '{"at_ns":5,"device":"m1","input":"script_encoder","points":[["x",1]],"linear":true}',
    ],
)
def test_what_is_no_line_is_refused(line: str) -> None:
    with pytest.raises(InputLogError):
        decode(read_line(line))


@given(st.text(max_size=60) | st.binary(max_size=60).map(lambda data: data.decode("latin-1")))
def test_nonsense_is_an_input_log_error_and_nothing_else(text: str) -> None:
    with pytest.raises(InputLogError):
        decode(read_line(text))


MEMORIES = st.dictionaries(TEXT, st.dictionaries(TEXT, st.binary(max_size=50), max_size=2), max_size=3)


def written(config: dict[str, Any], memories: dict[str, dict[str, bytes]], inputs: list[Logged]) -> str:
    file = io.StringIO()
    writer = InputLogWriter(file, "test", config, memories)
    for logged in inputs:
        writer.write(logged)
    return file.getvalue()


@given(MEMORIES, st.lists(LOGGED, max_size=5))
def test_a_log_reads_back(memories: dict[str, dict[str, bytes]], inputs: list[Logged]) -> None:
    config = {"bench": "b", "devices": {"m1": {"speed": 1.5}}}
    log = read_input_log(io.StringIO(written(config, memories, inputs)))
    assert (log.config, log.memories, log.inputs, log.sent) == (config, memories, inputs, [])


def test_a_last_line_that_was_cut_is_left_out() -> None:
    logged = Logged(SimTimeNs(5), "m1", Reset())
    text = written({}, {}, [logged, logged])
    for cut in range(text.index("\n", text.index("\n") + 1) + 1, len(text) - 1):
        assert read_input_log(io.StringIO(text[:cut])).inputs == [logged]


@pytest.mark.parametrize(
    "change",
    [("hil-inputs", "hil-nothing"), ('"version":3', '"version":99'), ('"nvm"', '"mvn"'), ("{", "[")],
)
def test_another_file_is_refused(change: tuple[str, str]) -> None:
    with pytest.raises(InputLogError):
        read_input_log(io.StringIO(written({}, {}, []).replace(*change, 1)))
    with pytest.raises(InputLogError):
        read_input_log([])


def test_the_header_names_format_version_and_program() -> None:
    header = json.loads(written({"bench": "b"}, {"m1": {"lookup": b"\0\1"}}, []))
    assert header == {
        "format": "hil-inputs",
        "version": 3,
        "program": "test",
        "begun": None,
        "speed": 1.0,
        "config": {"bench": "b"},
        "nvm": {"m1": {"lookup": "AAE="}},
    }


def test_the_table_of_the_format_has_what_is_written_and_read() -> None:
    for _, _, fields in input_lines():
        assert all(each.type for each in fields)
    assert [name for name, _, _ in input_lines()] == list(KINDS)
    file = io.StringIO()
    about = {"ports": {"m1": "pty"}, "forked_from": "run.hil at 5s"}
    clock = lambda: (5, "2026-11-29T00:09:16.000000Z")  # noqa: E731
    writer = InputLogWriter(file, "test", {}, {}, clock=clock, about=about)
    writer.write(Logged(SimTimeNs(5), "m1", Inject(1, "byte_flip", ())))
    writer.checks.check()
    writer.end()
    header, _, check, end = map(json.loads, file.getvalue().splitlines())
    for line, fields in ((header, HEADER), (check, CHECK), (end, END)):
        assert list(line) == [each.name for each in fields] or set(line) == {each.name for each in fields}
    assert set(LINES.values()) == {HEADER, SENT, RELOAD, EVENT, CHECK, END}
    assert list(json.loads(encode_event(EVENTS[0]))) == [each.name for each in EVENT]
    assert list(json.loads(encode_reload(Reloaded(5, {}, (), ())))) == [each.name for each in RELOAD]


EVENTS = [
    NotedEvent(1, "verbs", 5, 5, "m1", "ann", "enable", 1),
    NotedEvent(2, "refusals", 6, 6, "m1", "bob", "run: /home/bob/a.yaml: there is no axis m9", 1),
    NotedEvent(1, "verbs", 5, 9, "m1", "ann", "enable", 4),
]


def test_events_read_back_and_are_no_inputs() -> None:
    file = io.StringIO()
    writer = InputLogWriter(file, "test", {}, {})
    for event in EVENTS:
        writer.add(event)
    writer.write(Logged(SimTimeNs(9), "m1", Reset()))
    writer.end()
    log = read_input_log(io.StringIO(file.getvalue()))
    assert log.events == EVENTS
    assert latest_events(log.events) == [EVENTS[2], EVENTS[1]]
    assert (len(log.inputs), log.end_ns) == (1, 9)
    damaged = file.getvalue().replace('"count":4', '"count":"4"')
    assert read_input_log(io.StringIO(damaged), strict=False).events == []
    old = read_input_log(io.StringIO("".join(without_checks(file.getvalue()))))
    assert (old.events, len(old.inputs)) == ([], 1)


def test_events_for_others_have_neither_names_nor_folders() -> None:
    said = "".join(encode_event(without_names(event)) for event in EVENTS)
    assert "enable" in said
    assert not any(word in said for word in ("ann", "bob", "home"))


@pytest.mark.parametrize(
    "change",
    [{"begun": 5}, {"begun": [["m1", 5]]}, {"removed": "m1"}, {"reload": []}, {"nvm": {"m1": {"a": 5}}}],
)
def test_what_is_no_reload_is_refused(change: dict[str, Any]) -> None:
    good = Reloaded(5, {"bench": "b"}, ("m1",), (Begun("m1", 7, 4, {"lookup": b"\1"}),))
    assert decode_reload(json.loads(encode_reload(good))) == good
    with pytest.raises(InputLogError):
        decode_reload(json.loads(encode_reload(good)) | change)


@given(LOGGED)
def test_an_inputs_line_has_the_fields_of_the_table(logged: Logged) -> None:
    values = json.loads(encode_line(logged))
    table = {name: fields for name, _, fields in input_lines()}[values["input"]]
    needed = {each.name for each in table if not each.is_optional}
    assert needed <= set(values) - {"at_ns", "device", "input"} <= {each.name for each in table}
