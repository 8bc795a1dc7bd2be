"""The command that reads who commanded what."""

import time
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from hil.cli.framework.ask import fail
from hil.cli.framework.command_answers import CommandAnswer
from hil.cli.framework.exit_codes import Exit

if TYPE_CHECKING:
    from hil.wire.command_lines import CheckedLine

SHOWN = 20
"""Number of wrong lines that a check lists; more are counted."""
_UNITS_S = {"s": 1, "min": 60, "h": 3600, "d": 86_400}
_NS = 1_000_000_000


def commands(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FILE",
            help="Files of days, as they were copied from a bench. [default: those of benches on this"
            " computer]",
            show_default=False,
        ),
    ] = None,
    bench: Annotated[
        str | None,
        typer.Option("--bench", help="Only those of this bench.", metavar="NAME", show_default=False),
    ] = None,
    state_dir: Annotated[
        Path | None,
        typer.Option("--state-dir", help="Folder of benches' state. [default: yours and that of services]"),
    ] = None,
    user: Annotated[str | None, typer.Option("--user", help="Only this user's.", show_default=False)] = None,
    since: Annotated[
        str | None,
        typer.Option(
            "--since",
            help="Only since then: 90s, 30min, 2h, 3d ago, or 2026-11-29, 2026-11-29T14:30 in UTC.",
            metavar="TIME",
            show_default=False,
        ),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Check that no line was changed, and that none is missing.")
    ] = False,
    passwords: Annotated[
        Path | None,
        typer.Option(
            "--passwords",
            help="File of users (`users:` of the zenoh bridge): check their signatures with it, too.",
            show_default=False,
        ),
    ] = None,
    authority: Annotated[
        Path | None,
        typer.Option(
            "--authority",
            help="Certificates of a site's authority (PEM): check signatures by certificates with them.",
            show_default=False,
        ),
    ] = None,
) -> CommandAnswer:
    """List who commanded a bench: each command with its time, user, door and outcome, the latest last.

    A bench keeps them as long as `commands: {keep_days: 30}` of its configuration says. With --check they are
    checked and not listed; the command fails if something is wrong.

    Example: hil log commands --user ann --since 2h
    """
    since_ns = _since_ns(since) if since else 0
    read = list(_read_all(_files(files or [], bench, state_dir)))
    if files and read and not any(each.line.row for each in read):
        why = "this is no log of commands; `hil log commands` alone lists those of this computer"
        raise fail(f"hil: {read[0].place}: {why}", Exit.MISTAKE)
    if check or passwords or authority:
        return _checked(
            read, _Known(_secrets(passwords), _authorities(authority)), bool(passwords or authority)
        )
    rows = [
        {"bench": each.bench, **each.line.row}
        for each in read
        if each.line.row
        and each.line.row.get("wall_ns", 0) >= since_ns
        and (user is None or each.line.row.get("user") == user)
    ]
    rows.sort(key=lambda row: row.get("wall_ns", 0))
    from hil.wire.command_lines import command_words

    text = "\n".join(f"{_date(row)} {row['bench']}: {command_words(row)}" for row in rows)
    return CommandAnswer(rows, text or "no commands")


class _Read(NamedTuple):
    """Line of a file. ``bench``: whose it is; ``place``: file and number of the line."""

    bench: str
    place: str
    line: "CheckedLine"


def _files(given: list[Path], bench: str | None, state_dir: Path | None) -> dict[str, list[Path]]:
    """Files by bench, the oldest first."""
    import os

    from hil.host.day_files import day_files_in
    from hil.host.paths import state_bases
    from hil.wire.command_lines import COMMANDS

    if given:
        return {bench or "": sorted(given, key=lambda path: path.name)}
    bases = state_bases(state_dir, os.environ)
    found = {
        folder.parent.name: days
        for base in bases
        for folder in sorted(base.glob(f"*/{COMMANDS}"))
        if bench in (None, folder.parent.name) and (days := day_files_in(folder))
    }
    if not found:
        whose = f"commands of {bench}" if bench else "commands of a bench"
        raise fail(
            f"hil: no {whose} in {' and '.join(map(str, bases))}; a bench keeps them with"
            " `commands: {keep_days: 30}` in its configuration"
        )
    return found


def _read_all(files: Mapping[str, list[Path]]) -> Iterator[_Read]:
    from hil.host.regular_file import open_regular
    from hil.wire.command_lines import checked_lines

    for bench, paths in files.items():
        places, texts = list[str](), list[str]()
        for path in paths:
            try:
                with open_regular(path) as file:
                    content = file.read().decode(errors="replace")
            except OSError as error:
                raise fail(f"hil: {path}: {error.strerror}", Exit.MISTAKE) from None
            lines = [(number, line) for number, line in enumerate(content.split("\n"), 1) if line]
            places += [f"{path}:{number}" for number, _ in lines]
            texts += [line for _, line in lines]
        told = bench
        for place, line in zip(places, checked_lines(texts), strict=True):
            told = str(line.row.get("bench", "")) or told if "begins" in line.row else told
            yield _Read(told, place, line)


class _Known(NamedTuple):
    """Means to check signatures: passwords by user, and certificates of authorities."""

    secrets: Mapping[str, str]
    authorities: Sequence[Any]


