"""Commands ``hil zenoh site``."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from bridges.zenoh.site_authority import SiteAuthority
    from bridges.zenoh.site_list import RoleGrant, SiteList

app = typer.Typer(
    name="site",
    help="Benches, users and a router of one authority: certificates, roles, revocation.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

SiteArgument = Annotated[
    Path, typer.Argument(help="The site's folder, where its keys are.", metavar="DIR", show_default=False)
]
DaysOption = Annotated[int, typer.Option("--days", min=1, max=3650, help="How long certificates are valid.")]
LabelOption = Annotated[
    list[str] | None,
    typer.Option("--label", help="A label for roles; again for more.", metavar="KEY=VALUE"),
]
RoleOption = Annotated[
    list[str] | None,
    typer.Option(
        "--role",
        help="viewer, operator or admin, at all benches, one or those with a label; again for more.",
        metavar="ROLE[@BENCH|@KEY=VALUE]",
    ),
]


@contextmanager
def _told() -> Iterator[None]:
    """Tell what is wrong with a site, and exit with 2."""
    from bridges.zenoh.users import SecurityError

    try:
        yield
    except SecurityError as error:
        typer.echo(f"hil: {error}", err=True)
    except OSError as error:
        typer.echo(f"hil: {error.filename}: {error.strerror}", err=True)
    else:
        return
    raise typer.Exit(2)


def _site(folder: Path) -> "SiteAuthority":
    from bridges.zenoh.site_authority import SiteAuthority

    return SiteAuthority(folder)


def _grants(roles: list[str] | None, of: "SiteList") -> "list[RoleGrant]":
    """Read roles; a label that no bench has, and a bench that is not there, are told."""
    from bridges.zenoh.site_list import EVERYWHERE, read_grant

    grants = [read_grant(each) for each in roles or []]
    for grant in grants:
        key, is_label, value = grant.where.partition("=")
        is_there = any(each.labels.get(key) == value if is_label else each.name == key for each in of.benches)
        if grant.where != EVERYWHERE and not is_there:
            typer.echo(f"hil: --role {grant}: no bench of the site is that yet", err=True)
    return grants


def _labels(labels: list[str] | None) -> dict[str, str]:
    from bridges.zenoh.site_list import read_label
    from bridges.zenoh.users import SecurityError

    read = [read_label(each) for each in labels or []]
    keys = [key for key, _ in read]
    if twice := {key for key in keys if keys.count(key) > 1}:
        raise SecurityError(f"--label {min(twice)}: a bench has one value of it; write it once")
    return dict(read)


def _copy_list(site: "SiteAuthority") -> None:
    """Say how others learn of a change."""
    typer.echo(
        f"list {site.list.number}: copy {site.folder}/members into the folders of the router and of all"
        " benches; they take it while they run",
        err=True,
    )


def _certificates(site: "SiteAuthority", names: list[str]) -> None:
    """Say which certificates another authority has to issue."""
    from bridges.zenoh.site_list import ROUTER

    for name in () if site.is_own else names:
        certified = ROUTER if name == ROUTER else site.list.members[name].certified
        typer.echo(
            f"{site.place(name)}: put cert.pem and key.pem there, a certificate with the common name"
            f" {certified!r} and its key of P-256",
            err=True,
        )


@app.command()
def new(
    folder: Annotated[Path, typer.Argument(help="A new or empty folder.", metavar="DIR", show_default=False)],
    router: Annotated[
        list[str] | None,
        typer.Option("--router", help="A name or address of the router's computer; again for more."),
    ] = None,
    name: Annotated[
        str | None, typer.Option("--name", help="The site's name. Default: the folder's.", metavar="NAME")
    ] = None,
    tcp_port: Annotated[
        int, typer.Option("--port", min=1, max=65535, help="Where the router listens.", metavar="PORT")
    ] = 7447,
    days: DaysOption = 365,
    ca: Annotated[
        Path | None,
        typer.Option("--ca", help="Certificates of an authority that you have, intermediate ones too."),
    ] = None,
) -> None:
    """Make a site: an authority, and the folder of its router.

    The folder has the site's key: keep it where no bench runs. Benches and users get folders of their own.

    Example: hil zenoh site new lab --router hub.lan
    """
    with _told():
        from bridges.zenoh.site_authority import new_site
        from bridges.zenoh.site_list import ROUTER

        called = name or folder.absolute().name.lower()
        site = new_site(folder, called, router or [], tcp_port, datetime.now(UTC), days, ca)
        if router:
            _certificates(site, [ROUTER])
            typer.echo(f"copy {site.place(ROUTER)} to the router's computer: hil zenoh router --site router")


@app.command("add-bench")
def add_bench(
    folder: SiteArgument,
    benches: Annotated[list[str], typer.Argument(help="Names of benches.", metavar="NAME...")],
    label: LabelOption = None,
    host: Annotated[
        list[str] | None,
        typer.Option("--host", help="Where clients connect to the bench itself, without a router."),
    ] = None,
    days: DaysOption = 365,
) -> None:
    """Add benches to a site: a folder for each.

    Example: hil zenoh site add-bench lab mill lathe --label rig=press
    """
    with _told():
        site = _site(folder)
        site.add_benches(benches, _labels(label), host or [], datetime.now(UTC), days)
        _certificates(site, benches)
        for bench in benches:
            typer.echo(f"{site.place(bench)}: copy it to its computer; bridges: {{zenoh: {{site: {bench}}}}}")
        _copy_list(site)


@app.command("add-user")
def add_user(
    folder: SiteArgument,
    user: Annotated[str, typer.Argument(help="The user's name.", metavar="NAME")],
    role: RoleOption = None,
    days: DaysOption = 365,
) -> None:
    """Add a user to a site, with a folder to connect with.

    Example: hil zenoh site add-user lab otto --role operator@mill --role viewer@rig=press
    """
    with _told():
        site = _site(folder)
        site.add_user(user, _grants(role or ["viewer"], site.list), datetime.now(UTC), days)
        _certificates(site, [user])
        typer.echo(f'{site.place(user)}: give it to {user}; connect(BENCH, config="{user}/zenoh.json")')
        _copy_list(site)


@app.command()
def change(
    folder: SiteArgument,
    member: Annotated[str, typer.Argument(help="A user or a bench.", metavar="NAME")],
    role: RoleOption = None,
    label: LabelOption = None,
) -> None:
    """Give a user other roles, or a bench other labels, in the place of those before.

    Example: hil zenoh site change lab otto --role viewer
    """
    with _told():
        site = _site(folder)
        grants = _grants(role, site.list) if role else None
        site.change(member, grants, _labels(label) if label or not role else None)
        _copy_list(site)


@app.command()
def remove(
    folder: SiteArgument,
    members: Annotated[list[str], typer.Argument(help="Users and benches.", metavar="NAME...")],
) -> None:
    """Remove users and benches: their certificates are revoked.

    Example: hil zenoh site remove lab otto
    """
    with _told():
        site = _site(folder)
        site.remove(members)
        _copy_list(site)


@app.command()
def rotate(
    folder: SiteArgument,
    members: Annotated[
        list[str] | None, typer.Argument(help="Users, benches, router. Default: all.", metavar="NAME...")
    ] = None,
    stolen: Annotated[
        bool, typer.Option("--stolen", help="Revoke the certificates before: somebody else has a key.")
    ] = False,
    days: DaysOption = 365,
) -> None:
    """Renew certificates and keys, all or those of some members.

    Example: hil zenoh site rotate lab
    """
    with _told():
        site = _site(folder)
        chosen = site.rotate(members or [], datetime.now(UTC), days, stolen)
        _certificates(site, chosen)
        for name in chosen:
            typer.echo(f"{site.place(name)}: copy it again")
        _copy_list(site)


@app.command()
def show(
    folder: Annotated[
        Path,
        typer.Argument(help="A site's folder, or that of one member.", metavar="DIR", show_default=False),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show who is in a site, with roles and ends of certificates; or check the folder of a member.

    Example: hil zenoh site show lab
    """
    with _told():
        from bridges.zenoh.site_authority import PRIVATE
        from bridges.zenoh.site_folder import (
            LIST,
            USER_FILES,
            common_name,
            opened_folder,
            read_own,
            refuse_partial,
        )

        if (folder / PRIVATE).exists():
            content = _shown_site(_site(folder))
        elif (folder / "zenoh.json").exists() and not (folder / LIST).exists():
            refuse_partial(folder, USER_FILES)
            _, certificate, _ = read_own(folder, datetime.now(UTC))
            end = f"{certificate.not_valid_after_utc:%Y-%m-%d}"
            name = common_name(certificate)
            typer.echo(json.dumps({"name": name, "ends": end}) if as_json else f"user {name} until {end}")
            return
        else:
            own = opened_folder(folder)
            name = own.member().name if own.own or own.is_revoked else "router"
            content = _shown(own.list, {name: own.certificate.not_valid_after_utc})
        if as_json:
            typer.echo(json.dumps(content))
            return
        typer.echo(f"{content['site']}: list {content['number']}, {len(content['revoked'])} revoked")
        for each in content["members"]:
            end = each["ends"] or "not here"
            what = " ".join(each["roles"] if each["kind"] == "user" else each["labels"])
            typer.echo(f"{each['kind']:6} {each['name']:20} {end:10} {what}".rstrip())


