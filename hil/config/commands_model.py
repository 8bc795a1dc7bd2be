"""Model of what is kept of the commands to a bench."""

from pydantic import Field

from hil.config.explain import StrictModel


class CommandsConfig(StrictModel):
    """Lengths of time and room for which commands are kept."""

    keep_days: int = Field(
        default=0,
        ge=0,
        le=3650,
        description="Number of days of which all commands are kept, with user, door and outcome, a file for"
        " each day in the folder `commands` of the bench's state; `hil log commands` reads them. Older days"
        " are removed. 0: none are kept, and none is removed.",
    )
    keep_MB: int = Field(
        default=100,
        ge=1,
        le=100_000,
        description="Room for all of them, in millions of bytes: the oldest days go when it is used. When the"
        " present day takes all of it, no more of this day is kept, the log says so, and the bench goes on.",
    )
    journal: bool | None = Field(
        default=None,
        description="Whether each command has a line in the daemon's log, too, in systemd's journal for a"
        " service; null: if the bench is a service.",
    )


KEPT_COMMANDS = Field(
    default=CommandsConfig(),
    description="What is kept of who commanded what; a change takes effect at the next start.",
)
"""Key `commands` of a bench."""
