"""Files that come with hil beside its modules: in a checkout, in an environment or a folder into which a
wheel was installed, or where the Debian package has put them."""

from pathlib import Path

_UP = tuple(Path(__file__).parents)
_ROOT = _UP[2]
_SHARES = (
    _ROOT / "share" / "hil",  # pip install --target
    _UP[min(5, len(_UP) - 1)]
    / "share"
    / "hil",  # of lib/python3.x/site-packages, an environment's or a user's
    Path("/usr/share/hil"),
)


def installed(name: str) -> Path | None:
    """Find a file or a folder by its name in the checkout, as in ``wireshark/sac_packets.lua``; None: this
    installation came without it."""
    return next((path for place in (_ROOT, *_SHARES) if (path := place / name).exists()), None)
