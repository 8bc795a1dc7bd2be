"""Parameters of faults and verbs: meaning, unit and limits; and the check of given values."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from hil.vocab.late_dataclass import dataclass
from hil.vocab.near_words import did_you_mean, meant, nearest
from hil.vocab.typed_numbers import number_problem, quoted


class Form(NamedTuple):
    """Form of a value that is no number, word or text."""

    about: str
    fits: Callable[[Any], bool]


_LONG = 10**12
"""Magnitude from which a whole number is too long to be read digit by digit."""


@dataclass(frozen=True)
class Parameter:
    """A number, a choice or a text that something takes."""

    name: str
    about: str
    unit: str = ""
    minimum: float = 0.0
    maximum: float = 1.0
    default: float | str | None = None
    """Default value; None: it has to be given, unless ``is_optional``."""
    choices: tuple[str, ...] = ()
    """Allowed words; if there are any, it takes one of these instead of a number."""
    also: tuple[str, ...] = ()
    """Other words for the choices, in their order: taken, and read as the choice."""
    is_text: bool = False
    """True if the value is a text of at most ``maximum`` characters instead of a number."""
    is_whole: bool = False
    is_optional: bool = False
    """True if the parameter may be left out, and then has no value."""
    limits: str = ""
    """Text of the limits, where the target sets them; all are within ``minimum`` and ``maximum``."""
    form: Form | None = None
    """Form of the value, instead of a number."""

    def problem(self, value: object) -> str | None:
        """Error text for a value: what is wrong with it, and what to write; None for a good one."""
        wrong = self.wrong(value)
        return f"{wrong[0]}; {wrong[1]}" if wrong else None

    def wrong(self, value: object) -> tuple[str, str] | None:
        """Problem of a value and its remedy, or None for a good one."""
        if self.form:
            fits = self.form.fits(value)
            return None if fits else (f"{quoted(value)} is not of its form", f"write {self.form.about}")
        if self.choices:
            return None if value in self.choices else self._no_choice(value)
        if self.is_text:
            return self._wrong_text(value)
        if isinstance(value, str):
            return number_problem(value, self.unit, self._with_unit)
        if isinstance(value, bool) or not isinstance(value, int | float):
            return f"{quoted(value)} is no number", f"write {self._with_unit}"
        if not self.minimum <= value <= self.maximum:  # not a number is not in between either
            size = "no number" if value != value else "too small" if value < self.minimum else "too large"
            return f"{quoted(value)} is {size}", f"write {self._with_unit}"
        if self.is_whole and value != int(value):
            return f"{quoted(value)} is not whole", f"write a whole number, {self._with_unit}"
        return None

    def _no_choice(self, value: object) -> tuple[str, str]:
        near = did_you_mean(nearest(str(value), (*self.choices, *self.also)))
        return f"there is no {quoted(value)} here", f"{near} write {' or '.join(self.choices)}".lstrip()

    def _wrong_text(self, value: object) -> tuple[str, str] | None:
        remedy = f"write a text of at most {plain(self.maximum)} characters"
        if not isinstance(value, str):
            return f"{quoted(value)} is no text", remedy
        return None if len(value) <= self.maximum else (f"its {len(value)} characters are too many", remedy)

    @property
    def _with_unit(self) -> str:
        return f"{self._range} {self.unit}".rstrip() if not self.limits else self.limits

    @property
    def _range(self) -> str:
        return self.limits or f"{plain(self.minimum)} to {plain(self.maximum)}"

    @property
    def values(self) -> str:
        """Values that it takes, with their unit, in a few words."""
        if self.form:
            return self.form.about
        if self.is_text:
            return f"a text of at most {plain(self.maximum)} characters"
        return " or ".join(self.choices) or self._with_unit

    def described(self) -> str:
        """Text of values, unit and default, in one line."""
        values = " or ".join(self.choices) or self._range
        if self.also:
            values += f" (also {' or '.join(self.also)})"
        if self.is_text:
            values = f"text, at most {plain(self.maximum)} characters"
        if self.form:
            values = self.form.about
        unit = f"{', in' if self.limits else ''} {self.unit}" if self.unit else ""
        default = "needed" if self.default is None else f"default {self.default}"
        if self.is_optional or self.default == "" or self.default is False:
            default = "may be left out"
        return f"{self.about}, {values}{unit}, {default}"


def plain(bound: float) -> str:
    """Format a bound so that it can be read and typed: 1000000, 0.001, 2^53, 1e18."""
    if float(bound).is_integer() and abs(bound) < _LONG:
        return str(int(bound))
    if float(bound).is_integer() and (whole := int(bound)) & (whole - 1) == 0 < whole:
        return f"2^{whole.bit_length() - 1}"
    return f"{bound:g}".replace("e+", "e").replace("e0", "e").replace("e-0", "e-")


Values = dict[str, Any]


def filled(
    what: str, parameters: Sequence[Parameter], given: Mapping[str, object]
) -> tuple[Values, dict[str, str]]:
    """Fill in the defaults: the values, and the errors by the name of the parameter."""
    problems: dict[str, str] = {}
    values: Values = {}
    names = {parameter.name: parameter for parameter in parameters}
    slips = {name: nearest(name, names) for name in given if name not in names}
    for name in slips:
        there = f"parameters of {what} are {', '.join(names) or 'none'}"
        problems[name] = f"there is no such parameter; {meant(name, names, there)}"
    for name, parameter in names.items():
        value = given.get(name, parameter.default)
        if value in parameter.also:
            value = dict(zip(parameter.also, parameter.choices, strict=True))[str(value)]
        if value is None:
            if not parameter.is_optional and name not in slips.values():
                problems[name] = f"this one is missing: {parameter.about}; write {parameter.values}"
        elif problem := parameter.problem(value):
            problems[name] = problem
        else:
            values[name] = value
    return values, problems
