"""Options of the web bridge."""

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from hil.net.endpoint import endpoint, has_port, host_and_port, is_loopback
from hil.net.listen_option import ADDRESS_SCHEMA, OldKeys, usual_at
from hil.vocab.bridge_protocol import DoorPort, OptionProblem

PROXY = "https://"
"""Beginning of a name that belongs to a proxy in front of the door: the browser has TLS as far as there."""
FIRST_PORT, LAST_PORT = 8080, 8099
"""Ports of which the first that is free is taken, where the options name none."""


class TlsFiles(BaseModel):
    """Files of TLS."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)

    certificate: Path = Field(
        description="The door's certificate in PEM, with those between it and its authority."
    )
    key: Path = Field(description="Its private key in PEM, without a password.")


class Options(OldKeys):
    """Options under ``bridges.web``."""

    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)
    port_left_out: ClassVar[int | None] = None

    listen: Annotated[str, usual_at(None), ADDRESS_SCHEMA] = Field(
        default="127.0.0.1",
        description=(
            'Address and port to listen at, as in `127.0.0.1:8080` or `"[::1]:8080"`; a port alone is of this'
            f" computer, and port 0 any free one. An address alone has {FIRST_PORT}, or where that is taken"
            f" the next free one up to {LAST_PORT}: `hil serve` prints it. Beyond this computer it needs"
            " `users` or `token`, and `tls`; or `insecure: true`."
        ),
    )
    names: list[str] = Field(
        default=[],
        max_length=64,
        description=(
            "Other names and addresses by which browsers reach it, as in `lab1` or `lab1:9000`. Requests for"
            " any other are refused. `https://lab1` is the name of a proxy that has the TLS."
        ),
    )
    users: Path | None = Field(
        default=None,
        description="File of users: names, roles, hashes of passwords; `hil web user` makes lines.",
    )
    token: Literal["viewer", "operator", "admin"] | None = Field(
        default=None,
        description=(
            "In the place of `users`: a token is made at each start, and the log has it. A browser with the"
            " token has this role."
        ),
    )
    tls: TlsFiles | None = Field(default=None, description="Certificate, for https.")
    insecure: bool = Field(
        default=False,
        description="Listen beyond this computer without all of that; log and status say so again.",
    )
    sockets: int = Field(default=64, ge=1, le=1000, description="Pages that can be open at a time.")
    message_kb: int = Field(
        default=1024,
        ge=1,
        le=4096,
        description="Longest message of a page, in kB; a longer one ends its socket.",
    )
    messages_per_s: int = Field(
        default=200, ge=1, le=100_000, description="Messages of a page that are read in a second; more wait."
    )
    samples_per_s: int = Field(
        default=50_000, ge=100, le=400_000, description="Samples of axes that a page gets in a second."
    )

    @field_validator("names")
    @classmethod
    def _are_names(cls, names: list[str]) -> list[str]:
        for name in names:
            plain = name.removeprefix(PROXY)
            try:
                endpoint(plain if has_port(plain) else f"{plain}:1")
            except ValueError as error:
                remedy = "write a name or an address, with or without a port, as in lab1 or [::1]:9000"
                raise PydanticCustomError("names", "{why}", {"why": str(error), "remedy": remedy}) from None
        return names

    @model_validator(mode="after")
    def _is_closed(self) -> Self:
        if self.users and self.token:
            raise PydanticCustomError(
                "users", "users and token: there is one way in", {"remedy": "leave out one of them"}
            )
        proxies = [name for name in self.names if name.startswith(PROXY)]
        if proxies and not (self.users or self.token or self.insecure):
            raise PydanticCustomError(
                "reached",
                "names: {name} is a proxy, by which others could move the axes",
                {
                    "name": proxies[0],
                    "remedy": "add `users` (`hil web user` makes them), or write `insecure: true`",
                },
            )
        if self.insecure or is_loopback(self.host):
            return self
        if not (self.users or self.token):
            raise PydanticCustomError(
                "reached",
                "{listen} is reached from other computers, and anybody there could move the axes",
                {
                    "listen": self.listen,
                    "at": ("listen",),
                    "remedy": "add `users` (`hil web user` makes them) and `tls`, or listen on 127.0.0.1, or"
                    " write `insecure: true`",
                },
            )
        if not self.tls:
            raise PydanticCustomError(
                "readable",
                "{listen} is reached from other computers, and the network could read passwords",
                {
                    "listen": self.listen,
                    "at": ("listen",),
                    "remedy": "add `tls`, or listen on 127.0.0.1, or write `insecure: true`",
                },
            )
        return self

    @property
    def host(self) -> str:
        """Address or name at which it listens, without brackets."""
        return host_and_port(self.listen)[0]

    @property
    def port(self) -> int | None:
        """Port; None: the first that is free."""
        return host_and_port(self.listen)[1]

    def wanted_ports(self) -> Sequence[DoorPort]:
        """None: it listens by itself."""
        return ()

    def problems(self, axes: Collection[str]) -> Iterable[OptionProblem]:
        """None: it names nothing of the bench."""
        return ()

    def file_problems(self) -> Iterable[OptionProblem]:
        """Mistakes in the users' file and the certificates."""
        if self.users:
            from bridges.web.web_users import UsersError, read_users  # few have them

            try:
                read_users(self.users)
            except UsersError as error:
                messages = "; ".join(message for message, _ in error.problems)
                yield OptionProblem(("users",), messages, error.problems[0].remedy)
        if self.tls:
            from bridges.web.tls_files import file_problems

            for option, message, remedy in file_problems(self.tls.certificate, self.tls.key):
                yield OptionProblem(("tls", option), message, remedy)
