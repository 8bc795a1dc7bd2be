"""Keywords that are rows of the table of operations: names here, arguments and their types from there."""

from collections.abc import Callable
from inspect import Parameter as Argument
from inspect import Signature
from typing import Any, Literal, NamedTuple

from hil.operations.table import OBJECT, OPERATIONS, VALUE, WHICH
from hil.robot.bench_kind import AtBench, refusals
from hil.vocab.operation import Operation
from hil.vocab.parameters import Parameter


class Worded(NamedTuple):
    """Row of the table of operations as a keyword: its name, what it does, and an example."""

    name: str
    about: str
    example: str


KEYWORDS = {
    "state": Worded(
        "Axis State",
        "Answer all fields of an axis now, as a dictionary.",
        "| ${state} =    Axis State    m1\n| Should Be True    ${state}[u] < 10",
    ),
    "reset": Worded("Power Cycle", "Switch a device's power off and on.", "| Power Cycle    m1"),
    "pin": Worded("Set Pin", "Drive an input of a board.", "| Set Pin    m1    D2    1"),
    "set": Worded(
        "Set Field",
        "Set a field of an axis: a load, a gain.",
        "| Set Field    m1    load_torque_Nm    0.05",
    ),
    "zero": Worded(
        "Zero Axis",
        "Let the angle of an axis be 0 where the shaft is. Nothing turns.",
        "| Zero Axis    m1",
    ),
    "do": Worded(
        "Do Verb",
        "Carry out a verb of a device. Answers its result; does not wait for a motion's end.",
        "| Do Verb    m1    move_abs    position_deg=90",
    ),
    "inject": Worded(
        "Inject Fault",
        "Inject a fault. Answers its number, for `Clear Fault`.",
        "| ${fault} =    Inject Fault    m1    encoder_freeze\n"
        "| Inject Fault    s1.network    packet_nak    rate=0.5",
    ),
    "clear": Worded(
        "Clear Fault",
        "End a fault, or ``all``.",
        "| Clear Fault    ${fault}\n| Clear Fault    all",
    ),
    "faults": Worded(
        "Active Faults",
        "Answer the faults that are active, a dictionary for each.",
        "| ${faults} =    Active Faults\n| Should Be Empty    ${faults}",
    ),
}
"""Keywords by operation."""


def _type(parameter: Parameter) -> Any:
    if parameter.form is OBJECT:
        return Any  # a verb's or a fault's own: `_number_or_text`
    if parameter.form is WHICH:
        return int | Literal["all"]
    if parameter.form is VALUE:
        return float
    if parameter.choices:
        return Literal[(*parameter.choices, *parameter.also)]
    return str if parameter.is_text else int if parameter.is_whole else float


def _argument(parameter: Parameter) -> Argument:
    if parameter.form is OBJECT:
        return Argument(parameter.name, Argument.VAR_KEYWORD)
    default = Argument.empty if parameter.default is None else parameter.default
    return Argument(parameter.name, Argument.POSITIONAL_OR_KEYWORD, default=default)


def asking(operation: Operation) -> Callable[..., Any]:
    """Make the keyword of an operation."""
    worded = KEYWORDS[operation.name]
    of_target = operation.target.argument
    targets = [Argument(of_target, Argument.POSITIONAL_OR_KEYWORD)] if of_target else []
    signature = Signature(
        [Argument("self", Argument.POSITIONAL_ONLY), *targets, *map(_argument, operation.parameters)]
    )

    def ask(self: AskedKeywords, *values: Any, **named: Any) -> Any:
        bound = signature.bind(self, *values, **named)
        bound.apply_defaults()
        given = dict(bound.arguments)
        if "parameters" in given:
            given["parameters"] = {each: _number_or_text(of) for each, of in given["parameters"].items()}
        target = given.pop(of_target, "") if of_target else ""
        del given["self"]
        with refusals():
            answer = self._kind.ask(operation, target, given)
        return answer["number"] if operation.name == "inject" else answer

    described = [f"- ``{of_target}``: {operation.target.value[1]}"] if of_target else []
    described += [f"- ``{each.name}``: {_described(each)}" for each in operation.parameters]
    ask.__doc__ = "\n\n".join(filter(None, (worded.about, "\n".join(described), worded.example)))
    ask.__signature__ = signature  # type: ignore[attr-defined]
    ask.__annotations__ = {of_target: str} if of_target else {}
    ask.__annotations__ |= {each.name: _type(each) for each in operation.parameters}
    return ask


def _described(parameter: Parameter) -> str:
    return f"{parameter.about}, as name=value" if parameter.form is OBJECT else parameter.described()


def _number_or_text(value: Any) -> Any:
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


class AskedKeywords(AtBench):
    """Keywords of the table of operations."""


for _name, _worded in KEYWORDS.items():
    setattr(AskedKeywords, _worded.name.lower().replace(" ", "_"), asking(OPERATIONS[_name]))
