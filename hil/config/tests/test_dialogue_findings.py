"""``dialogue`` of a ``profile.yaml``: what it is, and what is wrong with it, each with its place."""

import time
from pathlib import Path

import pytest

from hil.config import ConfigError, ProfileInfo, yaml_text
from hil.config.catalogue import profile_from_yaml

HEAD = "name: it\ntitle: It\nuarts: {main: {baud: 9600}}\n"
TABLE = HEAD + "dialogue:\n"
VARIABLES = """
  variables:
    level_V: {unit: V, minimum: 0, maximum: 10, about: level}
    relay: {type: switch, many: 2, about: relays}
    room_degC: {unit: degC, input: true, about: room}
    twice_V: {unit: V, computed: 2 * level_V, about: twice}
    way: {type: choice, choices: [CC, CV], value: CV, about: way}
    label: {type: text, value: hi, about: label}
"""
ASK = '  commands: [{asks: "A"}]\n'


def read(text: str) -> ProfileInfo:
    return profile_from_yaml(text, Path("it"))


def problems(text: str) -> list[str]:
    """Refuse a profile: for each problem the text from its place on, up to 12 letters, and what is said."""
    with pytest.raises(ConfigError) as refused:
        read(text)
    lines = text.splitlines()
    return [
        f"{lines[p.line - 1][p.column - 1 :][:12]} | {p.message} ({p.remedy})" for p in refused.value.problems
    ]


def commands(*rows: str) -> str:
    return TABLE + VARIABLES.lstrip("\n") + "  commands:\n" + "".join(f"    - {row}\n" for row in rows)


def test_variables_are_fields() -> None:
    made = read(TABLE + VARIABLES.lstrip("\n") + ASK)
    fields = {field.name: field for field in made.fields_of("axis")}
    assert list(fields) == ["level_V", "relay1", "relay2", "room_degC", "twice_V", "way"]
    assert (fields["level_V"].low, fields["level_V"].high, fields["level_V"].unit) == (0, 10, "V")
    assert (fields["way"].start, fields["way"].about) == (1, "way: 0 CC, 1 CV")
    assert fields["relay2"].about == "relays, number 2"
    assert fields["room_degC"].is_input


@pytest.mark.parametrize(
    ("row", "where", "said"),
    [
        (
            '{asks: "V {levl_V}"}',
            '"V {levl_V}"',
            'asks: there is no variable "levl_V" (did you mean "level_V"?',
        ),
        ('{asks: "V {level_V"}', '"V {level_V"', "asks: a { has no } (write {{ for a brace itself)"),
        (
            '{asks: "V {level_V}{way}"}',
            '"V {level_V}',
            "nothing says where {level_V} ends and {way} begins",
        ),
        ('{asks: "V {twice_V}"}', '"V {twice_V}', "twice_V is computed (set what it is computed from)"),
        ('{asks: "V {room_degC}"}', '"V {room_deg', "room_degC is an input (commands read it"),
        (
            '{asks: "V {relay}"}',
            '"V {relay}"}',
            "there is more than one relay (write which of them, as in {relay[n]})",
        ),
        ('{asks: "C {relay[n]}"}', '"C {relay[n]', "nothing says which relay it is (write {n}, too"),
        ('{asks: "V {relay[3]}"}', '"V {relay[3]', "there is no relay[3] (write 1 to 2)"),
        ('{asks: "V\\r"}', '"V\\r"}', "a line end is in it: this never comes"),
        ('{asks: "é"}', '"é"}', "'é' is no character of ascii"),
        ('{asks: "V?", answers: "{nope}"}', '"{nope}"}', 'there is no variable "nope"'),
        ('{asks: "V?", answers: "{level_V:q}"}', '"{level_V:q}', "'q' is no format"),
        ('{asks: "V?", answers: "{level_V + room_degC}"}', '"{level_V + ', "V and degC do not go together"),
        ('{asks: "V", when: "1 < 2"}', '"1 < 2"}', "when: 1 < 2 is always the same"),
        ('{asks: "V", sets: {level_V: way}}', "way}}", "level_V is a number, and this is a text"),
        ('{asks: "V", sets: {level_V: room_degC}}', "room_degC}}", "level_V is in V, and this in degC"),
        ('{asks: "V", sets: {twice_V: 1}}', "twice_V: 1}}", "twice_V is computed"),
        (
            '{asks: "V", sets: {relay: 1}}',
            "relay: 1}}",
            "relay does not stand so here (write it as relay[1])",
        ),
        (
            '{asks: "V {n}", takes: {n: {minimum: 5, maximum: 1}}}',
            "5, maximum: ",
            "the limits are reversed: 5 to 1",
        ),
        ('{asks: "V", answer: "1"}', 'answer: "1"}', 'unknown key (did you mean "answers"?'),
        ('{asks: "V", takes_ms: -1}', "-1}", "too small"),
    ],
)
def test_a_command_that_is_wrong(row: str, where: str, said: str) -> None:
    (found,) = problems(commands(row))
    assert found.startswith(f"{where[:12]} | dialogue.commands.0.")
    assert said in found


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ("{unit: V, minimum: 5, maximum: 1, about: x}", "the limits are reversed: 5 to 1"),
        ("{unit: mV, about: x}", "the name says V, and this mV (write unit: V, or another name)"),
        ("{unit: V, value: 20, maximum: 10, about: x}", "its first value: 20 is above 10"),
        ("{unit: V, about: x, computed: x_V + 1}", "these are computed from each other: x_V <- x_V"),
        ("{unit: V, about: x, computed: 1, input: true}", "computed and input both say its value"),
        ("{unit: V, about: x, follows: {target: 5}}", "nothing says how fast it follows"),
        ("{unit: V, about: x, kept: true, input: true}", "input says its value"),
        ("{type: choice, about: x}", "a choice needs its words"),
        ("{type: choice, choices: [a, b], value: c, about: x}", "'c' is none of the choices"),
        ("{type: switch, unit: V, about: x}", "a switch has no unit"),
        ("{type: text, maximum: 5, about: x}", "a text has no maximum"),
        ("{unit: V}", "this key is missing"),
        ("{unit: V, about: x, step: 0}", "too small"),
    ],
)
def test_a_variable_that_is_wrong(keys: str, said: str) -> None:
    (found,) = problems(TABLE + f"  variables:\n    x_V: {keys}\n" + ASK)
    assert said in found
    assert found.partition(" | ")[2].startswith("dialogue.variables.x_V")


