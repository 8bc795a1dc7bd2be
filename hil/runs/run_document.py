"""Document of a run: axes with limits, and steps. YAML or JSON, checked with the place of each mistake."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationError
from pydantic_core import PydanticCustomError

from hil.config.document import Document, Finding, document_from_mapping
from hil.config.document_kinds import RUN, check_kind
from hil.config.explain import StrictModel, findings_of
from hil.config.port_model import Name
from hil.config.reference_page import keys_table
from hil.config.yaml_text import document_from_yaml
from hil.vocab.address import NAME_PATTERN
from hil.vocab.parameters import filled
from hil.vocab.problem import ConfigError
from hil.vocab.verbs import HOW_TO_STOP

DOCUMENT_BYTES = 1 << 20
AXES = 64
STEPS = 10_000
"""Maximum number of steps of a run, repetitions counted."""
_DAY_S = 86_400.0

_NAME = NAME_PATTERN.strip("^$")
AXIS_PATTERN = rf"^({_NAME}/)?{_NAME}([.]{_NAME})?$"
"""Pattern of an axis's address, or of one of another bench: ``lathe/m1``."""

AxisName = Annotated[str, Field(pattern=AXIS_PATTERN)]
Angle = Annotated[float, Field(ge=-1e6, le=1e6)]
Seconds = Annotated[float, Field(ge=0, le=_DAY_S)]


class AxisRules(StrictModel):
    """Limits of an axis in this run."""

    velocity_rpm: float = Field(
        default=60.0,
        gt=0,
        le=3000,
        description="Largest speed; of a board that makes ramps of its own one that its `move_abs` takes."
        " Left out, and the board takes no 60: the board's own default.",
    )
    acceleration_rpm_per_s: float = Field(
        default=600.0,
        gt=0,
        le=1e6,
        description="Largest acceleration; one that the board's `stop` takes, if that takes any.",
    )
    jerk_rpm_per_s2: float = Field(
        default=12_000.0,
        gt=0,
        le=1e9,
        description="Largest change of acceleration in a second; S-curves only.",
    )
    min_deg: Angle = Field(default=-1e6, description="Smallest position that may be planned.")
    max_deg: Angle = Field(default=1e6, description="Largest position that may be planned.")
    following_error_deg: float | None = Field(
        default=None,
        gt=0,
        le=1e6,
        description="The axis fails if it is farther from its set-point; null: never.",
    )


class WaitUntil(StrictModel):
    """Condition that a field of an axis is in a range."""

    axis: AxisName
    field: str = Field(description="A field of the axis, as in `position_deg`.")
    above: float | None = Field(default=None, description="The wait ends when the field is this or more.")
    below: float | None = Field(
        default=None, description="The wait ends when the field is this or less; with both: in between."
    )
    timeout_s: float = Field(default=10.0, gt=0, le=_DAY_S, description="The run fails after this time.")


class Repeat(StrictModel):
    """Do steps again."""

    label: Name = Field(description="Repeat the steps from the one with this label to the one before this.")
    times: int = Field(ge=1, le=STEPS, description="Number of repetitions.")


class SplinePoint(BaseModel):
    """Positions of axes, and when, seconds from the spline's start; without times the limits say when."""

    model_config = ConfigDict(strict=True, extra="allow", frozen=True, allow_inf_nan=False)

    at_s: Seconds | None = Field(default=None, description="When, in seconds from the spline's start.")

    @property
    def positions_deg(self) -> Mapping[str, Any]:
        """Positions by the names of axes."""
        return self.model_extra or {}


class TimedPath(StrictModel):
    """Path of axes with its times: straight pieces, each with one acceleration."""

    axes: list[AxisName] = Field(min_length=1, max_length=AXES, description="The axes, in the rows' order.")
    rows: str = Field(
        description="A line for each piece: its seconds; the speed at its beginning in shares of its mean"
        " speed (0 from rest, 1 constant, 2 to rest); the angles at its end.",
    )
    corner_s: float = Field(
        default=0.01,
        ge=0,
        le=1,
        description="From one row to the next an axis's speed may change at once by its acceleration in this"
        " time.",
    )


ACTIONS = ("move", "move_by", "line", "line_by", "spline", "path", "dwell_s", "wait_until", "pins", "repeat")


def _one_action(step: "Step") -> "Step":
    named = [name for name in ACTIONS if getattr(step, name) is not None]
    if len(named) != 1 and not (not named and step.label):
        said = " and ".join(named) or "nothing"
        raise PydanticCustomError(
            "actions",
            f"a step does one thing, this one {said}",
            {"remedy": f"write one of {', '.join(ACTIONS)}"},
        )
    if step.in_s is not None and named[:1] not in (["move"], ["move_by"], ["line"], ["line_by"]):
        raise PydanticCustomError("in_s", "in_s is for moves and lines", {"remedy": "leave it out"})
    return step


