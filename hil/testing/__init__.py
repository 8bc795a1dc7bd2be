"""The shipped test kit: benches for pytest and for scripts.

``Bench`` is a whole bench in memory, on the virtual clock, with pyserial's ``Serial`` at its ports
(``serial_ports``); ``live`` runs one in a process of its own, in real time, ``RealBoards`` one of real
boards, with the same calls (``AnyBench``); ``RecordedBench`` is one as a recording has it at a
time; ``replay`` runs an input log again; ``replay_control`` runs a
control law over recorded encoder counts. ``check_profile``, ``check_codec``, ``check_port`` and
``check_bridge`` hold a board, a codec, a kind of port and a bridge to what all of them keep to. Public and
stable: changes stand in the CHANGELOG.

May import: hil.client, hil.compose, hil.config, hil.core, hil.discovery, hil.firmware, hil.gcode,
hil.host, hil.memory_desk, hil.net, hil.recorded, hil.runs, hil.sim, hil.sketch, hil.telemetry, hil.toolchain,
hil.toolpath, hil.vocab, hil.wire, the standard library, _pytest, distributed, numpy, pydantic, pymodbus,
pytest, serial, zenoh.

Tests may import too: bridges.can.bus, bridges.modbus.protocol, bridges.modbus.registers, device_profiles,
hil.live.
"""

from importlib import import_module  # noqa: TID251 -- of modules of this room and of hil.compose
from typing import TYPE_CHECKING, Any

import serial

from hil.config import ConfigError
from hil.host.python_program import NoPythonProgram
from hil.testing.bench import Bench
from hil.testing.program_beside import ProgramBeside, ProgramRunsOn
from hil.testing.unsupported import UnsupportedHere
from hil.testing.waiting import NotInTime
from hil.vocab.recorded_session import Difference, SessionRefused

if TYPE_CHECKING:
    from hil.compose.replay import Replayed, replay
    from hil.testing.bench_face import AnyBench
    from hil.testing.checks.bridge_check import check_bridge
    from hil.testing.checks.codec_check import check_codec, framing_reader
    from hil.testing.checks.findings import CheckFailed
    from hil.testing.checks.port_check import check_port
    from hil.testing.checks.recording_desk import RecordingDesk
    from hil.testing.control import replay_control
    from hil.testing.drawings import FollowedPath, draw_by_runs, followed_by
    from hil.testing.line_masters import attend
    from hil.testing.live_desk import LiveError
    from hil.testing.motion_replay import replay_motion
    from hil.testing.profile_check import check_profile
    from hil.testing.real_boards import BoardsAbsent, RealBoards
    from hil.testing.recorded_bench import RecordedBench
    from hil.testing.served_bench import ServedBench
    from hil.testing.serving import live
    from hil.testing.session_player import play

__all__ = [
    "AnyBench",
    "Bench",
    "BoardsAbsent",
    "CheckFailed",
    "ConfigError",
    "Difference",
    "FollowedPath",
    "LiveError",
    "NoPythonProgram",
    "NotInTime",
    "ProgramBeside",
    "ProgramRunsOn",
    "RealBoards",
    "RecordedBench",
    "RecordingDesk",
    "Replayed",
    "ServedBench",
    "SessionRefused",
    "UnsupportedHere",
    "attend",
    "check_bridge",
    "check_codec",
    "check_port",
    "check_profile",
    "draw_by_runs",
    "followed_by",
    "framing_reader",
    "live",
    "play",
    "replay",
    "replay_control",
    "replay_motion",
]

_LATE = {
    "hil.compose.replay": ("Replayed", "replay"),
    "hil.testing.bench_face": ("AnyBench",),
    "hil.testing.profile_check": ("check_profile",),
    "hil.testing.checks.bridge_check": ("check_bridge",),
    "hil.testing.checks.codec_check": ("check_codec", "framing_reader"),
    "hil.testing.checks.findings": ("CheckFailed",),
    "hil.testing.checks.port_check": ("check_port",),
    "hil.testing.checks.recording_desk": ("RecordingDesk",),
    "hil.testing.control": ("replay_control",),
    "hil.testing.drawings": ("FollowedPath", "draw_by_runs", "followed_by"),
    "hil.testing.line_masters": ("attend",),
    "hil.testing.live_desk": ("LiveError",),
    "hil.testing.motion_replay": ("replay_motion",),
    "hil.testing.real_boards": ("BoardsAbsent", "RealBoards"),
    "hil.testing.recorded_bench": ("RecordedBench",),
    "hil.testing.served_bench": ("ServedBench",),
    "hil.testing.serving": ("live",),
    "hil.testing.session_player": ("play",),
}
"""Names by modules that are imported when first used: most tests need a bench in memory alone."""


def __getattr__(name: str) -> Any:
    for module, names in _LATE.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


serial.protocol_handler_packages.append("hil.testing.serial_ports")  # ``serial_for_url("hil://m1")``
