"""What a bench is given of the world around it, when it is made."""

from collections.abc import Callable
from dataclasses import dataclass

from hil.sim.device import Device
from hil.sim.input_log import InputLogWriter
from hil.sim.stops import UNGUARDED, Guard


@dataclass(frozen=True)
class Around:
    """By default what virtual time needs: nobody watches over firmwares, waits for a turn's end, or logs."""

    turn_over: Callable[[], None] = lambda: None
    """Real time: called when firmware may have run, for whatever reason, and its group was given back:
    what it sent has to go on, and what it took has made room."""
    turn: Callable[[], Callable[[], bool] | None] = lambda: None
    """Real time: called when a group's turn begins; the answer says when it is over. A group that is late
    goes on in its next turn, and others have theirs between. One whose firmware takes more time than there
    is falls behind for ever; its inputs then take effect at the time it has reached."""
    guard: Guard = UNGUARDED
    """Around each turn of a firmware's own code."""
    on_failed: Callable[[Device], None] = lambda device: None
    """Called once when a device has stopped; ``Device.failed`` says why."""
    log: InputLogWriter | None = None
    """Gets all inputs with their effective times, and all that devices send."""


VIRTUAL = Around()