class _Step(StrictModel):
    """Step of a run: one thing to do."""

    label: Name | None = Field(
        default=None, description="A name for `repeat`; the step may have nothing else."
    )
    move: dict[AxisName, Angle] | None = Field(
        default=None, min_length=1, description="Axes to angles; they begin and end together."
    )
    move_by: dict[AxisName, Angle] | None = Field(
        default=None, min_length=1, description="The same by angles."
    )
    line: dict[AxisName, Angle] | None = Field(
        default=None, min_length=1, description="Axes to angles in a straight line."
    )
    line_by: dict[AxisName, Angle] | None = Field(
        default=None, min_length=1, description="The same by angles."
    )
    spline: list[SplinePoint] | None = Field(
        default=None,
        min_length=1,
        max_length=1000,
        description="Through points, mappings of axes to angles, from where they are; `at_s` in all or none.",
    )
    path: TimedPath | None = Field(
        default=None, description="Along a path with its times, as programs make it; a phrase of its own."
    )
    dwell_s: Seconds | None = Field(default=None, description="Pause of all axes.")
    wait_until: WaitUntil | None = Field(
        default=None, description="Wait until a field of an axis is in a range."
    )
    pins: dict[str, Literal[0, 1]] | None = Field(
        default=None, min_length=1, description="Inputs of axes to levels, as in `{m1.D3: 1}`."
    )
    repeat: Repeat | None = Field(default=None, description="Do earlier steps again.")
    in_s: Seconds | None = Field(
        default=None, description="Duration of a move or line; left out: the shortest within the limits."
    )


Step = Annotated[_Step, AfterValidator(_one_action)]


def _as_choice(how: object) -> object:
    """Read the other words for ways to stop."""
    return filled("run", (HOW_TO_STOP,), {"how": how})[0].get("how", how)


class RunDocument(StrictModel):
    """A run."""

    run: Name = Field(description="Its name; the same text submitted again during the run is the same run.")
    axes: dict[AxisName, AxisRules] = Field(
        min_length=1,
        max_length=AXES,
        description="The axes that take part, by their addresses, as in `m1` or `arm.elbow`; those of another"
        " bench as `lathe/m1`.",
    )
    profile: Literal["trapezoid", "s_curve"] = Field(
        default="s_curve", description="Limits of moves and lines: of acceleration, or of jerk too."
    )
    on_fault: Annotated[Literal["grace", "prejudice"], BeforeValidator(_as_choice)] = Field(
        default="grace",
        description="How the others stop when an axis fails: `grace` or `controlled` with a ramp,"
        " `prejudice` or `immediate` at once.",
    )
    silence_s: float = Field(
        default=1.0,
        ge=0.5,
        le=60,
        description="Time for which another bench of the run, or the link to it, may be silent. Then it is"
        " gone: the run ends as `on_fault` says. A phrase that moves needs no messages.",
    )
    start_in_s: Seconds = Field(default=0.0, description="Time from its acceptance to its start.")
    steps: list[Step] = Field(min_length=1, max_length=STEPS, description="The steps, in their order.")


def parse_run(text: str, file: str) -> tuple[RunDocument, Document]:
    """Read a run's text; answers it with its places. ``file`` is the name that problems carry.

    Raises:
        ConfigError: with all problems.
    """
    return _checked(document_from_yaml(text, file))


def run_from_data(data: Mapping[str, object]) -> tuple[RunDocument, Document]:
    """Read the same from plain values; problems have line 0."""
    return _checked(document_from_mapping(data, "<run>"))


def _checked(document: Document) -> tuple[RunDocument, Document]:
    if document.value is None and not document.findings:
        raise document.error([Finding((), "the file is empty", 'begin with "run: NAME"')])
    check_kind(document, RUN)
    try:
        run = RunDocument.model_validate(document.value)
    except ValidationError as error:
        findings = [*document.findings, *findings_of(error, RunDocument, (), document)]
        raise RunTextError(document, findings, _rest(document.value, error)) from None
    if document.findings:
        raise RunTextError(document, document.findings, run)
    return run, document


class RunTextError(ConfigError):
    """Error of a run's text. ``rest``: the run with a pause in the place of each step that is wrong, so that
    what else is wrong can be found; None: too little of it is a run."""

    def __init__(self, document: Document, findings: Sequence[Finding], rest: RunDocument | None) -> None:
        super().__init__(document.error(findings).problems)
        self.document, self.findings, self.rest = document, findings, rest


def _rest(value: object, error: ValidationError) -> RunDocument | None:
    if not isinstance(value, dict):
        return None
    left: dict[str, Any] = {"run": "run"} | value
    for name, *inner in (each["loc"] for each in error.errors(include_url=False)):
        if name == "steps" and inner and isinstance(left["steps"], list):
            number, step = int(inner[0]), left["steps"][int(inner[0])]
            label = step.get("label") if isinstance(step, dict) else None
            pause = {"dwell_s": 0.0} | ({"label": label} if label else {})
            left["steps"] = [*left["steps"][:number], pause, *left["steps"][number + 1 :]]
        elif name == "axes" and inner and isinstance(left["axes"], dict):
            left["axes"] = left["axes"] | {inner[0]: {}}
        else:
            left.pop(str(name), None)
    try:
        return RunDocument.model_validate({"run": "run"} | left)
    except ValidationError:
        return None


def run_reference() -> str:
    """Write the part of the reference about runs: every key of one, Markdown."""
    schema = RunDocument.model_json_schema()
    parts = schema["$defs"]
    sections = [
        "## Runs",
        "A run is YAML or JSON, for `hil run`, `run/submit` over zenoh, the client and the test kit.",
        keys_table(schema),
    ]
    for title, model in (
        ("Axes: `axes.<name>`", "AxisRules"),
        ("Steps: `steps`; each does one thing", "_Step"),
        ("`path`", "TimedPath"),
        ("`wait_until`", "WaitUntil"),
        ("`repeat`", "Repeat"),
        ("Points of a spline, beside `at_s` the angles of axes", "SplinePoint"),
    ):
        sections += [f"### {title}", keys_table(parts[model])]
    return "\n\n".join(sections) + "\n"
