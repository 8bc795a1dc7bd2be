"""Reason why a bench cannot join its routers, for its log."""

from bridges.zenoh.options import Options
from bridges.zenoh.users import read_users
from hil.net.door_check import first_reason


def why_not_joined(options: Options, bench: str, is_of_site: bool) -> str:
    """Sentence about the first router that does not let the bench in; takes two seconds at the most.
    ``is_of_site``: its certificate stands for it."""
    tls = {}
    if options.tls:
        files = options.tls.ca, options.tls.certificate, options.tls.key
        names = "root_ca_certificate", "connect_certificate", "connect_private_key"
        tls = dict(zip(names, map(str, files), strict=True))
    known = read_users(options.users) if options.users else []
    user = bench if is_of_site or any(each.name == bench for each in known) else None
    return first_reason(options.connect, tls, user, is_key_known=is_of_site).text
