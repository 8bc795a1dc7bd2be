"""Parameters of a firmware's build, as ``parameters`` of a ``profile.yaml`` describes them: what the board's
user edits in its sources before the upload."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field

from hil.config.document import Finding, KeyPath
from hil.config.explain import StrictModel, no_such, not_allowed
from hil.vocab.parameters import Parameter, plain

PARAMETERS_KEY = "parameters"
BuildValue = str | float
BuildValues = Annotated[
    Mapping[str, BuildValue],
    Field(
        description="What the build of its firmware fixes, where it differs from the profile's, as in"
        " `{spr: 400, pKp: 20}`: constants that the board's user edits in the sources."
    ),
]
"""Key of a device: values by the names of parameters."""


class BuildParameter(StrictModel):
    """Constant in the sources of a board's firmware: a number, one of some words, or a text."""

    about: str
    """Meaning, as in "full steps in a turn of the motor"."""
    source: str
    value: BuildValue | None = None
    """Value in the sources as they are; None: the firmware makes it of the others."""
    unit: str = ""
    minimum: float = 0.0
    maximum: float = 1e6
    whole: bool = False
    choices: tuple[str, ...] = Field(default=(), strict=False)
    """Words that it may be, instead of a number."""
    text_length: int = Field(default=0, ge=0, le=1000)
    """Maximum length of a text, instead of a number; 0: it is no text."""

    def made(self, name: str) -> Parameter:
        """Make the parameter that checks values."""
        return Parameter(
            name,
            self.about,
            self.unit,
            self.minimum,
            self.text_length or self.maximum,
            self.value,
            self.choices,
            is_text=bool(self.text_length),
            is_whole=self.whole,
            is_optional=self.value is None,
        )

    def values(self) -> str:
        """Text of the values that it may have."""
        if self.choices:
            return ", ".join(f"`{each}`" for each in self.choices)
        if self.text_length:
            return f"text, at most {self.text_length} characters"
        return f"{'whole, ' * self.whole}{plain(self.minimum)} to {plain(self.maximum)}"

    def json_values(self) -> dict[str, Any]:
        """JSON Schema of its values in a device."""
        described: dict[str, Any] = {"description": f"{self.about}. Source: {self.source}."}
        if self.value is not None:
            described["default"] = self.value
        if self.choices:
            return described | {"enum": list(self.choices)}
        if self.text_length:
            return described | {"type": "string", "maxLength": self.text_length}
        kind = "integer" if self.whole else "number"
        return described | {"type": kind, "minimum": self.minimum, "maximum": self.maximum}

    def shown_default(self) -> str:
        """Text of its value in the sources."""
        if self.value is None:
            return "of the others"
        return self.value if isinstance(self.value, str) else f"{self.value:g}"


def built(parameters: Mapping[str, BuildParameter], given: Mapping[str, BuildValue]) -> dict[str, BuildValue]:
    """Answer the values of a device's build: the sources' with its own in their place. Those that the
    firmware makes of the others are missing."""
    usual = {name: each.value for name, each in parameters.items() if each.value is not None}
    return usual | dict(given)


def build_findings(
    path: KeyPath, given: Any, parameters: Mapping[str, BuildParameter], profile: str
) -> Iterator[Finding]:
    """Findings about the values that a device at a path gives to its firmware's parameters."""
    for name, value in given.items() if isinstance(given, dict) else ():
        place = (*path, PARAMETERS_KEY, name)
        if not parameters:
            message = f"the firmware of a {profile} has no parameters of its build"
            yield Finding(place, message, "leave this key out", at_key=True)
        elif name not in parameters:
            yield no_such(place, "parameter of its build", str(name), parameters)
        elif problem := parameters[name].made(name).problem(value):
            yield not_allowed(place, value, problem)


def own_value_findings(parameters: Mapping[str, BuildParameter]) -> Iterator[Finding]:
    """Findings about values in a ``profile.yaml`` that its own limits do not allow."""
    for name, each in parameters.items():
        if each.value is not None and (problem := each.made(name).problem(each.value)):
            yield not_allowed((PARAMETERS_KEY, name, "value"), each.value, problem)
