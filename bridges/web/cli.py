"""Commands ``hil web``."""

from typing import Annotated

import typer

app = typer.Typer(
    name="web",
    help="Users of the web bridge.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback(rich_help_panel="Service")
def _commands() -> None:
    pass


@app.command()
def user(
    name: Annotated[
        str,
        typer.Argument(
            help="The user with a role: viewer, operator, admin.", metavar="NAME:ROLE", show_default=False
        ),
    ],
) -> None:
    """Make a line for the users' file of the web bridge.

    Asks for a password, or reads one line where the standard input is no terminal. What it prints has the
    password's hash alone.

    Example: hil web user ann:operator
    """
    import secrets
    import sys

    from bridges.web.password_hash import hash_of
    from bridges.web.web_users import named_role, password_problem

    try:
        who, role = named_role(name)
    except ValueError as error:
        typer.echo(f"hil: {error}", err=True)
        raise typer.Exit(2) from None
    if sys.stdin.isatty():
        password = typer.prompt("Password", hide_input=True, confirmation_prompt="Again", err=True)
    else:
        password = sys.stdin.readline().rstrip("\r\n")
    if problem := password_problem(password):
        typer.echo(f"hil: {problem}", err=True)
        raise typer.Exit(2)
    typer.echo(f"{who}:{role.name.lower()}:{hash_of(password, secrets.token_bytes(16))}")
    typer.echo(
        "The file of such lines is for you alone (chmod 600), and `users` of bridges.web names it.", err=True
    )
