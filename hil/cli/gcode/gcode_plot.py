"""Path that axes of a bench follow while a program is carried out, and its picture with the one asked for."""

import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hil.cli.framework.ask import BenchOptions, fail
from hil.cli.framework.exit_codes import Exit, exit_of

if TYPE_CHECKING:
    from hil.cli.gcode.gcode_files import PlannedFile
    from hil.gcode.canonical import Point
    from hil.toolpath.machine import Machine

INTERVAL_NS = 5_000_000
TAKE_S = 0.3
"""Time between two takings of samples: a watch keeps 5000 for each."""


def check_plot(plot: Path | None, machine: "Machine") -> None:
    """Check, before anything moves, that a picture can be made; what prevents it ends the command."""
    if plot is None:
        return
    from hil.telemetry import picture

    if plot.suffix.lower() not in picture.FORMATS:
        raise fail(f"hil: {plot}: write a name that ends in {', '.join(picture.FORMATS)}", Exit.MISTAKE)
    if not plot.parent.is_dir():
        raise fail(f"hil: {plot}: there is no folder {plot.parent}", Exit.MISTAKE)
    if not machine.has_bench_axes:
        raise fail("hil: a picture needs axis: of each axis of the machine: what is followed", Exit.MISTAKE)
    try:
        picture.check_can_draw()
    except picture.PictureError as error:
        raise fail(f"hil: {error}", Exit.MISTAKE) from None


class FollowedAxes:
    """Samples of a machine's axes, taken in a thread between ``begin`` and ``end``."""

    def __init__(self, machine: "Machine", bench: BenchOptions) -> None:
        self._machine, self._socket = machine, bench.meant().socket
        self._watches: list[int] = []
        self._shifts_deg: list[float] = []
        self._rows: list[list[list[float]]] = [[] for _ in machine.axes]
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._go_on, daemon=True)
        self.lost = 0

    def begin(self) -> None:
        from hil.toolpath.deviation import zero_shift_deg

        for axis in self._machine.axes:
            given: dict[str, Any] = {"signals": ["position_deg"], "interval_ns": INTERVAL_NS}
            told = self._ask("watch", device=axis.bench_axis, **given)
            self._watches.append(told["watch"])
            self._shifts_deg.append(zero_shift_deg(self._ask("state", device=axis.bench_axis)))
        self._thread.start()

    def _go_on(self) -> None:
        from hil.net.control_client import ControlError

        while not self._is_over.wait(TAKE_S):
            try:
                self._take()
            except ControlError:  # `end` asks once more, and says so
                return

    def _ask(self, verb: str, **arguments: Any) -> Any:
        """Ask the bench, or say what is wrong and end the command."""
        from hil.net.control_client import ControlError, ask

        try:
            return ask(self._socket, verb, **arguments)
        except ControlError as error:
            raise fail(f"hil: {error}", exit_of(error)) from None

    def _take(self) -> None:
        from hil.net.control_client import ask

        for rows, watch in zip(self._rows, self._watches, strict=True):
            told = ask(self._socket, "samples", watch=watch)
            rows += told["rows"]
            self.lost += told["lost"]

    def end(self) -> list[tuple[float, ...]]:
        """End it; answers the machine's positions, one place after the other."""
        from hil.net.control_client import ControlError

        self._is_over.set()
        self._thread.join()
        try:
            self._take()
        except ControlError as error:
            raise fail(f"hil: no picture: {error}", exit_of(error)) from None
        for watch in self._watches:
            self._ask("unwatch", watch=watch)
        columns = [{row[0]: row[1] for row in rows} for rows in self._rows]
        times = sorted(set(columns[0]).intersection(*columns[1:]))
        return [
            tuple(
                (column[at_ns] + shift_deg - axis.zero_deg) / axis.motor_deg_per_unit
                for axis, column, shift_deg in zip(self._machine.axes, columns, self._shifts_deg, strict=True)
            )
            for at_ns in times
        ]


def begin_of(machine: "Machine", bench: BenchOptions) -> "Point":
    """Find where a machine stands, by the zeros of its axes' boards."""
    from hil.gcode.canonical import Point
    from hil.toolpath.deviation import zero_shift_deg

    places = {}
    for axis in machine.axes:
        state = bench.ask("state", device=axis.bench_axis)
        at_deg = state["position_deg"] + zero_shift_deg(state)
        places[axis.letter] = (at_deg - axis.zero_deg) / axis.motor_deg_per_unit
    return Point(**places)


def plotted(
    plot: Path, planned: "PlannedFile", begin: "Point", followed: list[tuple[float, ...]]
) -> dict[str, Any]:
    """Write the picture; answers the deviation for JSON."""
    from hil.host.new_file import write_file
    from hil.telemetry.path_picture import path_drawn
    from hil.toolpath.deviation import asked_path, asked_rapids, deviation

    if not followed:
        raise fail("hil: no sample came: there is no picture", Exit.FAILED)
    machine = planned.machine
    asked = asked_path(planned.program.motions, machine, begin)
    found = deviation(asked, followed)
    letters = "".join(axis.letter for axis in machine.axes)
    notes = f"largest deviation {found.largest:.3f} mm"
    rapids = asked_rapids(planned.program.motions, begin)
    title = f"{machine.name}: {Path(planned.plan.file).name}"
    form = (letters, plot.suffix.lower())
    data = path_drawn(asked, followed, *form, course=found.course, rapids=rapids, title=title, notes=notes)
    try:
        write_file(plot, data)
    except OSError as error:
        raise fail(f"hil: {plot}: {error.strerror}", Exit.FAILED) from None
    at = [round(each, 4) for each in found.at]
    return {"file": str(plot), "largest_mm": round(found.largest, 4), "at": at, "samples": len(followed)}
