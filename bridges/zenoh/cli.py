"""``hil zenoh``."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="zenoh", help="What the zenoh bridge needs.", no_args_is_help=True, rich_markup_mode=None
)


@app.callback()
def _commands() -> None:
    pass


@app.command()
def keys(
    folder: Annotated[Path, typer.Argument(help="A new or empty folder.", metavar="DIR", show_default=False)],
    bench: Annotated[str, typer.Option("--bench", help="The bench's name.", metavar="NAME")],
    host: Annotated[
        list[str],
        typer.Option(
            "--host", help="A name or address of the daemon's computer; again for more.", metavar="HOST"
        ),
    ],
    user: Annotated[
        list[str],
        typer.Option(
            "--user", help="A user with a role: viewer, operator, admin; again for more.", metavar="NAME:ROLE"
        ),
    ],
    days: Annotated[
        int, typer.Option("--days", min=1, max=3650, help="How long certificates are valid.")
    ] = 365,
    port: Annotated[int, typer.Option("--port", min=1, max=65535, help="Where the daemon listens.")] = 7447,
) -> None:
    """Make certificates, passwords and configurations for a bench that others reach.

    An authority, the daemon's certificate, and for each user a folder with certificate and zenoh
    configuration. Prints the lines for the bench's configuration.
    """
    from datetime import UTC, datetime

    from bridges.zenoh.security import SecurityError
    from bridges.zenoh.site_keys import Site, make_site
    from hil.vocab.verbs import Role

    roles = {role.name.lower(): role for role in Role}
    users = []
    for each in user:
        name, _, role = each.partition(":")
        if role not in roles:
            typer.echo(f"hil: --user {each}: write NAME:ROLE; roles are {', '.join(roles)}", err=True)
            raise typer.Exit(2)
        users.append((name, roles[role]))
    try:
        lines = make_site(folder, Site(bench, host, users, datetime.now(UTC), days, port))
    except SecurityError as error:
        typer.echo(f"hil: {error}", err=True)
        raise typer.Exit(2) from None
    typer.echo(lines, nl=False)
    typer.echo(
        f"\nThese lines are in {folder}/bridge.yaml too. Give each user the folder {folder}/clients/NAME, and"
        " nobody ca.key or users.\nWhoever is taken out of users is out from the daemon's next start on.",
        err=True,
    )
