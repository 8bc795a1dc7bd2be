"""Random texts: any is either a bench or a list of problems; any slip of one key is found where it stands."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from hil.config import Catalogue, ConfigError, from_dict, parse, profile_from_yaml, yaml_text
from hil.config.document import Problem

PROFILE = Path(__file__).parents[3] / "device_profiles" / "mechaduino"


class PtyLike(BaseModel):
    mode: str = "0660"
    group: str | None = None
    path: str | None = None


class TcpLike(BaseModel):
    host: str = "127.0.0.1"
    port: int


CATALOGUE = Catalogue(
    {"mechaduino": profile_from_yaml((PROFILE / "profile.yaml").read_text(), PROFILE)},
    {"pty": PtyLike, "tcp": TcpLike},
)

VALID = """\
bench: t
rate_hz: 1000
speed: 1.0
seed: 0
cpu: 0
runtime_dir: /run/t
state_dir: /var/t
devices:
  m1:
    profile: mechaduino
    port:
      kind: pty
      mode: "0660"
      group: dialout
      path: x
    baud: 9600
    flash:
      table: empty
    hardware: "0.1"
    plant: simple
    axis:
      inertia_kg_m2: 5.4e-6
      viscous_Nm_s_per_rad: 0.004
      torque_constant_Nm_per_A: 0.225
      rotor_teeth: 50
      sense_resistor_ohm: 0.15
      start_deg: 6.3
      load_torque_Nm: 0
      supply_V: 12
    registers:
      diaagc: 0x0180
      errfl: 0
    spi_previous_command: 0xFFFF
  m2:
    profile: mechaduino
    port:
      kind: tcp
      host: localhost
      port: 5000
