"""Document of a machine: its axes, what moves them, their limits. YAML, with the place of each mistake."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from pydantic import Field, ValidationError

from hil.config.document import Document, Finding, KeyPath, document_from_mapping
from hil.config.document_kinds import MACHINE, check_kind
from hil.config.explain import StrictModel, findings_of
from hil.config.port_model import Name
from hil.config.reference_page import keys_table
from hil.config.yaml_text import document_from_yaml
from hil.runs.run_document import AXIS_PATTERN
from hil.vocab.path_planning import StepperAxis

LETTERS = "xyzabcuvw"
"""Axes in the order of a ``Point``."""
ROTARY = "abc"
FULL_TURN_DEG = 360.0
_MOST = 1e6
_MOST_PULSES_PER_S = 500_000
"""Pulses of a driver in a second: one of 1 us, and 1 us of rest. Source: SAC user manual, slow speed."""

COMMANDS_OF_LINE = 3
"""Commands of an axis in a line with ramps: up, cruise, down."""
COMMAND_S = 0.01
"""Time of a command at 38400 baud with its answer, about."""


class AxisText(StrictModel):
    """Keys of all axes. Speeds and ways are in the axis's own unit."""

    node: int | None = Field(
        default=None, ge=4, le=255, description="Address of the SAC on the line that moves it."
    )
    axis: str | None = Field(
        default=None, pattern=AXIS_PATTERN, description="Axis of the bench that moves it in runs, as `m1`."
    )
    is_reversed: bool = Field(default=False, description="True if the motor turns counterclockwise for +.")
    steps_per_rev: int = Field(default=200, ge=1, le=10_000, description="Full steps of a turn of the motor.")
    microstep_exponent: int = Field(
        default=1, ge=0, le=7, description="Parameter J of the SAC: a full step is 2 to the J pulses."
    )
    slow_rpm: int = Field(default=10, ge=0, le=1000, description="Parameter L of the SAC.")
    zero_deg: float = Field(
        default=0.0,
        ge=-1e6,
        le=1e6,
        description="Angle of the bench's axis where the machine's axis is at 0.",
    )


class LinearText(AxisText):
    """Axis X, Y, Z, U, V or W."""

    steps_per_mm: float | None = Field(
        default=None, gt=0, le=1e5, description="Full steps of the motor for a millimetre."
    )
    deg_per_mm: float | None = Field(
        default=None,
        gt=0,
        le=1e5,
        description="Degrees of the motor for a millimetre; left out: by `steps_per_mm`.",
    )
    min_mm: float = Field(ge=-_MOST, le=_MOST, description="Smallest position, in machine coordinates.")
    max_mm: float = Field(ge=-_MOST, le=_MOST, description="Largest position.")
    velocity_mm_per_min: float = Field(gt=0, le=_MOST, description="Largest speed.")
    acceleration_mm_per_s2: float = Field(gt=0, le=_MOST, description="Largest acceleration.")


class RotaryText(AxisText):
    """Axis A, B or C."""

    steps_per_deg: float | None = Field(
        default=None, gt=0, le=1e5, description="Full steps of the motor for a degree of the axis."
    )
    deg_per_deg: float | None = Field(
        default=None,
        gt=0,
        le=1e5,
        description="Degrees of the motor for a degree of the axis; left out: by `steps_per_deg`.",
    )
    min_deg: float = Field(ge=-_MOST, le=_MOST, description="Smallest position, in machine coordinates.")
    max_deg: float = Field(ge=-_MOST, le=_MOST, description="Largest position.")
    velocity_deg_per_min: float = Field(gt=0, le=_MOST, description="Largest speed.")
    acceleration_deg_per_s2: float = Field(gt=0, le=_MOST, description="Largest acceleration.")


class AxesText(StrictModel):
    """Axes by their letters."""

    x: LinearText | None = None
    y: LinearText | None = None
    z: LinearText | None = None
    a: RotaryText | None = None
    b: RotaryText | None = None
    c: RotaryText | None = None
    u: LinearText | None = None
    v: LinearText | None = None
    w: LinearText | None = None


class SwitchText(StrictModel):
    """Switch of a thing: a pin of an axis of the bench, or commands of a node of the line."""

    pin: str | None = Field(default=None, description="Input of an axis of the bench, as `m1.D3`.")
    level: int = Field(default=1, ge=0, le=1, description="Level of the pin that means on.")
    node: int | None = Field(default=None, ge=4, le=255, description="Address on the line.")
    start: str | None = Field(
        default=None, min_length=1, max_length=60, description="Command to the node that turns it on."
    )
    stop: str | None = Field(
        default=None, min_length=1, max_length=60, description="Command to the node that turns it off."
    )
    start_ccw: str | None = Field(
        default=None,
        min_length=1,
        max_length=60,
        description="Command for M4, the spindle's other direction.",
    )