def _checked(read: list[_Read], known: _Known, with_signatures: bool) -> CommandAnswer:
    wrong = [(each.place, each.line.wrong) for each in read if each.line.wrong]
    signed = 0
    for each in read if with_signatures else ():
        if "proof" not in each.line.row:
            continue
        if why := _wrong_signature(each.line.row, known):
            wrong.append((each.place, why))
        else:
            signed += 1
    lines = [f"{place}: {why}" for place, why in wrong[:SHOWN]]
    if len(wrong) > SHOWN:
        lines.append(f"and {len(wrong) - SHOWN} more")
    said = f"{len(read)} lines, {len(wrong)} of them wrong" if wrong else f"{len(read)} lines, each follows"
    said += "" if wrong else " the one before"
    said += f"; {signed} signatures are right" if with_signatures else ""
    answer: dict[str, Any] = {"lines": len(read), "wrong": [{"at": at, "why": why} for at, why in wrong]}
    if with_signatures:
        answer["signatures"] = signed
    return CommandAnswer(answer, "\n".join([*lines, said]), exit_code=1 if wrong else 0)


def _wrong_signature(row: Mapping[str, Any], known: _Known) -> str:
    """Reason why a line's signature is not its user's; empty: it is."""
    import base64

    from hil.wire.json_text import read_json

    match row["proof"]:
        case {"key": str(key), "attachment": str(attachment), "payload_base64": str(payload)}:
            try:
                given, data = read_json(attachment), base64.b64decode(payload)
                if not isinstance(given, dict) or given.get("user") != row.get("user"):
                    return f"it was not signed by {row.get('user')}"
                is_by_certificate = "certificate" in given
                return (_wrong_certificate if is_by_certificate else _wrong_mac)(given, key, data, row, known)
            except (ValueError, KeyError, TypeError):
                return "its attachment is no signature"
        case {"payload_sha256": str(_)}:
            return "its payload was too long to be kept: the signature cannot be checked"
    return "it has no whole proof"


def _wrong_mac(
    given: Mapping[str, Any], key: str, payload: bytes, row: Mapping[str, Any], known: _Known
) -> str:
    import hmac

    from hil.net.signature import mac_of

    if (user := given["user"]) not in known.secrets:
        return f"{user} is not in a file of users: --passwords names it"
    expected = mac_of(known.secrets[user], key, payload, given["at_ns"], given["nonce"])
    return "" if hmac.compare_digest(expected, str(given["mac"])) else "the signature is wrong"


def _wrong_certificate(
    given: Mapping[str, Any], key: str, payload: bytes, row: Mapping[str, Any], known: _Known
) -> str:
    import base64
    from contextlib import suppress

    from cryptography.exceptions import InvalidSignature
    from cryptography.x509 import NameOID, load_der_x509_certificate

    from hil.net.signature import is_by_key, text_of

    certificate = load_der_x509_certificate(base64.b64decode(given["certificate"]))
    (name,) = (str(each.value) for each in certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME))
    if name != given["user"] and row.get("operation") != "part":  # a bench asks for who began the run
        return f"it was signed by {name}"
    for authority in known.authorities:
        with suppress(InvalidSignature, ValueError, TypeError):
            certificate.verify_directly_issued_by(authority)
            break
    else:
        return f"the certificate of {name} is of no authority that --authority names"
    text = f"{given['user']}\n".encode() + text_of(key, payload, given["at_ns"], given["nonce"])
    is_right = is_by_key(certificate.public_key(), base64.b64decode(given["signature"]), text)
    return "" if is_right else "the signature is wrong"


def _authorities(path: Path | None) -> Sequence[Any]:
    if path is None:
        return ()
    try:
        from cryptography.x509 import load_pem_x509_certificates
    except ImportError:
        from hil.net.signature import NO_CRYPTOGRAPHY

        raise fail(f"hil: {NO_CRYPTOGRAPHY}") from None
    from hil.host.regular_file import read_regular

    try:
        return load_pem_x509_certificates(read_regular(path))
    except (OSError, ValueError) as error:
        raise fail(f"hil: {path}: {getattr(error, 'strerror', None) or 'it has no certificate'}", 2) from None


def _secrets(path: Path | None) -> dict[str, str]:
    if path is None:
        return {}
    from hil.host.regular_file import read_text

    try:
        rows = [line.split(":", 2) for line in read_text(path).splitlines() if not line.startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        raise fail(f"hil: {path}: {getattr(error, 'strerror', None) or 'it is no text'}", 2) from None
    return {row[0]: row[2] for row in rows if len(row) == 3}


def _since_ns(text: str) -> int:
    for unit, length_s in sorted(_UNITS_S.items(), key=lambda each: -len(each[0])):
        number = text.removesuffix(unit)
        if number != text and number.replace(".", "", 1).isdecimal():
            return time.time_ns() - round(float(number) * length_s * _NS)
    try:
        at = datetime.fromisoformat(text)
        return round((at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp() * _NS)
    except (ValueError, OverflowError):
        raise fail(
            f"hil: --since {text[:80]!r} is no time; write 90s, 30min, 2h, 3d, or 2026-11-29T14:30", 2
        ) from None


def _date(row: Mapping[str, Any]) -> str:
    wall_ns = row.get("wall_ns")
    if not isinstance(wall_ns, int) or not 0 <= wall_ns < 1 << 62:
        return "?"
    return datetime.fromtimestamp(wall_ns // _NS, UTC).strftime("%Y-%m-%d %H:%M:%SZ")
