"""Interpreter of lines: one after the other, to canonical motions and problems."""

import re

from hil.gcode.arcs import ArcMistake, arc_of
from hil.gcode.block import LIMIT, Block, read_block
from hil.gcode.canonical import (
    PLANE_AXES,
    Canonical,
    Dwell,
    End,
    Feed,
    FeedKind,
    Message,
    PathMode,
    PathModeKind,
    Pause,
    Plane,
    Point,
    Settings,
    Straight,
    Switch,
    SwitchName,
    SwitchState,
)
from hil.gcode.conflicts import Intent, conflicts, intent_of
from hil.gcode.program_text import CodeLine
from hil.gcode.state import HOME, INCHES, LINEAR, MILLIMETRES, SECOND_HOME, SYSTEMS, ProgramState
from hil.gcode.words import AXES
from hil.vocab.problem import Problem

MOST_REMARKS = 1000
SLOWEST = 1e-6
"""Feeds below it count as 0: a motion would never end."""

NOWHERE = 1e-9
"""An axis that would move by less stays: sums of inches leave it, in millimetres or degrees."""

_MEANINGS = re.compile(r"[#l]|g0*(10|20|21|28|30|5[2-9]|9[0-2])")
"""Words of code after which the same words mean another place: parameters, units, offsets, distances."""

_NO_FEED = Feed("per_minute", 0.0)
"""In a program with a problem, which moves nothing."""

_FEEDS: dict[str, FeedKind] = {"G93": "inverse_time", "G94": "per_minute", "G95": "per_revolution"}
_PLANES: dict[str, Plane] = {"G17": "xy", "G18": "xz", "G19": "yz"}
_PATHS: dict[str, PathModeKind] = {"G61": "exact_path", "G61.1": "exact_stop", "G64": "blend"}
_SPINDLE: dict[str, SwitchState] = {"M3": "cw", "M4": "ccw", "M5": "off"}