@pytest.mark.parametrize("name", ["position_deg", "if", "A b", "error"])
def test_a_name_that_is_none(name: str) -> None:
    (found,) = problems(TABLE + f'  variables:\n    "{name}": {{about: x}}\n' + ASK)
    assert found.startswith(f'"{name}"'[:12])


def test_commands_that_never_come() -> None:
    said = problems(
        commands(
            '{asks: "V {label}"}',
            '{asks: "V {level_V}"}',
            '{asks: "A"}',
            '{asks: "A"}',
            '{asks: "B", when: "relay[1]"}',
            '{asks: "B"}',
            '{asks: "D {n}", takes: {n: {minimum: 0.2, maximum: 0.4}}}',
        )
    )
    assert said.pop().partition(" | ")[2] == (
        "dialogue.commands.6.asks: no command fits this (look at the limits of its values)"
    )
    assert [each.partition(" | ")[2] for each in said] == [
        "dialogue.commands.1.asks: this never comes: the one of line 13 takes all that fits it"
        " (write the more special one first, or give one a when:)",
        "dialogue.commands.3.asks: this never comes: the one of line 15 takes all that fits it"
        " (write the more special one first, or give one a when:)",
    ]


def test_scpi_forms_that_never_come() -> None:
    rows = ["[SOURce:]VOLTage?", "VOLT?", "VOLT;A"]
    text = TABLE + "  scpi: true\n  commands:\n" + "".join(f'    - {{asks: "{row}"}}\n' for row in rows)
    first, second = problems(text)
    assert "the one of line 7 takes all that fits it" in first
    assert "VOLT;A" in second


def test_all_is_said_at_once() -> None:
    text = (
        HEAD
        + "law: mechaduino\ndialogue:\n  ends_with: []\n  prefix: '#{n}'\n  shown_first: [x]\n"
        + "  variables:\n    a_V: {unit: mV, about: a}\n    b: {computed: c, about: b}\n"
        + "    c: {computed: b, about: c}\n"
        + "  messages: [{every_ms: 5, says: '{nope}'}]\n"
        + "  commands:\n    - {asks: '{'}\n    - {asks: 'V?', answers: '{a_V'}\n"
    )
    said = problems(text)
    lines = [each.partition(" | ")[2].partition(" (")[0] for each in said]
    assert lines == [
        "law: a board by a table has no law",
        "dialogue: nothing says where a command ends",
        'dialogue.prefix: there is no variable "n"',
        'dialogue.shown_first.0: there is no variable "x" with a number',
        "dialogue.variables.a_V.unit: the name says V, and this mV",
        "dialogue.variables.b.computed: these are computed from each other: b <- c <- b",
        'dialogue.messages.0.says: there is no variable "nope"',
        "dialogue.commands.0.asks: a { has no }",
        "dialogue.commands.1.answers: a { has no }",
    ]


def test_messages_that_the_line_cannot_carry() -> None:
    (found,) = problems(TABLE + "  messages: [{every_ms: 5, says: '0123456789'}]\n" + ASK)
    assert "it takes 12.5 ms at 9600 baud, and comes each 5 ms" in found


@pytest.mark.parametrize("name", ["power_supply", "temperature_controller", "relay_card"])
def test_signs_in_quotes_leave_a_table_to_the_fast_parser(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(yaml_text, "_compose_slowly")
    file = Path(__file__).parents[3] / "examples/instruments/boards" / name / "profile.yaml"
    assert profile_from_yaml(file.read_text(), Path(name)).name == name


def test_a_table_is_read_in_20_ms() -> None:
    text = (Path(__file__).parents[3] / "examples/instruments/boards/power_supply/profile.yaml").read_text()
    profile_from_yaml(text, Path("power_supply"))
    taken = []
    for _ in range(5):
        begin = time.process_time()
        profile_from_yaml(text, Path("power_supply"))
        taken.append(time.process_time() - begin)
    assert min(taken) < 0.020
