"""A board by a table beside a model of it: lines in pieces, several in one write, all line ends, lines that
are too long, bytes that are no text; with faults of the line, echoes, and a replay of what was recorded."""

import re
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hil.compose.replay import replay
from hil.testing import Bench

TABLE = """
name: box
title: Box
uarts: {main: {baud: 115200, receive_buffer_bytes: 8192}}
dialogue:
  longest: 40
  errors: {unknown: "?", bad_value: "=?", out_of_range: "!", wrong_state: "locked"}
  variables:
    level_V: {unit: V, value: 1, minimum: 0, maximum: 10, step: 0.5, about: level}
    relay: {type: switch, many: 3, about: relays}
    locked: {type: switch, about: lock}
    label: {type: text, value: a, longest: 8, about: label}
    steps: {type: whole, maximum: 1000, minimum: 0, about: steps}
  commands:
    - {asks: "L {level_V}", when: not locked, answers: OK, sets: {steps: steps + 1}}
    - {asks: "L?", answers: "{level_V:.1f}"}
    - {asks: "R {n} {relay[n]:OFF|ON}", answers: OK}
    - {asks: "R {n}?", takes: {}, answers: "{relay[n]:OFF|ON}"}
    - {asks: "K {locked}"}
    - {asks: "T {label}", answers: OK}
    - {asks: "T?", answers: ["<{label}>", "{steps}"]}
"""
LINES = st.one_of(
    st.sampled_from(
        ["L?", "T?", "K 0", "K 1", "K 2", "L", "R 1?", "R 4?", "R 0 ON", "L  3", "L 3 ", " L?", "\0L?"]
    ),
    st.floats(-2, 12, width=16).map(lambda value: f"L {value:g}"),
    st.tuples(st.integers(0, 4), st.sampled_from(["ON", "OFF", "On", ""])).map(lambda t: f"R {t[0]} {t[1]}"),
    st.integers(1, 3).map(lambda n: f"R {n}?"),
    st.text("abc \0{}%\xff", max_size=12).map(lambda text: "T " + text),
    st.integers(35, 60).map(lambda count: "T" + " " * count + "b"),
    st.text(st.characters(max_codepoint=255, exclude_characters="\r\n"), max_size=50),
)
ENDS = st.sampled_from(["\r", "\n", "\r\n", "\n\n"])


class Model:
    """What the table says, in Python."""

    def __init__(self) -> None:
        self.level, self.relays, self.locked, self.label, self.steps = 1.0, [0, 0, 0], 0, "a", 0

    def answers(self, line: str) -> list[str]:
        """Lines that it answers to one."""
        if not line:
            return []
        if len(line) > 40:
            return ["?"]
        if line in ("L?", "T?"):
            return [f"{self.level:.1f}"] if line == "L?" else [f"<{self.label}>", str(self.steps)]
        word, typed = line[0], line[1:].lstrip(" \t")
        if len(line) < 2 or word not in "LRKT" or typed == line[1:]:
            return ["?"]
        return {"L": self._level, "R": self._relay, "K": self._lock, "T": self._text}[word](typed)

    def _level(self, typed: str) -> list[str]:
        value = number(typed)
        if value is None:
            return ["=?"] if typed else ["?"]
        if not 0 <= value <= 10:
            return ["!"]
        if self.locked:
            return ["locked"]
        self.level, self.steps = min(max(round(value / 0.5) * 0.5, 0), 10), self.steps + 1
        return ["OK"]

    def _lock(self, typed: str) -> list[str]:
        if typed not in ("0", "1"):
            return ["=?"] if typed else ["?"]
        self.locked = int(typed)
        return []

    def _text(self, typed: str) -> list[str]:
        if not typed:
            return ["?"]
        if len(typed) > 8:
            return ["!"]
        self.label = typed
        return ["OK"]

    def _relay(self, typed: str) -> list[str]:
        digits = typed[: len(typed) - len(typed.lstrip("0123456789"))]
        rest = typed[len(digits) :]
        if digits and (rest == "?" or (rest[:1] in " \t" and rest.lstrip(" \t") in ("ON", "OFF"))):
            if not 1 <= int(digits) <= 3:
                return ["!"]
            if rest == "?":
                return [("OFF", "ON")[self.relays[int(digits) - 1]]]
            self.relays[int(digits) - 1] = int(rest.lstrip(" \t") == "ON")
            return ["OK"]
        return ["=?"] if typed else ["?"]


