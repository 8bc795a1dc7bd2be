"""Commands ``hil zenoh``."""

from pathlib import Path
from typing import Annotated

import typer

from bridges.zenoh.site_commands import app as site_app

app = typer.Typer(
    name="zenoh",
    help="Certificates and a router for the zenoh bridge.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.callback(rich_help_panel="Service")
def _commands() -> None:
    pass


app.add_typer(site_app)


@app.command("router")
def run_router(
    listen: Annotated[
        list[str] | None,
        typer.Option(
            "--listen",
            help="Where benches and clients connect, as 127.0.0.1:7447 or tls/0.0.0.0:7447."
            " Default: where the site says, on all interfaces.",
            metavar="HOST:PORT",
        ),
    ] = None,
    site: Annotated[
        Path | None,
        typer.Option("--site", help="The router's folder of a site.", metavar="DIR"),
    ] = None,
    ca: Annotated[Path | None, typer.Option("--ca", help="The site's authority, for tls/ addresses.")] = None,
    certificate: Annotated[Path | None, typer.Option("--certificate", help="The router's.")] = None,
    key: Annotated[Path | None, typer.Option("--key", help="Its private key.")] = None,
    users: Annotated[
        Path | None,
        typer.Option(
            "--users",
            help="File of users and benches that may join. Default: users beside --ca, where that is.",
        ),
    ] = None,
    insecure: Annotated[
        bool, typer.Option("--insecure", help="Let everybody in from other computers.")
    ] = False,
) -> None:
    """Join benches: run a zenoh router until Ctrl-C.

    A bench joins with `bridges: {zenoh: {listen: [], connect: [ADDRESS]}}`. With --users each bench may
    tell and answer under its own name alone, and users may ask. With --site the same holds for the members of
    the site, and a new list of them is taken while the router runs.

    Example: hil zenoh router --listen 127.0.0.1:7447
    """
    import asyncio
    import logging
    import signal

    import zenoh

    from bridges.zenoh.options import TlsOptions, with_transport
    from bridges.zenoh.refused_addresses import first_refused
    from bridges.zenoh.router_process import SiteRouter, close, default_listen, serve_site
    from bridges.zenoh.site_folder import opened_folder
    from bridges.zenoh.users import SecurityError, read_users
    from bridges.zenoh.zenoh_config import opened, password_file, router_config
    from hil.net.endpoint import BadAddress

    where: list[str] = []
    given = [each for each in (ca, certificate, key) if each]
    if given and not (ca and certificate and key):
        typer.echo("hil: --ca, --certificate and --key belong together", err=True)
        raise typer.Exit(2)
    tls = TlsOptions(ca=ca, certificate=certificate, key=key) if ca and certificate and key else None
    if site and (given or users or insecure):
        typer.echo("hil: --site has certificates and users; leave out the others", err=True)
        raise typer.Exit(2)
    if not (site or listen):
        typer.echo("hil: write --site, or --listen", err=True)
        raise typer.Exit(2)
    if users is None and ca and (beside := ca.with_name("users")).exists():
        users = beside
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM})
    try:
        folder, known = opened_folder(site) if site else None, read_users(users) if users else []
        where = [with_transport(each) for each in listen or (default_listen(folder) if folder else [])]
        if folder:
            router = SiteRouter(folder, where)
        else:
            with password_file(known) as dictionary:
                session = opened(router_config(where, tls, insecure, known, dictionary))
    except BadAddress as error:
        typer.echo(f"hil: --listen: {error}; {error.remedy}", err=True)
        raise typer.Exit(2) from None
    except (SecurityError, zenoh.ZError) as error:
        refused = asyncio.run(first_refused(where))
        why = f"--listen: {refused[1]}" if refused else str(error).partition(" at /")[0]
        typer.echo(f"hil: {why}", err=True)
        raise typer.Exit(2) from None
    members = folder.list.members.values() if folder else known
    benches = [each.name for each in members if each.is_bench]
    lets_in = f"lets in {len(members) - len(benches)} users and the benches {', '.join(benches) or 'none'}"
    who = lets_in if folder or known else "lets in everybody"
    typer.echo(f"router at {', '.join(where)}, {who}; Ctrl-C ends it")
    if folder:
        logging.basicConfig(level=logging.INFO, format="hil: %(message)s")
        serve_site(router)
    else:
        signal.sigwait({signal.SIGINT, signal.SIGTERM})
        close(session)


@app.command()
def keys(
    folder: Annotated[Path, typer.Argument(help="A new or empty folder.", metavar="DIR", show_default=False)],
    benches: Annotated[
        list[str],
        typer.Option("--bench", help="A bench's name; with --router again for more.", metavar="NAME"),
    ],
    user: Annotated[
        list[str],
        typer.Option(
            "--user", help="A user with a role: viewer, operator, admin; again for more.", metavar="NAME:ROLE"
        ),
    ],
    host: Annotated[
        list[str] | None,
        typer.Option(
            "--host", help="A name or address of the daemon's computer; again for more.", metavar="HOST"
        ),
    ] = None,
    router: Annotated[
        list[str] | None,
        typer.Option(
            "--router", help="A name or address of a router that all join; again for more.", metavar="HOST"
        ),
    ] = None,
    days: Annotated[
        int, typer.Option("--days", min=1, max=3650, help="How long certificates are valid.")
    ] = 365,
    tcp_port: Annotated[
        int,
        typer.Option(
            "--port", min=1, max=65535, help="Where the daemon or the router listens.", metavar="PORT"
        ),
    ] = 7447,
) -> None:
    """Make certificates, passwords and configurations for a bench in a network.

    An authority, the daemon's certificate, and for each user a folder with certificate and zenoh
    configuration. Prints the lines for the bench's configuration.

    Example: hil zenoh keys site --bench lab --host lab1 --user ann:admin
    """
    from datetime import UTC, datetime

    from bridges.zenoh.site_keys import Site, make_site, router_command
    from bridges.zenoh.users import SecurityError
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
        site = Site(
            benches[0], host or [], users, datetime.now(UTC), days, tcp_port, benches[1:], router or []
        )
        lines = make_site(folder, site)
    except SecurityError as error:
        typer.echo(f"hil: {error}", err=True)
        raise typer.Exit(2) from None
    typer.echo(lines, nl=False)
    starts = f"\nStart the router on its computer: {router_command(folder, site)}" if site.routers else ""
    typer.echo(
        f"\nThese lines are in {folder}/bridge.yaml too. Give each user the folder {folder}/clients/NAME;"
        f" keep ca.key and users.{starts}"
        "\nTo remove a user, delete the line in users and start the daemon again.",
        err=True,
    )
