"""Users' file: names, roles and passwords."""

import errno
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hil.vocab.desk_protocol import Source
from hil.vocab.problem import not_text
from hil.vocab.verbs import Role

SECRET_CHARACTERS = 12
"""Minimum length of a secret. Without TLS, a listener on the wire can try passwords on what it has heard."""
BENCH = "bench"
"""Word for a bench in the place of a role."""
_FILE_CHARACTERS = 1 << 20
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")


class SecurityError(Exception):
    """Error of a bridge that cannot be opened safely: ``str(error)`` says why and what to do."""


@dataclass(frozen=True)
class User(Source):
    """User of the users' file. The secret is the password at zenoh's door and the key of signatures;
    users of a site have none. ``is_bench``: a bench of this name, which a router lets tell what is below
    it; other benches take it for an operator."""

    secret: str = field(default="", repr=False)
    is_bench: bool = False


def read_users(path: Path) -> list[User]:
    """Read the users of a file: a line ``name:role:password`` for each; ``#`` begins a line that is skipped.

    Raises:
        SecurityError: it cannot be read, others can read it, or lines are wrong; with all of them.
    """
    try:
        refuse_endless(path)
        with path.open(encoding="utf-8-sig") as file:
            mode = os.fstat(file.fileno()).st_mode & 0o777
            lines = file.read(_FILE_CHARACTERS).splitlines()
    except UnicodeDecodeError as error:
        raise SecurityError(str(not_text(str(path), error))) from None
    except OSError as error:
        raise SecurityError(f"{path}: {error.strerror}; `hil zenoh keys` makes such a file") from None
    if mode & 0o077:
        raise SecurityError(f"{path}: others can read it (mode {mode:04o}); chmod 600 {path}")
    users = parse_users(lines, str(path))
    if not users:
        raise SecurityError(f"{path}: there is no user; write lines like anna:operator:PASSWORD")
    return users


def refuse_endless(path: Path) -> None:
    """Refuse a FIFO, a device and what is below /proc: they may have no end, or none soon.

    Raises:
        OSError: it is one of those, or not there.
    """
    if not path.is_dir() and not (path.is_file() and path.stat().st_size) and path.exists():
        raise OSError(errno.EINVAL, "it is empty, or no regular file")


def parse_users(lines: Sequence[str], where: str) -> list[User]:
    """Parse the users of such lines. ``where`` stands before a line's number in errors."""
    users: list[User] = []
    problems = []
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            users.append(_user(line, users))
        except ValueError as error:
            problems.append(f"{where}:{number}: {error}")
    if problems:
        raise SecurityError("\n".join(problems))
    return users


def _user(line: str, before: Sequence[User]) -> User:
    name, _, rest = line.partition(":")
    role, _, secret = rest.partition(":")
    if not secret:
        raise ValueError("write name:role:password")
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is no name: letters, digits, _ . - and at most 64 of them")
    roles = {each.name.lower(): each for each in Role} | {BENCH: Role.OPERATOR}
    if role not in roles:
        raise ValueError(f"there is no role {role!r}; there are {', '.join(roles)}")
    if len(secret) < SECRET_CHARACTERS or not secret.isprintable() or secret != secret.strip():
        raise ValueError(
            f"the password needs {SECRET_CHARACTERS} printable characters or more, no space around"
        )
    if any(name == other.name for other in before):
        raise ValueError(f"{name} is there twice")
    if any(secret == other.secret for other in before):
        raise ValueError(f"{name} has the same password as another user: their signatures would be the same")
    return User(name, roles[role], secret, is_bench=role == BENCH)
