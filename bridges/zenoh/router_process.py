"""Router of a site as a process: it takes new lists of members and new certificates while it runs."""

import logging
import signal
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from typing import Any

import zenoh

from bridges.zenoh.options import TlsOptions
from bridges.zenoh.site_folder import AUTHORITY, CERTIFICATE, KEY, SiteFolder
from bridges.zenoh.users import SecurityError
from bridges.zenoh.zenoh_config import opened, router_config

log = logging.getLogger("hil")

LOOK_S = 1.0
OPEN_S = 10.0
"""Maximum time for the address to be free again."""
_ENDS = {signal.SIGINT, signal.SIGTERM}


def site_entries(folder: SiteFolder, listen: Sequence[str]) -> dict[str, Any]:
    """Zenoh's configuration of a site's router, by the list that the folder has now.

    Raises:
        SecurityError: an address is open to strangers.
    """
    of = folder.folder
    tls = TlsOptions(ca=of / AUTHORITY, certificate=of / CERTIFICATE, key=of / KEY)
    return router_config(listen, tls, False, site=folder.list)


def default_listen(folder: SiteFolder) -> list[str]:
    """Addresses at which the list says that the router is, on all interfaces."""
    found = []
    for each in folder.list.routers:
        scheme, _, rest = each.partition("/")
        host, _, port = rest.rpartition(":")
        found.append(f"{scheme}/{'[::]' if host.startswith('[') else '0.0.0.0'}:{port}")
    return list(dict.fromkeys(found))


def close(session: zenoh.Session) -> None:
    with suppress(zenoh.ZError):  # clients that do not read hold it up
        session.close()  # type: ignore[no-untyped-call]


class SiteRouter:
    """Router of a site, which is open until ``close``. Zenoh's access control is fixed while a session is
    open: a list that lets in others opens the next session, and all connect again.

    Raises:
        SecurityError: an address is open to strangers.
        zenoh.ZError: an address is taken.
    """

    def __init__(self, folder: SiteFolder, listen: Sequence[str]) -> None:
        self._folder, self._listen = folder, listen
        self._entries, self._version = site_entries(folder, listen), folder.version
        self._session = opened(self._entries)

    def look(self, now: datetime) -> None:
        """Take files that were replaced in the folder."""
        folder = self._folder
        try:
            folder.refresh(now)
        except (SecurityError, OSError) as error:
            log.error("%s; list %d stays", error, folder.list.number)
        if folder.version == self._version:
            return
        is_renewed = folder.version[1] != self._version[1]
        self._version, before = folder.version, self._entries
        self._entries = site_entries(folder, self._listen)
        log.info("took list %d of the site %s", folder.list.number, folder.list.site)
        if is_renewed or self._entries != before:
            self.close()
            self._session = _opened(self._entries)

    def close(self) -> None:
        close(self._session)


def serve_site(router: SiteRouter) -> None:
    """Serve until a signal, which the caller has blocked."""
    while signal.sigtimedwait(_ENDS, LOOK_S) is None:
        router.look(datetime.now(UTC))
    router.close()


def _opened(entries: Mapping[str, Any]) -> zenoh.Session:
    """Open the session again; the address may need a moment. Raises zenoh.ZError."""
    until_s = time.monotonic() + OPEN_S
    while True:
        try:
            return opened(entries)
        except zenoh.ZError:
            if time.monotonic() > until_s:
                raise
            time.sleep(0.05)