"""
LINES = VALID.splitlines()
KEY_LINES = [index for index, line in enumerate(LINES) if line.strip() not in ("m1:", "m2:")]


def slips(key: str) -> list[str]:
    """Every way to leave out, double, swap or mistype one character of a key."""
    found = []
    for at, character in enumerate(key):
        found += [key[:at] + key[at + 1 :], key[:at] + character + key[at:]]
        found += [key[:at] + key[at + 1 : at + 2] + character + key[at + 2 :]]
        found += [key[:at] + wrong + key[at + 1 :] for wrong in "x_"]
    # A slip that gives another key of the file (speed, seed) is a double key, not an unknown one.
    return [slip for slip in dict.fromkeys(found) if f" {slip}:" not in " " + VALID.replace("\n", " ")]


@pytest.mark.parametrize("index", KEY_LINES, ids=lambda index: LINES[index].strip().split(":")[0])
def test_every_slip_of_a_key_is_found_where_it_stands(index: int) -> None:
    line = LINES[index]
    indent = len(line) - len(line.lstrip())
    key, rest = line.strip().split(":", 1)
    for slip in slips(key):
        text = "\n".join([*LINES[:index], " " * indent + slip + ":" + rest, *LINES[index + 1 :]])
        (problem,) = problems(text) or []
        assert (problem.line, problem.column) == (index + 1, indent + 1), slip
        assert problem.message.endswith("unknown key"), slip
        assert problem.remedy == f'did you mean "{key}"?', slip


def problems(text: str) -> list[Problem] | None:
    """Problems of a configuration, None for a valid bench."""
    try:
        parse(text, "b.yaml", CATALOGUE)
    except ConfigError as error:
        return error.problems
    return None


def check_outcome(text: str) -> None:
    found = problems(text)
    if found is None:
        return
    assert found
    places = [(problem.line, problem.column) for problem in found]
    assert places == sorted(places)
    assert min(places) >= (1, 1)
    assert all(problem.message and problem.remedy for problem in found)
    assert all(str(problem).isprintable() for problem in found)


@given(st.text(st.characters(exclude_categories=()), max_size=60))
def test_any_text_gives_a_bench_or_problems(text: str) -> None:
    check_outcome(text)


@given(st.binary(max_size=60))
def test_any_bytes_read_as_text_give_a_bench_or_problems(data: bytes) -> None:
    check_outcome(data.decode("utf-8", "surrogateescape"))
    check_outcome(data.decode("latin-1"))


MARKS = "\n|  |\t|: |- |? |[|]|{|}|,|&a |*a|!!int |!x |>-\n|'|\"|#|%YAML 1.|%TAG |---\n|...\n|<<|=|~|@|`"
WORDS = "bench|devices|m1|profile|mechaduino|port|kind|pty|axis|on|2001-01-01|.inf|0x|0o|1_|\\x|\\U|\\ud800"
TOKENS = st.sampled_from(["|\n", *MARKS.split("|"), *WORDS.split("|")])


@pytest.mark.long
@given(st.lists(TOKENS, max_size=30).map("".join))
@settings(max_examples=500)
def test_any_yaml_like_text_gives_a_bench_or_problems(text: str) -> None:
    check_outcome(text)


@given(st.data())
@settings(max_examples=300)
def test_a_valid_bench_with_a_piece_replaced_gives_a_bench_or_problems(data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(VALID)))
    end = data.draw(st.integers(start, min(start + 12, len(VALID))))
    check_outcome(VALID[:start] + data.draw(st.one_of(TOKENS, st.text(max_size=4))) + VALID[end:])


KEYS = st.one_of(
    st.sampled_from(
        [
            "bench",
            "devices",
            "m1",
            "profile",
            "port",
            "kind",
            "axis",
            "flash",
            "table",
            "supply_V",
            "registers",
        ]
    ),
    st.text(max_size=4),
    st.integers(),
    st.none(),
)
VALUES = st.recursive(
    st.one_of(
        st.sampled_from(["mechaduino", "pty", "tcp", "empty"]),
        st.none(),
        st.booleans(),
        st.integers(),
        st.floats(),
        st.text(st.characters(exclude_categories=()), max_size=4),
        st.binary(max_size=2),
    ),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=5),
    max_leaves=12,
)


def dict_problems(data: Mapping[str, object]) -> list[Problem] | None:
    try:
        from_dict(data, CATALOGUE)
    except ConfigError as error:
        return error.problems
    return None


@pytest.mark.long
@given(st.dictionaries(KEYS, VALUES, max_size=4), st.dictionaries(KEYS, VALUES, max_size=6))
@settings(max_examples=300)
def test_any_mapping_gives_a_bench_or_problems(top: dict[str, object], keys: dict[str, object]) -> None:
    for data in (top, {"bench": "t", "devices": {"m1": {"profile": "mechaduino", **keys}}}):
        found = dict_problems(data)
        assert found is None or found
        assert all(str(problem).isprintable() for problem in found or [])


def nodes(text: str, compose: Callable[[str, str], Any]) -> object:
    """Nodes of a text with their places, or what is wrong with it."""

    def flat(node: Any, around: tuple[Any, ...] = ()) -> object:
        if node is None:
            return None
        if node in around:  # an anchor whose value has an alias of it
            return "itself", around.index(node)
        mark, inside = node.start_mark, (*around, node)
        match node.value:
            case str(value):
                return node.tag, value, mark.line, mark.column
            case [tuple(), *_]:
                pairs = [(flat(key, inside), flat(value, inside)) for key, value in node.value]
                return node.tag, pairs, mark.line, mark.column
            case _:
                return node.tag, [flat(item, inside) for item in node.value], mark.line, mark.column

    try:
        return flat(compose(text, "f"))
    except ConfigError as error:
        return str(error)


PIECES = [*"ab:-#[]{},'\"\\ \t!?|>*%@1.~\n\ufeff", "a: ", "- ", "\n  ", "\n- ", "\nb: 1", "--- ", "# c\n"]

QUOTED = [
    '"a?"',
    "'!b'",
    '"c|d"',
    "'e''>'",
    '{"f": "g?"}',
    '["?", "!"]',
    ': "h # i"',
    "# j ?\n",
    ' "?',
    "\n  : '",
]


@pytest.mark.long
@settings(max_examples=2000)
@example("&a [*a]")
@example('"a\n : ", b?: "')
@given(st.lists(st.sampled_from([*PIECES, *QUOTED, "\n", "&a ", "*a"]), max_size=14).map("".join))
def test_the_fast_parser_reads_what_the_other_reads(text: str) -> None:
    assert nodes(text, yaml_text._compose) == nodes(text, yaml_text._compose_slowly)


@pytest.mark.long
@settings(max_examples=300)
@given(st.integers(0, len(VALID)), st.sampled_from(["", *PIECES]), st.integers(0, 2))
def test_one_slip_is_read_alike_by_both_parsers(place: int, piece: str, gone: int) -> None:
    text = VALID[:place] + piece + VALID[place + gone :]
    assert nodes(text, yaml_text._compose) == nodes(text, yaml_text._compose_slowly)
