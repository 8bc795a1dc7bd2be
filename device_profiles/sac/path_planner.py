"""Planner of paths for SACs: lines, streams of short pieces, and where commands leave an axis."""

from collections.abc import Mapping, Sequence

from device_profiles.sac.axis_commands import AxisCommands
from device_profiles.sac.packet import encode
from device_profiles.sac.straight_line import plan_line
from hil.vocab.motion import QUEUE_LEN
from hil.vocab.path_planning import AxisMotion, NodeCommand, NodePhrase, StepperAxis

TURNAROUND_CHARACTERS = 2
"""Characters of silence before a board's answer."""
ANSWER_CHARACTERS = len(encode(1, 4, b"\6"))


class SacStream:
    """Pieces of constant speed for several axes, without ramps and without gaps."""

    def __init__(self, axes: Mapping[str, StepperAxis]) -> None:
        self._axes = {name: AxisCommands(name, axis) for name, axis in axes.items()}
        self.at_us = 0.0

    def again_from(self, at_us: float, last: Mapping[str, NodeCommand]) -> "SacStream":
        stream = SacStream({name: each.axis for name, each in self._axes.items()})
        stream.at_us = at_us
        for name, command in last.items():
            stream._axes[name].go_on_after(command)
        return stream

    def add(self, duration_us: float, pulses: Mapping[str, int]) -> Sequence[NodeCommand]:
        begin_us, end_us = self.at_us, self.at_us + duration_us
        self.at_us = end_us
        made = []
        for name, count in pulses.items():
            if count:
                axis = self._axes[name]
                axis.rest_until(begin_us)
                axis.constant(count, end_us)
                made.append(axis.commands[-1])
        return made


class SacPaths:
    """Planning for SACs."""

    release = b"y"
    queue_length = QUEUE_LEN

    def line_characters(self, data_bytes: int) -> int:
        packet = len(encode(4, 1, b"m")) - 1 + data_bytes
        return packet + TURNAROUND_CHARACTERS + ANSWER_CHARACTERS

    def line(self, moves: Mapping[str, AxisMotion]) -> NodePhrase:
        commands = plan_line(moves)
        return NodePhrase(commands, max(command.end_us for command in commands))

    def stream(self, axes: Mapping[str, StepperAxis]) -> SacStream:
        return SacStream(axes)


PATHS = SacPaths()
