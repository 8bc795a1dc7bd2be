"""Kinds of nodes that a line may have, by what is known of it."""

import pytest

from hil.master.line_place import LineUnreachable, nodes_of


@pytest.mark.parametrize("framing", [None, "sac", "bytes"])
def test_a_line_of_which_nobody_says_what_it_speaks_may_have_any_nodes(framing: str | None) -> None:
    assert nodes_of(None, framing).framing.name == "sac"


def test_a_line_that_speaks_something_else_has_no_master() -> None:
    with pytest.raises(LineUnreachable, match="no master for a line with the framing modbus_rtu"):
        nodes_of(None, "modbus_rtu")
