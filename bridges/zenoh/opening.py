"""Opens a daemon's zenoh session with its users, and the gate that checks what they send."""

import os
import time

import zenoh

from bridges.zenoh.gate import Gate
from bridges.zenoh.options import Options
from bridges.zenoh.users import SecurityError, read_users, refuse_endless
from bridges.zenoh.zenoh_config import made, session_config


def open_session(options: Options, bench: str) -> tuple[zenoh.Session, Gate | None]:
    """A daemon's session, and what checks its commands; None: there are no users, everybody may do all.

    Raises:
        SecurityError: strangers could reach the bench, or the users' file is wrong.
        zenoh.ZError: an address is taken, a certificate cannot be read.
    """
    users = read_users(options.users) if options.users else []
    for path in (options.tls.ca, options.tls.certificate, options.tls.key) if options.tls else ():
        try:
            refuse_endless(path)
            path.open("rb").close()  # zenoh would only say that nobody is there
        except OSError as error:
            why = f"cannot be read: {error.strerror}"
            raise SecurityError(f"tls: {path} {why}; `hil zenoh keys` makes such files") from None
    # Zenoh wants passwords in a file. This one is in memory, of this process, and gone afterwards.
    memory = os.memfd_create("users")
    try:
        os.write(memory, "".join(f"{user.name}:{user.secret}\n" for user in users).encode())
        entries = session_config(options, bench, users, f"/proc/self/fd/{memory}")
        return zenoh.open(made(entries)), Gate(users, time.time_ns()) if users else None
    finally:
        os.close(memory)
