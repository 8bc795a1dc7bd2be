"""Model of ``dialogue`` in a ``profile.yaml``: a board by a table of commands and answers."""

from typing import Annotated, Literal

from pydantic import Field

from hil.config.explain import StrictModel
from hil.vocab.own_fields import MOST

_Many = Annotated[int | None, Field(ge=1, le=32)]
_Text = Annotated[str, Field(max_length=1000)]
_Formula = str | float


class FollowInfo(StrictModel):
    """Value after which a variable goes as time passes."""

    target: _Formula = Field(description="Value that it goes to, an expression.")
    time_constant_s: _Formula | None = Field(
        default=None,
        description="Time constant of a first-order lag, in s, an expression: after it 63 % of the way "
        "are done.",
    )
    rate_per_s: _Formula | None = Field(
        default=None,
        description="Most by which it changes in a second, an expression, instead of a time constant: a "
        "ramp.",
    )


class ParameterInfo(StrictModel):
    """Value of a command's own, which is no variable."""

    type: Literal["number", "whole", "switch", "text", "choice"] = Field(
        default="whole", description="Kind of value."
    )
    unit: str = Field(default="", max_length=16, description="Unit of a number.")
    minimum: float | None = Field(
        default=None, ge=-MOST, le=MOST, description="Least number; beyond it the command is out of range."
    )
    maximum: float | None = Field(default=None, ge=-MOST, le=MOST, description="Greatest number.")
    choices: list[str] | None = Field(
        default=None, min_length=1, max_length=100, description="Words of a choice."
    )


class VariableInfo(ParameterInfo):
    """Variable of an instrument. All but texts are fields of the board, as `fields:` are."""

    about: str = Field(description='Meaning, as in "voltage at the output".')
    type: Literal["number", "whole", "switch", "text", "choice"] = Field(
        default="number",
        description="Kind of value: a number, a whole number, a switch, which is 0 or 1, a text, or one "
        "of `choices`.",
    )
    value: float | str = Field(
        default=0.0, description="Value at power-up: a number, a text, or a choice's word."
    )
    step: float | None = Field(default=None, gt=0, description="Step to which a command's value is rounded.")
    many: _Many = Field(
        default=None,
        description="Number of variables of this name, as channels have them: `relay` becomes the "
        "fields `relay1`, `relay2`. Patterns and expressions have them as `relay[1]` and `relay[n]`.",
    )
    kept: bool = Field(default=False, description="True if its value stays without power.")
    input: bool = Field(
        default=False,
        description="True if it is the world around the board: `hil set`, tests and bridges set it, "
        "commands do not.",
    )
    computed: _Formula | None = Field(
        default=None, description="Expression that it always is; with `many`, `n` is its number."
    )
    follows: FollowInfo | None = Field(
        default=None, description="Value after which it goes slowly, as a temperature after its set-point."
    )
    longest: int = Field(default=64, ge=1, le=1000, description="Most characters of a text.")


class CommandInfo(StrictModel):
    """Command: what is typed, what it does, what is answered."""

    asks: _Text = Field(
        description="Pattern: text, with places such as `{voltage_V}`, which sets the variable, `{n}`, "
        "a value of `takes` or the number of one of several variables, `{relay[n]:OFF|ON}`, `{n:02d}`, a "
        "fixed number of digits, and `{=address:02d}`, which has to be the present value."
    )
    answers: _Text | list[_Text] | None = Field(
        default=None,
        description="Answer, or several, each with its line end: text with expressions such as "
        "`{voltage_V:.3f}`, `{output:OFF|ON}`. Left out: it is not answered.",
    )
    when: _Formula | None = Field(
        default=None, description="Condition; where it does not hold, the row is passed over."
    )
    sets: dict[str, _Formula] = Field(
        default={},
        description="Variables that it sets beside those of its places, each with an expression, one "
        "after the other.",
    )
    takes: dict[str, ParameterInfo] = Field(
        default={}, description="PresentValues of its own, by the names of their places."
    )
    takes_ms: float | None = Field(
        default=None,
        ge=0,
        le=3600000,
        description="Time that it takes, instead of the table's `answer_after_ms`; what it sets is set then.",
    )
    clears_errors: bool = Field(
        default=False, description="True if it empties the queue of errors and the event register, as `*CLS`."
    )


class MessageInfo(StrictModel):
    """Text that the instrument sends by itself."""

    every_ms: float = Field(ge=1, le=86400000, description="Time from one to the next.")
    says: _Text = Field(description="Text with expressions, as an answer.")
    when: _Formula | None = Field(default=None, description="Condition on which it is sent.")


class ErrorsInfo(StrictModel):
    """Texts of errors. Without `scpi` each is answered, and one that is left out is not; with it they wait in
    the queue, and those that are left out are SCPI's."""

    unknown: str | None = Field(default=None, description="There is no such command.")
    bad_value: str | None = Field(
        default=None,
        description="The command is there, and what comes after it does not fit; left out without "
        "`scpi`: as `unknown`.",
    )
    missing_value: str | None = Field(
        default=None,
        description="With `scpi`: a value is missing. Left out where `bad_value` is given: as that; so "
        "the next three.",
    )
    extra_value: str | None = Field(default=None, description="With `scpi`: there is a value too many.")
    bad_suffix: str | None = Field(
        default=None, description="With `scpi`: the unit of a number is another, or none."
    )
    bad_word: str | None = Field(
        default=None, description="With `scpi`: the word is none of a switch or a choice."
    )
    out_of_range: str | None = Field(default=None, description="The value is beyond its limits.")
    wrong_state: str | None = Field(default=None, description="The condition `when` does not hold.")
    overflow: str | None = Field(
        default=None, description="Text that replaces the last error when the queue is full."
    )
    none: str | None = Field(default=None, description="Answer of a queue without errors.")


