"""Locks of the door: none, a token, or a user's password."""

import asyncio
import hmac
import secrets
from collections.abc import Mapping
from typing import Any

from bridges.web.password_hash import fits, hash_of
from bridges.web.web_users import ROLES, WebUser
from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import Role

PASSWORD_CHARACTERS = 1024
CHECKS = 8
"""Passwords that wait to be checked at a time; each takes 0.2 s of another thread."""


class NoLock:
    """Nobody has to log in: all are admins, as at the control socket."""

    way = "none"
    open_to: Source | None = Source("web", Role.ADMIN, door="web")

    async def opened(self, given: Mapping[str, Any]) -> Source | None:
        return self.open_to


class TokenLock:
    """A token that was made at the start; who has it has the role."""

    way = "token"
    open_to: Source | None = None

    def __init__(self, role: str) -> None:
        self.token = secrets.token_urlsafe(24)
        self._source = Source("web", ROLES[role], door="web")

    async def opened(self, given: Mapping[str, Any]) -> Source | None:
        match given:
            case {"token": str(token)}:
                same = hmac.compare_digest(token.encode("utf-8", "surrogatepass"), self.token.encode())
                return self._source if same else None
        return None


class PasswordLock:
    """Users with passwords. The work is the same for a name that nobody has."""

    way = "password"
    open_to: Source | None = None

    def __init__(self, users: Mapping[str, WebUser]) -> None:
        self._users = users
        self._nobody = hash_of(secrets.token_urlsafe(24), secrets.token_bytes(16))
        self._turn = asyncio.Lock()
        self._waiting = 0

    async def opened(self, given: Mapping[str, Any]) -> Source | None:
        match given:
            case {"user": str(name), "password": str(password)} if len(password) <= PASSWORD_CHARACTERS:
                return await self._checked(self._users.get(name), password)
        return None

    async def _checked(self, user: WebUser | None, password: str) -> Source | None:
        if self._waiting >= CHECKS:
            return None
        self._waiting += 1
        try:
            async with self._turn:
                expected = user.password_hash if user else self._nobody
                is_right = await asyncio.to_thread(fits, password, expected)
        finally:
            self._waiting -= 1
        return Source(user.name, user.role, via="web") if user and is_right else None
