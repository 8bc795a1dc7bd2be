"""Permissions. Each operation (``table.py``) and each verb of a board has its role; a door finds out who
asks, and which role that is."""

from hil.vocab.desk_protocol import Source
from hil.vocab.verbs import Role, VerbRefused


def require_role(source: Source, what: str, role: Role) -> None:
    """Refuse an asker with less than this role. ``what``: the operation or the verb, for the text.

    Raises:
        VerbRefused: it is not allowed.
    """
    if source.role < role:
        raise VerbRefused("forbidden", f"{what} needs the role {role.name.lower()}")
