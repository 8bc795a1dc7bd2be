"""Options of commands that look at other benches without one here: where they are joined, and who asks."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.exit_codes import Exit

if TYPE_CHECKING:
    from hil.client import Lab

Connect = Annotated[
    str | None,
    typer.Option(
        "--connect",
        metavar="tcp/HOST:PORT",
        help="A router, or a bench's own door, where the benches are joined.",
        show_default=False,
    ),
]
ConfigFile = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="A user's zenoh.json, as `hil zenoh site` makes it; its door, unless --connect names one.",
        show_default=False,
    ),
]
LabelWords = Annotated[
    list[str] | None,
    typer.Option(
        "--label",
        metavar="NAME=VALUE",
        help="Only benches with this label; again for more.",
        show_default=False,
    ),
]

PrometheusFile = Annotated[
    Path | None,
    typer.Option(
        "--prometheus",
        help="Write where their metrics are to a file for Prometheus (file_sd); those away stay in it.",
        show_default=False,
    ),
]
EverySeconds = Annotated[
    float | None,
    typer.Option(
        "--every",
        min=1,
        max=3600,
        metavar="SECONDS",
        help="Keep that file current until Ctrl-C: look every so many seconds.",
        show_default=False,
    ),
]


class LabOptions(NamedTuple):
    """Options that say at which door the benches are."""

    connect: Connect = None
    config: ConfigFile = None

    @property
    def are_given(self) -> bool:
        """True if a door is named."""
        return self.connect is not None or self.config is not None

    def opened(self) -> "Lab":
        """Open a session there, or say why it cannot be had and end the command."""
        from hil.client import ClientError, Lab
        from hil.net.endpoint import BadAddress, check_joined

        if self.config is not None and not self.config.is_file():
            why = f"--config: there is no file {self.config}"
            raise fail(f"{why}; `hil zenoh site` makes such files", Exit.MISTAKE)
        try:
            if self.connect is not None:
                check_joined(self.connect)
        except BadAddress as error:
            raise fail(f"--connect: {error}; {error.remedy}", Exit.MISTAKE) from None
        try:
            return Lab(self.connect, config=self.config, timeout_s=0)
        except ClientError as error:
            raise fail(f"hil: {error}") from None

    def asked(self, bench: str | None, rest: str, given: dict[str, Any]) -> dict[str, Any]:
        """Ask one bench there under a key below its name, or say why there is no answer and end the
        command."""
        from hil.client import ClientError

        if bench is None:
            raise fail("hil: which bench of the lab? Name it with --bench", Exit.MISTAKE)
        with self.opened() as session:
            try:
                return dict(session.ask(bench, rest, given or None))
            except ClientError as error:
                raise fail(f"hil: {error}") from None


NO_LAB = LabOptions()


def wanted_labels(words: list[str] | None) -> dict[str, str]:
    """Read the values of --label, or say what is wrong and end the command."""
    from hil.vocab.bench_labels import wanted_label

    try:
        return dict(map(wanted_label, words or ()))
    except ValueError as error:
        raise fail(f"hil: --label {error}", Exit.MISTAKE) from None