class SwitchesText(StrictModel):
    """Switches by what they are for."""

    spindle: SwitchText | None = None
    mist: SwitchText | None = None
    flood: SwitchText | None = None


class MachineText(StrictModel):
    """A machine."""

    machine: Name = Field(description="Its name.")
    line: str | None = Field(
        default=None,
        min_length=1,
        description="Line of its SACs: a tap of the bench (`bus0.master`), a port (`/dev/ttyUSB0`),"
        " `socket://HOST:PORT` or `rfc2217://HOST:PORT`.",
    )
    baud: int = Field(default=38400, ge=300, le=4_000_000, description="Speed of the line.")
    latency_ms: float = Field(
        default=1.0,
        ge=0,
        le=1000,
        description="Time that a command and its answer lose on the way to the line.",
    )
    tolerance_mm: float = Field(
        default=0.02, gt=0, le=10, description="Distance from the path that corners and arcs may have."
    )
    segment_ms: float = Field(
        default=50.0,
        ge=5,
        le=1000,
        description="Duration of a short segment in streams. An axis's speed changes from one to the next by"
        " its acceleration times this.",
    )
    rapid_mm_per_min: float | None = Field(
        default=None, gt=0, le=_MOST, description="Speed of G0 along its path; left out: that of the axes."
    )
    axes: AxesText = Field(description="Axes by their letters, at least one.")
    switches: SwitchesText = Field(default=SwitchesText(), description="What M3 to M9 switch.")


@dataclass(frozen=True)
class MachineAxis:
    """Axis of a machine, in millimetres or degrees and seconds. ``index`` is its place in a ``Point``."""

    letter: str
    index: int
    minimum: float
    maximum: float
    speed_per_s: float
    acceleration_per_s2: float
    node: int | None
    bench_axis: str | None
    stepper: StepperAxis
    pulses_per_unit: float
    """Signed pulses for a millimetre or degree; 0 if no node moves it."""
    motor_deg_per_unit: float
    """Signed degrees of the bench's axis; 0 if none moves it."""
    zero_deg: float

    @property
    def is_rotary(self) -> bool:
        return self.letter in ROTARY

    @property
    def unit(self) -> str:
        return "deg" if self.is_rotary else "mm"

    def pulses_at(self, position: float) -> int:
        """Pulses from the machine's zero to a position."""
        return round(position * self.pulses_per_unit)

    def motor_deg(self, position: float) -> float:
        return self.zero_deg + position * self.motor_deg_per_unit


@dataclass(frozen=True)
class Machine:
    """A machine whose document has no mistake."""

    text: MachineText

    @cached_property
    def axes(self) -> tuple[MachineAxis, ...]:
        """Axes in the order of a ``Point``."""
        return tuple(
            _axis(letter, text) for letter in LETTERS if (text := getattr(self.text.axes, letter)) is not None
        )

    @property
    def name(self) -> str:
        return self.text.machine

    @property
    def segment_s(self) -> float:
        return self.text.segment_ms / 1000

    @property
    def stop_s(self) -> float:
        """Time that a stop costs: three commands to each axis, and the release."""
        return COMMANDS_OF_LINE * len(self.axes) * COMMAND_S if self.has_nodes else 0.0

    @property
    def has_nodes(self) -> bool:
        """True if SACs of a line move every axis."""
        return all(axis.node is not None for axis in self.axes)

    @property
    def has_bench_axes(self) -> bool:
        """True if axes of a bench move every axis."""
        return all(axis.bench_axis is not None for axis in self.axes)


def parse_machine(text: str, file: str) -> Machine:
    """Read a machine's document. ``file`` is the name that problems carry.

    Raises:
        ConfigError: with all problems.
    """
    return _checked(document_from_yaml(text, file))


def machine_from_data(data: Mapping[str, object]) -> Machine:
    """Read the same from plain values; problems have line 0."""
    return _checked(document_from_mapping(data, "<machine>"))


def _checked(document: Document) -> Machine:
    check_kind(document, MACHINE)
    try:
        text = MachineText.model_validate(document.value)
    except ValidationError as error:
        found = findings_of(error, MachineText, (), document)
        raise document.error([*document.findings, *found]) from None
    findings = [*document.findings, *_axes_findings(text), *_switch_findings(text)]
    if findings:
        raise document.error(findings)
    return Machine(text)