class Interpreter:
    """Carries out lines in the order of RS-274/NGC, 3.8, whatever the order of their words.

    Long because all words share one state of modes, and the standard's order of execution has to be read
    in one place.
    """

    def __init__(self, settings: Settings) -> None:
        self.state = ProgramState(settings)
        self.motions: list[Canonical] = []
        self.problems: list[Problem] = []
        self.remarks: list[Problem] = []
        self.has_ended = False
        self._settings = settings
        self._line = CodeLine(0, "")
        self._is_silent = False
        self.doubts: set[str] = set()
        """Axes, ``feed`` and ``motion``, of which a problem has left the state in doubt."""
        self.understood_count: int | None = None
        """Number of motions before the first that would be another one without a problem before it; None: of
        all."""

    def do(self, line: CodeLine) -> None:
        """Carry out a line. If it has a problem, it changes modes as far as it was read."""
        self._line, self._is_silent = line, False
        if self._settings.is_block_delete and line.is_deletable:
            return
        if line.problem:
            self.problems.append(Problem(self._settings.file, line.number, *line.problem))
        self.motions.extend(Message(*message) for message in line.messages)
        block = read_block(line.code, self.state)
        if line.code:
            self._carry_out(block)
        if (line.problem or block.mistakes) and _MEANINGS.search(line.code):
            self._lose()
        if line.problem or block.mistakes:
            self.doubts.update(AXES, ["feed"] if "f" in line.code or "g9" in line.code else [])
            self.doubts.update(["motion"] if "g" in line.code else [])

    def _carry_out(self, block: Block) -> None:
        before = len(self.problems)
        for mistake in block.mistakes:
            self._problem(*mistake)
        for key, value, index in block.settings:
            if self.state.is_read_only(key):
                self._problem(index, "the parameter is read only", "set another one")
            else:
                self.state.assign(key, value)
        intent = intent_of(block, self.state)
        if not block.mistakes:
            for mistake in conflicts(block, intent, self.state, is_in_doubt="motion" in self.doubts):
                self._problem(*mistake)
        self._is_silent = len(self.problems) > before
        if self._is_silent:
            self.doubts.update(AXES)
            if _MEANINGS.search(self._line.code):
                self._lose()
        self._feed_and_speed(block)
        self._switches(block)
        self._modes(block)
        self._one_shot(block)
        self._motion(block, intent)
        self._stop(block)

    def _lose(self) -> None:
        """Note that what the next motions would be is not known."""
        if self.understood_count is None:
            self.understood_count = len(self.motions)

    def _problem(self, index: int, message: str, remedy: str) -> None:
        if not self._is_silent:
            place = self._line.place(index)
            self.problems.append(Problem(self._settings.file, *place, message, remedy))

    def _remark(self, index: int, message: str, remedy: str) -> None:
        if len(self.remarks) < MOST_REMARKS:
            place = self._line.place(index)
            self.remarks.append(Problem(self._settings.file, *place, message, remedy))

    def _feed_and_speed(self, block: Block) -> None:
        state, codes, numbers = self.state, block.codes, block.numbers
        if mode := codes.get("feed mode"):
            state.feed_kind = _FEEDS[mode.word.name]
            state.set_feed(0.0)
        if "f" in numbers:
            state.set_feed(numbers["f"])
            self.doubts.discard("feed")
            units = codes.get("units")
            if units and (units.word.name == "G20") != (state.units is INCHES):
                message = f"F is in the units before {units.word.name}, which takes effect after it"
                self._remark(block.indices["f"], message, f"write {units.word.name} in a line before")
        if "s" in numbers:
            state.speed_rpm = numbers["s"]
            if state.spindle != "off" and not {"spindle", "tool change"} & {*codes}:
                self._spindle(block.indices["s"], state.spindle)
        if "t" in numbers:
            state.tool = int(numbers["t"])

    def _spindle(self, index: int, to: SwitchState) -> None:
        if to == self.state.spindle == "off":
            return
        self.state.spindle = to
        speed_rpm = 0.0 if to == "off" else self.state.speed_rpm
        self.motions.append(Switch(self._line.place(index), "spindle", to, speed_rpm))

    def _coolant_off(self, index: int) -> None:
        place = self._line.place(index)
        self.motions += (Switch(place, name, "off", None) for name in self.state.coolants)
        self.state.coolants.clear()

    def _switches(self, block: Block) -> None:
        codes = block.codes
        if change := codes.get("tool change"):
            self._spindle(change.at, "off")
            place = self._line.place(change.at)
            self.motions += (
                Message(place, f"change to tool {self.state.tool}"),
                Pause(place, is_optional=False),
            )
        if spindle := codes.get("spindle"):
            self._spindle(spindle.at, _SPINDLE[spindle.word.name])
        if coolant := codes.get("coolant"):
            if coolant.word.name == "M9":
                self._coolant_off(coolant.at)
            else:
                name: SwitchName = "mist" if coolant.word.name == "M7" else "flood"
                self.motions.append(Switch(self._line.place(coolant.at), name, "on", None))
                if name not in self.state.coolants:
                    self.state.coolants.append(name)
        if (override := codes.get("override")) and override.word.remedy:
            self._remark(override.at, f"{override.word.name} does nothing", override.word.remedy)
        if (dwell := block.has("G4")) and block.numbers.get("p", -1.0) >= 0:
            self.motions.append(Dwell(self._line.place(dwell.at), block.numbers["p"]))

    def _modes(self, block: Block) -> None:
        state, codes = self.state, block.codes
        if plane := codes.get("plane"):
            state.plane = _PLANES[plane.word.name]
        if units := codes.get("units"):
            state.units = INCHES if units.word.name == "G20" else MILLIMETRES
        if system := codes.get("coordinates"):
            number = SYSTEMS.index(system.word.name) + 1
            if number != state.system:
                state.select(number)
        if path := codes.get("path"):
            p = block.numbers.get("p", -1.0) if path.word.name == "G64" else -1.0
            tolerance_mm = p * state.units.mm if p >= 0 else None
            self.motions.append(PathMode(self._line.place(path.at), _PATHS[path.word.name], tolerance_mm))
        if distance := codes.get("distance"):
            state.is_incremental = distance.word.name == "G91"
        if arc_distance := codes.get("arc distance"):
            state.is_arc_absolute = arc_distance.word.name == "G90.1"

    def _one_shot(self, block: Block) -> None:
        code = block.codes.get("one-shot")
        state = self.state
        match code and code.word.name:
            case "G10":
                self._set_origin(block)
            case "G28":
                self._go_home(block, HOME)
            case "G30":
                self._go_home(block, SECOND_HOME)
            case "G28.1":
                state.numbers.update((HOME + index, value) for index, value in enumerate(state.position))
            case "G30.1":
                state.numbers.update(
                    (SECOND_HOME + index, value) for index, value in enumerate(state.position)
                )
            case "G92":
                shift = list(state.shift)
                for index, wanted in self._axis_words(block):
                    shift[index] = state.position[index] - state.origin[index] - wanted
                state.set_shift(shift)
            case "G92.1":
                state.set_shift([0.0] * len(AXES))
                state.shift_off()
            case "G92.2":
                state.shift_off()
            case "G92.3":
                state.shift_from_parameters()

    def _axis_words(self, block: Block) -> list[tuple[int, float]]:
        """Axis words of a line: index of the axis, and the number in millimetres or degrees."""
        scale = self.state.units.scale
        indices = ((AXES.index(letter), letter) for letter in block.axes)
        return [(index, block.numbers[letter] * scale[index]) for index, letter in indices]

    def _set_origin(self, block: Block) -> None:
        state = self.state
        system = round(block.numbers.get("p", 0.0)) or state.system
        is_here = block.numbers.get("l") == 20
        if 1 <= system <= len(SYSTEMS):
            origins = {
                index: state.position[index] - state.shift[index] - value if is_here else value
                for index, value in self._axis_words(block)
            }
            state.set_origin(system, origins)

    def _go_home(self, block: Block, first: int) -> None:
        code = block.codes["one-shot"]
        if block.axes:
            self._straight(code.at, self._target(block), None)
        home = list(self.state.position)
        for letter in block.axes or AXES:
            index = AXES.index(letter)
            home[index] = self.state.numbers.get(first + index, 0.0)
        self._straight(code.at, Point(*home), None)

    def _target(self, block: Block) -> Point:
        state = self.state
        end = list(state.position)
        is_of_machine = block.has("G53") is not None
        for index, value in self._axis_words(block):
            if state.is_incremental:
                end[index] += value
                if AXES[index] in self.doubts:
                    self._lose()
            else:
                end[index] = value if is_of_machine else value + state.offset[index]
                self.doubts.discard(AXES[index])
            if abs(end[index] - state.position[index]) <= NOWHERE:
                end[index] = state.position[index]
        return Point(*end)

    def _motion(self, block: Block, intent: Intent) -> None:
        explicit = block.codes.get("motion")
        if explicit or "motion off" in block.codes:
            self.state.motion = explicit.word.name if explicit else None
            self.doubts.discard("motion")
        if intent.motion is None:
            return
        if intent.motion == "G0":
            self._straight(intent.at, self._target(block), None)
            return
        doubts = {*self.doubts}
        end = self._target(block)
        feed = self._feed(block, intent, end)
        if intent.motion == "G1":
            self._straight(intent.at, end, feed)
            return
        is_clockwise = intent.motion == "G2"
        place = self._line.place(intent.at)
        try:
            arc = arc_of(block, self.state, place, end, feed or _NO_FEED, is_clockwise=is_clockwise)
            self._move(intent.at, end, arc)
        except ArcMistake as mistake:
            if doubts.isdisjoint(AXES[index] for index in PLANE_AXES[self.state.plane][:2]):
                self._problem(intent.at, mistake.message, mistake.remedy)
            self.state.position = list(end)

    def _feed(self, block: Block, intent: Intent, end: Point) -> Feed | None:
        """Feed of a motion; None, and a problem, if it has none."""
        state = self.state
        is_missing = state.feed < SLOWEST
        if state.feed_kind == "inverse_time" and (is_missing or "f" not in block.numbers):
            remedy = "write F in each line of G1, G2 and G3: how often in a minute"
            if "feed" not in self.doubts:
                self._problem(intent.at, f"{intent.motion} has no F above 0, and G93 holds", remedy)
            return None
        if is_missing:
            if "feed" not in self.doubts:
                remedy = "write F and a number above 0 before"
                self._problem(intent.at, f"{intent.motion} has no feed", remedy)
                self.doubts.add("feed")
            return None
        if state.feed_kind == "per_revolution" and (state.speed_rpm == 0 or state.spindle == "off"):
            remedy = "write S and a number above 0, and M3 or M4, before"
            self._problem(intent.at, "F is for a turn of the spindle, which stands", remedy)
            return None
        turns_alone = intent.motion == "G1" and self._turns_alone(end)
        return state.rotary_feed if turns_alone else state.linear_feed

    def _turns_alone(self, end: Point) -> bool:
        here = self.state.position
        return all(end[index] == here[index] for index in LINEAR) and list(end) != here

    def _straight(self, index: int, end: Point, feed: Feed | None) -> None:
        """Go straight; not at all if that leads nowhere."""
        if list(end) != self.state.position:
            self._move(index, end, Straight(self._line.place(index), feed is None, end, feed))

    def _move(self, index: int, end: Point, motion: Canonical) -> None:
        if not all(-LIMIT < value < LIMIT for value in end):
            self._problem(index, "the end is a thousand kilometres away", "look for a wrong number or offset")
        self.motions.append(motion)
        self.state.position = list(end)

    def _stop(self, block: Block) -> None:
        stop = block.codes.get("stop")
        if stop is None:
            return
        place = self._line.place(stop.at)
        if stop.word.name in ("M0", "M1"):
            self.motions.append(Pause(place, stop.word.name == "M1"))
            return
        self._spindle(stop.at, "off")
        self._coolant_off(stop.at)
        self.motions.append(End(place))
        self.has_ended = True
