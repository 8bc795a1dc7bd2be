"""The control socket's verbs about runs."""

from typing import TYPE_CHECKING, Any

from hil.config import ConfigError
from hil.vocab.bridges import LOCAL
from hil.vocab.verbs import VerbRefused

if TYPE_CHECKING:
    from hil.daemon import Daemon


async def submit(daemon: "Daemon", text: str, file: str, check: bool) -> dict[str, Any]:
    """Its progress, or its problems. Nobody here asks twice for what he has asked once."""
    try:
        if check:
            return await daemon.runs.check(LOCAL, text, file)
        return (await daemon.runs.submit(LOCAL, text, file, anew=True)).as_dict()
    except ConfigError as error:
        return {"problems": str(error)}


def states(daemon: "Daemon", name: str) -> list[dict[str, Any]]:
    """Of one run, or with an empty name of all."""
    if name and name not in daemon.runs.progress:
        raise VerbRefused("no_run", f"there is no run {name!r}")
    every = daemon.runs.progress.values()
    return [progress.as_dict() for progress in every if name in ("", progress.run)]


def cancel(daemon: "Daemon", name: str, how: str) -> dict[str, Any]:
    """With "grace" or "prejudice"."""
    if how not in ("grace", "prejudice"):
        raise VerbRefused("bad_parameter", "how is grace or prejudice")
    return daemon.runs.cancel(LOCAL, name, "grace" if how == "grace" else "prejudice").as_dict()


async def benches(daemon: "Daemon") -> list[dict[str, Any]]:
    """The others that are joined."""
    return await daemon.others.joined(LOCAL)
