"""A step/dir drive without a serial interface: wires, verbs and paths turn its axis."""

from array import array
from collections.abc import Mapping
from functools import cache

from hil.firmware.set_point_paths import to_rest
from hil.vocab.firmware import Board, Commit, CoreEvent, Delay, Main
from hil.vocab.parameters import Parameter
from hil.vocab.path import DEG_PER_S, Path
from hil.vocab.profile import Profile
from hil.vocab.time import NS_PER_S
from hil.vocab.verbs import Effect, Verb

COUNTS = 16384
READ_ANGLE = 0xFFFF
STARTS = "starts"


@cache
def perfect_table() -> bytes:
    return array("f", [count * 360 / COUNTS for count in range(COUNTS)]).tobytes()


class Drive:
    """Holds its shaft from power-up on, and counts power-ups in its memory."""

    def __init__(self, board: Board) -> None:
        self.board = board

    def main(self) -> Main:
        axis = self.board.axis
        axis.write_table(perfect_table())
        axis.spi(READ_ANGLE)
        axis.set("mode", ord("x"))
        axis.set("r", (axis.spi(READ_ANGLE) & (COUNTS - 1)) * 360 / COUNTS)
        axis.loop(True)
        starts = self.board.nvm.get(STARTS, b"") + b"|"
        yield Commit(STARTS, starts)
        self.board.note(STARTS, f"{len(starts)} starts")
        while True:
            yield Delay(NS_PER_S)

    def interrupt(self, event: CoreEvent) -> None:
        return


def position(drive: Drive, position_deg: float) -> Mapping[str, float]:
    drive.board.axis.set("r", position_deg)
    return {"set_point": position_deg}


def stop(drive: Drive, acceleration_rpm_per_s: float) -> None:
    axis = drive.board.axis
    speed_deg_per_s = axis.get("velocity_rpm") * DEG_PER_S
    axis.follow(to_rest(axis.get("r"), speed_deg_per_s, acceleration_rpm_per_s * DEG_PER_S))


def follow(drive: Drive, path: Path, start_ns: int) -> None:
    drive.board.axis.follow(path, start_ns)


PROFILE = Profile(
    firmware=Drive,
    uarts={},
    verbs=(
        Verb(
            "position",
            "set the angle",
            (Parameter("position_deg", "where to", "deg", -1e6, 1e6),),
            position,
            Effect.STREAM,
        ),
        Verb(
            "stop",
            "stop on a ramp",
            (Parameter("acceleration_rpm_per_s", "of the ramp", "rpm/s", 0.01, 1e6, 600.0),),
            stop,
            Effect.ENDS,
        ),
    ),
    follow=follow,
)
