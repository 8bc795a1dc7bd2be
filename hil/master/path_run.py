"""A run over a line by a plan of a path: phrases, dwells, switches and pauses, in their order."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping

from hil.gcode.canonical import Dwell, End, Message, Pause, Switch
from hil.master.sans_io.line_run import LineRun
from hil.master.sans_io.node_master import NodeMaster
from hil.master.sans_io.run_items import RunDwell, RunItem, RunPause, RunSwitch
from hil.toolpath.machine import Machine, MachineAxis, SwitchText
from hil.toolpath.node_phrases import PathPhrase
from hil.toolpath.path_items import Item, Stretch


def path_run(
    master: NodeMaster,
    machine: Machine,
    items: Iterable[PathPhrase | Item],
    *,
    begin: Mapping[str, int] | None = None,
    switched: Callable[[RunSwitch], None] = lambda switch: None,
    takes_optional_pauses: bool = False,
) -> LineRun:
    """Make a run of what ``hil.toolpath.node_phrases.NodePhrases`` gives.

    ``begin``: pulses from the machine's zero at which its axes stand; ``switched``: told of each switch, for
    those that are no node's (``RunSwitch.commands`` is empty then).

    Raises:
        ValueError: an axis of the machine has no node.
    """
    units = {axis.letter: axis.node for axis in machine.axes if axis.node is not None}
    if len(units) != len(machine.axes):
        raise ValueError(f"{machine.name} has axes without a node")
    brakes = {axis.letter: master.nodes.deceleration(rad_per_s2(axis)) for axis in machine.axes}
    run_items = _items(items, machine, takes_optional_pauses)
    return LineRun(master, units, run_items, begin=begin, brakes=brakes, switched=switched)


def rad_per_s2(axis: MachineAxis) -> float:
    """Acceleration of an axis at its motor."""
    pulses_per_rev = axis.stepper.steps_per_rev * axis.stepper.pulses_per_step
    return axis.acceleration_per_s2 * abs(axis.pulses_per_unit) / pulses_per_rev * 2 * math.pi


def _items(
    items: Iterable[PathPhrase | Item], machine: Machine, takes_optional_pauses: bool
) -> Iterator[RunItem]:
    for item in items:
        if isinstance(item, Dwell):
            yield RunDwell(item.seconds, item.place.line)
        elif isinstance(item, Pause):
            if takes_optional_pauses or not item.is_optional:
                yield RunPause(item.place.line)
        elif isinstance(item, Switch):
            yield _switch(item, getattr(machine.text.switches, item.name))
        elif not isinstance(item, Message | End | Stretch):
            yield item


def _switch(item: Switch, text: SwitchText | None) -> RunSwitch:
    name = f"{item.name} {item.state}"
    if text is None or text.node is None:
        return RunSwitch(name, (), item.place.line)
    started = text.start_ccw if item.state == "ccw" and text.start_ccw else text.start
    command = text.stop if item.state == "off" else started
    assert command is not None
    return RunSwitch(name, ((text.node, command.encode("latin-1")),), item.place.line)
