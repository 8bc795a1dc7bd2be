"""Commands ``hil usb``."""

import typer

from hil.cli.command_classes import Below
from hil.cli.told import AsJson

usb_app = typer.Typer(cls=Below, help="Ports of kind usb.", no_args_is_help=True, rich_markup_mode=None)


@usb_app.callback()
def _commands() -> None:
    pass


@usb_app.command()
def doctor(as_json: AsJson = False) -> None:
    """Check whether this system can have virtual USB devices, and you may plug them in.

    Prints each problem, its effect, and the line that corrects it. Exits with 1 if something is missing
    without which no port of kind usb opens.

    Example: hil usb doctor
    """
    from hil.cli.doctor_usb import judge_usb
    from hil.cli.views import tell_findings
    from hil.host.doctor import worst_first

    tell_findings(worst_first([*judge_usb()]), as_json)