def number(text: str) -> float | None:
    return float(text) if re.fullmatch(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(e[+-]?[0-9]+)?", text) else None


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("boards")
    (made / "box").mkdir()
    (made / "box/profile.yaml").write_text(TABLE)
    return made


def made(folder: Path) -> Bench:
    return Bench({"bench": "t", "profile_path": [str(folder)], "devices": {"b1": {"profile": "box"}}})


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(st.tuples(LINES, ENDS), max_size=12), st.lists(st.integers(1, 30), min_size=1, max_size=8))
def test_any_stream_is_answered_as_the_model_does(
    folder: Path, lines: list[tuple[str, str]], pieces: list[int]
) -> None:
    data = "".join(line + end for line, end in lines).encode("latin-1")
    model = Model()
    wanted = [answer for line, _ in lines for answer in model.answers(line)]
    with made(folder) as bench:
        at, turn = 0, 0
        while at < len(data):
            size = pieces[turn % len(pieces)]
            bench.port("b1").write(data[at : at + size])
            bench.run(ms=turn % 3)
            at, turn = at + size, turn + 1
        bench.run(ms=300)
        said = bench.port("b1").read().decode("latin-1")
        assert said == "".join(answer + "\r\n" for answer in wanted)
        state = bench.axis("b1").snapshot()
        assert (state.level_V, state.locked, state.steps) == (model.level, model.locked, model.steps)
        assert [state.relay1, state.relay2, state.relay3] == model.relays


def test_faults_of_the_line_and_a_replay_to_the_byte(folder: Path) -> None:
    with made(folder) as bench:
        port, said = bench.port("b1"), []
        faults = [("byte_drop", 0.1), ("byte_flip", 0.01)]
        for turn in range(30):
            kind, rate = faults[turn % 2]
            with bench.fault(kind, "b1", rate=rate, towards="board" if turn % 3 else "client", seed=turn):
                for line in (b"L %d\r\n" % (turn % 12), b"R 1 ON\rR 1?\n", b"T?\n", b"L?\0\n"):
                    port.write(line)
                    bench.run(ms=7)
            said.append(port.read())
        port.write(b"\nL 7\nL?\n")
        bench.run(ms=20)
        assert port.read().endswith(b"OK\r\n7.0\r\n")
        assert len(set(said)) > 20
        text = StringIO()
        bench.inputs.write_to(text)
    replayed = replay(text.getvalue().splitlines(keepends=True))
    assert replayed.difference() is None
    assert replayed.runtime.parts.axis("b1").snapshot().level_V == 7


def test_boards_on_a_line_whose_adapter_echoes(tmp_path: Path) -> None:
    (tmp_path / "box").mkdir()
    text = TABLE.replace(
        "  longest: 40\n", '  prefix: "#{=address:02d} "\n  answer_prefix: "{address:02d} "\n'
    )
    address = "    address: {type: whole, value: 1, minimum: 0, maximum: 99, about: address}\n    level_V:"
    text = text.replace("    level_V:", address, 1)
    (tmp_path / "box/profile.yaml").write_text(text)
    devices = {"a": {"profile": "box"}, "b": {"profile": "box", "fields": {"address": 2}}}
    taps = {"master": {"port": "memory", "echo": True}}
    segments = {"bus0": {"stations": ["a.main", "b.main"], "baud": 115200, "taps": taps}}
    config = {"bench": "t", "profile_path": [str(tmp_path)], "devices": devices, "segments": segments}
    asked = ((b"#02 L 3\n", b"02 OK\r\n"), (b"#01 L?\n", b"01 1.0\r\n"), (b"#02 L?\n", b"02 3.0\r\n"))
    with Bench(config) as bench:
        master = bench.tap("bus0.master")
        for line, answer in asked:
            master.write(line)
            bench.run(ms=20)
            assert master.read() == line + answer
