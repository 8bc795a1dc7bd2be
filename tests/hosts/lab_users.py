"""Users x router x TLS x role x run x restart. Each bench and the router are on computers of their own,
behind links with delay and jitter; users ask from another."""

import pytest
from e2e_support import Place
from host_network import HostNetwork
from test_e2e_hosts import WAYS, roles_runs_and_restarts, setting


@pytest.mark.parametrize("way", WAYS)
def test_roles_runs_and_restarts_over_a_network(place: Place, network: HostNetwork, way: str) -> None:
    made = network.computers("router", "mill", "lathe")
    for computer in made.values():
        computer.link.set(delay_ms=2, jitter_ms=0.5)
    prefixes = {name: computer.prefix for name, computer in made.items()}
    with setting(place, **WAYS[way], host=made["router"].address, prefixes=prefixes) as behind:
        roles_runs_and_restarts(behind)
