"""Users' file of the web bridge: names, roles and hashes of passwords."""

import os
import re
import stat
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from bridges.web.password_hash import is_hash
from hil.vocab.desk_protocol import Source
from hil.vocab.problem import not_text
from hil.vocab.verbs import Role

PASSWORD_CHARACTERS = 12
"""Minimum length of a password. Decision: the one of the zenoh bridge's users."""
ROLES: Mapping[str, Role] = {each.name.lower(): each for each in Role}
MAKES_ONE = "`hil web user NAME:ROLE` makes a line"
_FILE_CHARACTERS = 1 << 20
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")


class UserProblem(NamedTuple):
    """Mistake in the file, and what to do."""

    message: str
    remedy: str


class UsersError(Exception):
    """Error of a users' file that cannot be used: ``str(error)`` has all problems, a line for each."""

    def __init__(self, problems: Sequence[UserProblem]) -> None:
        super().__init__("\n".join(f"{message}; {remedy}" for message, remedy in problems))
        self.problems = list(problems)


@dataclass(frozen=True)
class WebUser(Source):
    """User of the file."""

    password_hash: str = field(repr=False)


def read_users(path: Path) -> dict[str, WebUser]:
    """Read the users of a file by name: a line ``name:role:hash`` for each; ``#`` begins a line that is
    skipped.

    Raises:
        UsersError: it cannot be read, others can read it, or lines are wrong; with all of them.
    """
    at = path.absolute()
    try:
        if path.exists() and not path.is_file():  # of a fifo a read would not end
            raise UsersError([UserProblem(f"{at} is no file", "write where the file is")])
        with path.open(encoding="utf-8-sig") as file:
            mode = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
            lines = file.read(_FILE_CHARACTERS).splitlines()
    except UnicodeDecodeError as error:
        wrong = not_text(str(at), error)
        said = f"{at}:{wrong.line}:{wrong.column}: {wrong.message}"
        raise UsersError([UserProblem(said, wrong.remedy)]) from None
    except OSError as error:
        raise UsersError([UserProblem(f"{at}: {error.strerror}", MAKES_ONE)]) from None
    if mode & 0o077:
        raise UsersError([UserProblem(f"{at}: others can read it (mode {mode:04o})", f"chmod 600 {at}")])
    return parse_users(lines, str(at))


def parse_users(lines: Sequence[str], where: str) -> dict[str, WebUser]:
    """Parse the users of such lines, by name. ``where`` stands before a line's number in problems.

    Raises:
        UsersError: lines are wrong, or there is no user.
    """
    users: dict[str, WebUser] = {}
    first_lines: dict[str, int] = {}
    problems: list[UserProblem] = []
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("#"):
            continue
        try:
            user = user_of(line)
            if first := first_lines.get(user.name):
                said = f"{where}:{number}: {user.name} is there twice, first in line {first}"
                problems.append(UserProblem(said, "remove one of the two"))
                continue
            users[user.name], first_lines[user.name] = user, number
        except ValueError as error:
            problems.append(UserProblem(f"{where}:{number}: {error}", MAKES_ONE))
    if not problems and not users:
        problems.append(UserProblem(f"{where}: there is no user", MAKES_ONE))
    if problems:
        raise UsersError(problems)
    return users


def user_of(line: str) -> WebUser:
    """Parse one line. Raises ValueError: the text says what is wrong with it."""
    name, colon, rest = line.rstrip().partition(":")
    if not colon:
        raise ValueError(f"{name[:80]!r} is no line of a user")
    role, _, password_hash = rest.partition(":")
    name, known = named_role(f"{name}:{role}")
    if not is_hash(password_hash):
        raise ValueError(f"behind {name}:{role}: there is no hash of a password")
    return WebUser(name, known, password_hash)


def named_role(text: str) -> tuple[str, Role]:
    """Parse ``NAME:ROLE``. Raises ValueError: the text says what is wrong with it."""
    name, _, role = text.partition(":")
    if not _NAME.fullmatch(name):
        raise ValueError(f"{name[:80]!r} is no name: letters, digits, _ . - and at most 64 of them")
    if not role:
        raise ValueError(f"{name!r} has no role; write NAME:ROLE, as {name}:viewer")
    if role not in ROLES:
        raise ValueError(f"there is no role {role[:80]!r}; there are {', '.join(ROLES)}")
    return name, ROLES[role]


def password_problem(password: str) -> str | None:
    """Reason why a text cannot be a password, or None."""
    if len(password) < PASSWORD_CHARACTERS:
        return f"a password has {PASSWORD_CHARACTERS} characters or more"
    if not password.isprintable() or password != password.strip():
        return "a password has printable characters alone, and no space around"
    return None
