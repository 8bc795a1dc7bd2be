"""Options of the pty port."""

from pydantic import BaseModel, ConfigDict, Field


class Options(BaseModel):
    """A pseudo-terminal under a stable path."""

    model_config = ConfigDict(strict=True, extra="forbid")

    mode: str = Field(
        default="0660",
        pattern=r"^0?[67][0-7]{2}$",
        description="Permissions of the terminal, in octal; its owner must be able to read and write.",
    )
    group: str | None = Field(
        default=None,
        min_length=1,
        description="Group that owns the terminal, such as dialout; null takes that of "
        "`hil serve --port-group`, or leaves the system's choice.",
    )
    path: str | None = Field(
        default=None,
        min_length=1,
        description="Path of the symlink that clients open, relative to the bench's runtime directory; "
        "null takes the device's name there.",
    )
