"""Two networks with a bench of one name in each, which become one and part again."""

import json
from typing import Any

import pytest
import zenoh
from bench_sites import Site
from e2e_support import Place, Server, until
from host_network import HostNetwork
from plain_zenoh import QUIET

from hil.client import ClientError, connect_sync


def says(server: Server) -> str:
    return str([each["what"] for each in server.ask("health")["problems"] if each["kind"] == "name"])


def test_two_of_one_name_after_two_networks_join(network: HostNetwork) -> None:
    made = network.computers("east", "mill1", "west", "mill2")
    for name in ("west", "mill2"):
        made[name].link.join(2)
    with Place() as first, Place() as second:
        sites = []
        for place, router, bench in ((first, "east", "mill1"), (second, "west", "mill2")):
            prefixes = {"router": made[router].prefix, "mill": made[bench].prefix}
            sites.append(Site(place, {"mill": made[router].endpoint()}, prefixes))
        for site in sites:
            site.join()
        try:
            servers = [site.launch("mill").started().ready() for site in sites]
            assert [says(server) for server in servers] == ["[]", "[]"]
            with joined(made["east"].endpoint(), made["west"].endpoint()):
                for name in ("west", "mill2"):
                    made[name].link.join()
                for server in servers:
                    until(lambda s=server: "more joined as mill" in says(s), "the other to be noticed")  # type: ignore[misc]
                with pytest.raises(ClientError, match="2 benches are called 'mill'"):
                    connect_sync("mill", made["east"].endpoint(), timeout_s=10)
                for name in ("west", "mill2"):
                    made[name].link.join(2)
                for server in servers:
                    until(lambda s=server: says(s) == "[]", "the other to be gone")  # type: ignore[misc]
            with connect_sync("mill", made["east"].endpoint(), timeout_s=10) as client:
                assert client.axis("m1").enable().effective_at_ns
        finally:
            for site in sites:
                site.part()


def joined(*endpoints: str) -> zenoh.Session:
    """Router at the desk that joins two others, as soon as it reaches them."""
    values: dict[str, Any] = {
        **QUIET,
        "mode": "router",
        "connect/endpoints": list(endpoints),
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
    }
    config = zenoh.Config()
    for path, value in values.items():
        config.insert_json5(path, json.dumps(value))
    return zenoh.open(config)
