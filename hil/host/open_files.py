"""The limit of open files: a pseudo-terminal takes three, so the usual 1024 end at 300."""

import resource

WANTED = 65_536


def allow_many() -> None:
    """Raise the limit in force as far as the process itself may, to WANTED at most."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = WANTED if hard == resource.RLIM_INFINITY else min(hard, WANTED)
    if soft != resource.RLIM_INFINITY and soft < most:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
