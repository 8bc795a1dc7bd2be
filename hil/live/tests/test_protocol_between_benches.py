"""The version of what benches say to each other: another one is refused before anything moves."""

import pytest

from hil.live.runs.other_benches import protocol_of, refuse_protocol
from hil.vocab.bridge_protocol import PROTOCOL_VERSION
from hil.vocab.verbs import VerbRefused


def test_another_protocol_is_refused_before_anything_moves() -> None:
    newer = {"protocol": PROTOCOL_VERSION + 1}
    for question in ("look", "join"):
        with pytest.raises(VerbRefused) as caught:
            refuse_protocol(question, "the bench lathe", newer, "mill")
        said = f"the bench lathe speaks protocol {PROTOCOL_VERSION + 1} between benches, and mill"
        assert str(caught.value) == f"{said} {PROTOCOL_VERSION}: update hil on mill"
        with pytest.raises(VerbRefused, match=r"protocol 0 between .* update hil on the bench lathe"):
            refuse_protocol(question, "the bench lathe", {}, "mill")
    refuse_protocol("join", "the bench lathe", {"protocol": PROTOCOL_VERSION}, "mill")
    refuse_protocol("stop", "the bench lathe", newer, "mill")


@pytest.mark.parametrize("told", [None, "1", True, 1.0, []])
def test_what_is_no_version_is_none(told: object) -> None:
    assert protocol_of({"protocol": told}) == 0
