"""Parameters of verbs in holding registers: preset with their defaults, checked when they are written."""

from math import isnan, nan
from typing import Any

from bridges.modbus.protocol.pdu import Code, Refused
from bridges.modbus.registers import layout
from bridges.modbus.registers.cells import NO_I32, Cell, ordered, value_of, words_of
from bridges.modbus.registers.register_map import RegisterMap, parameter_type
from hil.vocab.parameters import Parameter


class VerbParameters:
    """Parameters of all verbs of a map. ``is_low_first``: order of the words."""

    def __init__(self, of: RegisterMap, is_low_first: bool) -> None:
        self._map = of
        self._is_low_first = is_low_first
        self._words: dict[int, int] = {}
        self._parameters: dict[int, Parameter] = {}
        for number, verb in of.verbs.items():
            for at, parameter in enumerate(verb.parameters):
                address = _address_of(number, at)
                self._parameters[address] = parameter
                self.put(address, _preset(parameter))

    def word(self, address: int) -> int:
        """Word of a register; 0 where no parameter has one."""
        return self._words.get(address, 0)

    def check(self, cell: Cell, value: float) -> None:
        """Check a parameter's value. Raises Refused."""
        parameter = self._parameters[cell.address]
        if _is_left_out(cell.type, value):
            return
        if parameter.choices:
            if not 0 <= value < len(parameter.choices):
                raise Refused(Code.ILLEGAL_DATA_VALUE, f"{cell.name}: {int(value)} is none of its choices")
        elif problem := parameter.problem(value):
            raise Refused(Code.ILLEGAL_DATA_VALUE, f"{cell.name}: {problem}")

    def put(self, address: int, value: float) -> None:
        """Keep the value of the parameter whose first register this is."""
        words = ordered(words_of(parameter_type(self._parameters[address]), value), self._is_low_first)
        self._words |= dict(enumerate(words, address))

    def given(self, number: int) -> dict[str, Any]:
        """Parameters of a verb by name, without those left out."""
        given: dict[str, Any] = {}
        for at, parameter in enumerate(self._map.verbs[number].parameters):
            first, kind = _address_of(number, at), parameter_type(parameter)
            words = tuple(self._words[first + i] for i in range(layout.PER_PARAMETER))
            value = value_of(kind, ordered(words, self._is_low_first))
            if not _is_left_out(kind, value):
                given[parameter.name] = parameter.choices[int(value)] if parameter.choices else value
        return given


def argument_address(command: int, address: int) -> int:
    """Address of the parameter's register for which one of the command block stands."""
    return _address_of(command - 1, 0) + address - layout.ARGUMENTS_AT


def _address_of(number: int, at: int) -> int:
    return layout.PARAMETERS_AT + number * layout.PER_VERB + at * layout.PER_PARAMETER


def _preset(parameter: Parameter) -> float:
    kind = parameter_type(parameter)
    if parameter.default is None:
        return NO_I32 if kind == "i32" else nan
    if parameter.choices:
        return parameter.choices.index(str(parameter.default))
    return float(parameter.default)


def _is_left_out(kind: str, value: float) -> bool:
    return value == NO_I32 if kind == "i32" else isnan(value)
