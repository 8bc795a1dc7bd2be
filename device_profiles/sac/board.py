"""Profile of the SAC."""

from device_profiles.sac import dialogues, verbs
from device_profiles.sac.firmware import Sac
from device_profiles.sac.framing import FRAMING
from hil.vocab.firmware import MAIN, NETWORK
from hil.vocab.profile import Commands, Profile, UartSpec


def _commands() -> Commands:
    from device_profiles.sac.cli import COMMANDS  # imports typer, for which only the command line waits

    return COMMANDS


PROFILE = Profile(
    firmware=Sac,
    uarts={MAIN: UartSpec(about="terminal"), NETWORK: UartSpec(about="packets, over RS485")},
    framing=FRAMING,
    verbs=verbs.VERBS,
    starve=verbs.starve,
    dialogues={"reset": dialogues.reset},
    terminal_axis=dialogues.RunAxis,
    shown_first=(
        *("at_ns", "position_deg", "velocity_rpm", "torque_Nm", "commanded_deg", "lag_steps", "lost_steps"),
        *("motion_state", "speed_rpm", "queue_position", "pending"),
    ),
    commands=_commands,
)