class CheckSumInfo(StrictModel):
    """Check sum at the end of each command and answer. One that is wrong is not answered."""

    kind: Literal["xor", "sum", "crc16"] = Field(
        description="Sum of all bytes before it: `xor`, `sum` (8 bits), or `crc16`, Modbus's."
    )
    form: Literal["hex", "bytes"] = Field(
        default="hex", description="Form: digits in base 16, in capital letters, or bytes."
    )


class DialogueExampleInfo(StrictModel):
    """Exchange that `hil profile check` tries, one after the other."""

    types: str = Field(description="Command, without its line end.")
    answer: str = Field(description="Text that has to be in what is sent then.")
    within_ms: float = Field(default=1000.0, gt=0, le=600000, description="Time after which it has come.")


class DialogueInfo(StrictModel):
    """Instrument that asks and answers, as a table."""

    scpi: bool = Field(
        default=False,
        description="True for SCPI's forms: headers long or short and in any case, `[SOURce:]VOLTage?`, "
        "several commands in a line by `;`, words and units of numbers, `SYST:ERR?` with a queue of "
        "errors, and the common commands of IEEE 488.2 with its status registers, which rows of the table "
        "go before.",
    )
    ends_with: list[str] | None = Field(
        default=None,
        max_length=8,
        description="Line ends of commands: CR, LF, CRLF, or a text. Default: CR and LF, so that CRLF "
        "does, too.",
    )
    answers_end_with: str | None = Field(
        default=None,
        description='Line end of answers: CR, LF, CRLF, a text, or "" for none. Default: CRLF; with '
        "`encoding: hex` none.",
    )
    command_bytes: int = Field(
        default=0, ge=0, le=1000, description="Bytes of each command, instead of line ends; 0: line ends."
    )
    begins_with: str = Field(
        default="",
        max_length=16,
        description="Text with which each command begins; what comes before it is dropped.",
    )
    ends_after_ms: float = Field(
        default=0.0, ge=0, le=60000, description="Silence that ends a command; 0: none does."
    )
    longest: int = Field(
        default=256, ge=1, le=4096, description="Most characters of a command; one with more is unknown."
    )
    encoding: Literal["ascii", "latin-1", "utf-8", "hex"] = Field(
        default="ascii",
        description="Encoding of texts; `hex`: patterns and answers are bytes in base 16, as in `FF {n} "
        "{relay[n]}`.",
    )
    ignore_case: bool = Field(
        default=False, description="True if small letters of commands are as good as capital ones."
    )
    echo: bool = Field(default=False, description="True if it sends back each byte that it reads.")
    answer_after_ms: float = Field(
        default=0.0,
        ge=0,
        le=3600000,
        description="Time that a command takes. Meanwhile bytes wait in the receive buffer; what has no "
        "room is lost.",
    )
    prefix: str = Field(
        default="",
        max_length=64,
        description="Pattern with which a command for this board begins, as in `#{=address:02d}`; "
        "others it ignores.",
    )
    answer_prefix: str = Field(
        default="", max_length=64, description="Text with which each answer begins, with expressions."
    )
    checksum: CheckSumInfo | None = Field(
        default=None, description="Check sum at the end of each command and answer: `kind` and `form`."
    )
    variables: dict[str, VariableInfo] = Field(default={}, max_length=64, description="Variables by name.")
    commands: list[CommandInfo] = Field(
        min_length=1, max_length=1000, description="Commands. The first that fits is taken."
    )
    errors: ErrorsInfo = Field(
        default=ErrorsInfo.model_construct(), description="Texts of errors, by their kinds."
    )
    queue: int = Field(
        default=20, ge=1, le=1000, description="Errors that wait with `scpi`; one more replaces the last."
    )
    messages: list[MessageInfo] = Field(
        default=[], max_length=32, description="Texts that it sends by itself."
    )
    greeting: str = Field(default="", description="Text that it sends once it is ready.")
    ready_after_ms: float = Field(
        default=0.0, ge=0, le=600000, description="Time from power-up on in which it hears nothing."
    )
    update_ms: float = Field(
        default=100.0,
        ge=1,
        le=60000,
        description="Time between two updates of slow and computed variables, beside those at commands.",
    )
    shown_first: list[str] | None = Field(
        default=None, description="Variables that short lists show; default: the first four."
    )
    examples: list[DialogueExampleInfo] = Field(
        default=[], description="Exchanges that `hil profile check` tries."
    )


SECTIONS = (
    ("Board by a table: `dialogue` of a `profile.yaml`", DialogueInfo),
    ("Variables of a table: `dialogue.variables.<name>`", VariableInfo),
    ("What a variable goes after: `follows`", FollowInfo),
    ("Commands of a table: `dialogue.commands`", CommandInfo),
    ("PresentValues of a command's own: `takes`", ParameterInfo),
    ("Messages of a table: `dialogue.messages`", MessageInfo),
    ("Errors of a table: `dialogue.errors`", ErrorsInfo),
    ("Check sum of a table: `dialogue.checksum`", CheckSumInfo),
    ("Examples of a table: `dialogue.examples`", DialogueExampleInfo),
)
"""Models with the titles of their sections in the reference."""