def _axes_findings(text: MachineText) -> Iterator[Finding]:
    nodes: dict[int, str] = {}
    benches: dict[str, str] = {}
    axes = {letter: axis for letter in LETTERS if (axis := getattr(text.axes, letter)) is not None}
    if not axes:
        yield Finding(("axes",), "there is no axis", "add one, as x: {node: 4, ...}")
    for letter, axis in axes.items():
        path: KeyPath = ("axes", letter)
        unit = "deg" if letter in ROTARY else "mm"
        if axis.node is None and axis.axis is None:
            yield Finding(path, "nothing moves it", "add node: or axis:", at_key=True)
        if axis.node is not None and _steps(axis) is None:
            yield Finding(path, f"a node needs steps_per_{unit}", f"add steps_per_{unit}:", at_key=True)
        if axis.axis is not None and _motor_deg(axis) is None:
            yield Finding(
                path, f"an axis of the bench needs deg_per_{unit}", f"add deg_per_{unit}:", at_key=True
            )
        if axis.node is not None and (other := nodes.setdefault(axis.node, letter)) != letter:
            yield Finding((*path, "node"), f"{other} has this node, too", "each axis has a node of its own")
        if axis.axis is not None and (other := benches.setdefault(axis.axis, letter)) != letter:
            yield Finding((*path, "axis"), f"{other} has this axis, too", "each axis has one of its own")
        made = _axis(letter, axis)
        if made.minimum >= made.maximum:
            yield Finding((*path, f"min_{unit}"), f"it is not less than max_{unit}", "exchange them")
        if abs(made.pulses_per_unit) * made.speed_per_s > _MOST_PULSES_PER_S:
            most = _MOST_PULSES_PER_S * 60 / abs(made.pulses_per_unit)
            what = f"these are more than {_MOST_PULSES_PER_S} pulses a second"
            yield Finding((*path, f"velocity_{unit}_per_min"), what, f"write at most {most:g}")


def _switch_findings(text: MachineText) -> Iterator[Finding]:
    for name in SwitchesText.model_fields:
        switch = getattr(text.switches, name)
        path: KeyPath = ("switches", name)
        if switch is None:
            continue
        if (switch.pin is None) == (switch.node is None):
            yield Finding(
                path, "a pin or a node switches it, one of them", "write pin: or node:", at_key=True
            )
        elif switch.node is not None and (switch.start is None or switch.stop is None):
            yield Finding(path, "a node needs start and stop", "add the commands", at_key=True)


def _steps(axis: AxisText) -> float | None:
    return axis.steps_per_deg if isinstance(axis, RotaryText) else getattr(axis, "steps_per_mm", None)


def _motor_deg(axis: AxisText) -> float | None:
    given = axis.deg_per_deg if isinstance(axis, RotaryText) else getattr(axis, "deg_per_mm", None)
    steps = _steps(axis)
    return steps * FULL_TURN_DEG / axis.steps_per_rev if given is None and steps is not None else given


def _axis(letter: str, text: LinearText | RotaryText) -> MachineAxis:
    if isinstance(text, RotaryText):
        ends = text.min_deg, text.max_deg
        speed, acceleration = text.velocity_deg_per_min, text.acceleration_deg_per_s2
    else:
        ends = text.min_mm, text.max_mm
        speed, acceleration = text.velocity_mm_per_min, text.acceleration_mm_per_s2
    stepper = StepperAxis(text.steps_per_rev, text.microstep_exponent, text.slow_rpm)
    sign = -1 if text.is_reversed else 1
    steps = _steps(text) if text.node is not None else None
    motor = _motor_deg(text) if text.axis is not None else None
    return MachineAxis(
        letter=letter,
        index=LETTERS.index(letter),
        minimum=ends[0],
        maximum=ends[1],
        speed_per_s=speed / 60,
        acceleration_per_s2=acceleration,
        node=text.node,
        bench_axis=text.axis,
        stepper=stepper,
        pulses_per_unit=sign * (steps or 0.0) * stepper.pulses_per_step,
        motor_deg_per_unit=sign * (motor or 0.0),
        zero_deg=text.zero_deg,
    )


def machine_reference() -> str:
    """Write the part of the reference about machines: every key of one, Markdown."""
    schema = MachineText.model_json_schema()
    parts = schema["$defs"]
    sections = [
        "## Machines",
        "A machine is YAML, for `hil gcode`.",
        keys_table(schema),
        "### Axes `x`, `y`, `z`, `u`, `v`, `w`: `axes.<letter>`",
        keys_table(parts["LinearText"]),
        "### Axes `a`, `b`, `c`",
        keys_table(parts["RotaryText"]),
        "### Switches: `switches.spindle`, `switches.mist`, `switches.flood`",
        keys_table(parts["SwitchText"]),
    ]
    return "\n\n".join(sections) + "\n"
