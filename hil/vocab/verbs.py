"""Verbs of devices: what can be asked of one from outside its serial port, beside typing at it.

``Profile.verbs`` has those of a kind of board; ``COMMON`` is what every twin has beside them.
The one table drives the command line, the bridges, the reference and the check of permissions.
"""

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Any

from hil.vocab.late_dataclass import dataclass
from hil.vocab.parameters import Parameter, Values, filled

HOW_TO_STOP = Parameter(
    "how",
    "a controlled stop, with a ramp, or an immediate one",
    choices=("grace", "prejudice"),
    also=("controlled", "immediate"),
    default="grace",
)
"""Parameter of verbs that stop: the two ``hil.vocab.axis.How``."""


class Role(IntEnum):
    """Roles of askers, ascending: each may do what those before it may."""

    VIEWER = 1
    OPERATOR = 2
    ADMIN = 3


class Effect(IntEnum):
    """Effect of a verb on the set-point's time-out."""

    NONE = 0
    STREAM = 1
    """A set-point, after which the next one is awaited."""
    ENDS = 2
    """Another motion, or the end of all: no set-point is awaited any more."""


@dataclass(frozen=True)
class Verb:
    """Request that a device understands. ``run(firmware, **parameters)`` carries it out at the present
    simulated time and answers the asker; None for those of ``COMMON``, which are inputs of other kinds, and
    for those that type."""

    name: str
    about: str
    parameters: tuple[Parameter, ...] = ()
    run: Callable[..., Mapping[str, float | str | int] | None] | None = None
    effect: Effect = Effect.NONE
    role: Role = Role.OPERATOR
    types: bytes = b""
    """Bytes typed at the board's first UART instead of ``run``, for its main program to handle."""
    is_of_axis: bool = False
    """True if the verb is asked of one axis: ``run`` of a board with several gets ``axis``, the axis's
    name."""

    def filled(self, given: Mapping[str, object]) -> Values:
        """Fill in the parameters' defaults. Raises VerbRefused, with all problems of what was given."""
        return checked(self.name, self.parameters, given)


def checked(what: str, parameters: tuple[Parameter, ...], given: Mapping[str, object]) -> Values:
    """Fill in the defaults of what was given. Raises VerbRefused, with all problems."""
    values, problems = filled(what, parameters, given)
    if problems:
        text = "; ".join(f"{name}: {problem}" for name, problem in problems.items())
        raise VerbRefused("bad_parameter", text)
    return values


class VerbRefused(Exception):
    """Refusal of a request, which is not carried out: ``str(error)`` says why and what to do. ``code`` is one
    of ``CODES``."""

    def __init__(self, code: str, why: str) -> None:
        super().__init__(why)
        self.code = code


OF_TEXTS = ("bad_run", "bad_config")
"""Codes of refusals that list the problems of a text."""
CODES = {
    "bad_request": "the payload is no JSON object, or is too large",
    "no_device": "there is no such device, or it has no such serial interface",
    "no_place": "there is no such port, tap or segment",
    "no_verb": "there is no such verb, or the device has none",
    "no_parameter": "the axis has no such parameter, or it cannot be set",
    "bad_parameter": "a parameter is missing, unknown, of the wrong type or out of its limits",
    "not_now": "the board is not in a state for it",
    "busy": "too many requests wait already, of this asker or of all; ask again later",
    "cannot": "this board cannot do it at all",
    "forbidden": "the sender may not do it",
    "leased": "somebody else has the bench for now; the text has who, until when, and why",
    "failed": "the device's firmware has stopped",
    "no_run": "there is no such run",
    "bad_run": "a run cannot be done as it is written; the text lists all problems with line and column",
    "bad_config": "the configuration has problems; the text lists them all with line and column",
}
"""Codes of refusals, which do not change; the texts beside them may."""
NOT_MISTAKES = ("not_now", "busy", "cannot", "forbidden", "leased", "failed")
"""Codes with which a bench or board refuses a request that is right as it is written; all others are for
wrong names, values and texts."""

COMMON = (
    Verb(
        "type",
        "type at the board's serial interface, as a client does",
        (
            Parameter(
                "text", r"what is typed; \r, \n, \t and \xHH are taken as such", maximum=4096, is_text=True
            ),
        ),
    ),
    Verb("reset", "switch the power off and on; what is in the flash stays", effect=Effect.ENDS),
    Verb(
        "pin",
        "drive an input",
        (
            Parameter("pin", "its name", maximum=16, is_text=True),
            Parameter("level", "low or high", is_whole=True, limits="0 or 1"),
        ),
    ),
    Verb(
        "zero",
        "let the shaft's angle, position_deg, be 0 here; nothing turns, and the board knows nothing of it",
        is_of_axis=True,
    ),
)


def table_of(verbs: tuple[Verb, ...]) -> dict[str, Verb]:
    """Index a profile's verbs and the common ones by name."""
    return {verb.name: verb for verb in (*verbs, *COMMON)}


def described(verbs: Mapping[str, Verb]) -> list[dict[str, Any]]:
    """Describe the table for clients; ``texts``: parameters that are no numbers, whatever they look like."""
    return [
        {
            "verb": verb.name,
            "about": verb.about,
            "role": verb.role.name.lower(),
            "parameters": {p.name: p.described() for p in verb.parameters},
            "texts": [p.name for p in verb.parameters if p.is_text],
        }
        for verb in verbs.values()
    ]
