"""Profile of the SAC."""

from device_profiles.sac import dialogues, verbs
from device_profiles.sac.firmware import Sac
from device_profiles.sac.framing import FRAMING
from device_profiles.sac.line_nodes import NODES
from device_profiles.sac.packet import encode
from device_profiles.sac.path_planner import PATHS
from device_profiles.sac.readers import READERS
from hil.vocab.firmware import MAIN, NETWORK
from hil.vocab.profile import Commands, Example, Profile, UartSpec


def _commands() -> Commands:
    from device_profiles.sac.cli import COMMANDS  # imports typer, for which only the command line waits

    return COMMANDS


PROFILE = Profile(
    firmware=Sac,
    uarts={MAIN: UartSpec(about="terminal"), NETWORK: UartSpec(about="packets, over RS485")},
    framing=FRAMING,
    line_nodes=NODES,
    verbs=verbs.VERBS,
    starve=verbs.starve,
    dialogues={"reset": dialogues.reset, "stop": dialogues.stop},
    terminal_axis=dialogues.RunAxis,
    readers=READERS,
    paths=PATHS,
    shown_first=(
        *("at_ns", "position_deg", "velocity_rpm", "torque_Nm", "commanded_deg", "lag_steps", "lost_steps"),
        *("motion_state", "speed_rpm", "queue_position", "pending"),
    ),
    examples=(
        Example(types=b"+", answer=b"+", within_ms=1),
        Example(types=b"v100\rm50\r", answer=b"SAC>m50\r\nSAC>", within_ms=10),
        Example(types=b"q\r", answer=b"1\t50\t CW\t100\t3000\t"),
        Example(types=b"$CK40\r", answer=b"$CK40\r\nSAC>", within_ms=10),  # writes the EEPROM
        Example(types=encode(85, 1, b"s"), answer=b"\2\1U\6", within_ms=10, uart=NETWORK),
    ),
    commands=_commands,
)