def _shown_site(site: "SiteAuthority") -> dict[str, Any]:
    """Content of a whole site; certificates that end within 30 days are told."""
    from bridges.zenoh.site_folder import CERTIFICATE, read_certificates
    from bridges.zenoh.site_list import ROUTER

    ends = {
        name: read_certificates(path)[0].not_valid_after_utc
        for name in (ROUTER, *site.list.members)
        if (path := site.place(name) / CERTIFICATE).exists()
    }
    soon = [name for name, end in ends.items() if end < datetime.now(UTC) + timedelta(days=30)]
    if soon and site.is_own:
        typer.echo(
            f"hil: within 30 days end {', '.join(soon)}; hil zenoh site rotate {site.folder}", err=True
        )
    return _shown(site.list, ends)


def _shown(of: "SiteList", ends: dict[str, datetime]) -> dict[str, Any]:
    from bridges.zenoh.site_list import ROUTER

    def row(kind: str, name: str, labels: list[str], roles: list[str]) -> dict[str, Any]:
        end = f"{ends[name]:%Y-%m-%d}" if name in ends else None
        return {"kind": kind, "name": name, "ends": end, "labels": labels, "roles": roles}

    rows = [row("router", ROUTER, [], [])] if of.routers else []
    for each in (*of.benches, *of.users):
        labels = [f"{key}={value}" for key, value in each.labels.items()]
        kind = "bench" if each.is_bench else "user"
        rows.append(row(kind, each.name, labels, [str(grant) for grant in each.grants]))
    return {
        "site": of.site,
        "number": of.number,
        "routers": list(of.routers),
        "revoked": sorted(of.revoked),
        "members": rows,
    }
