"""Faces of the wires of a bus that hil does not have."""

from types import SimpleNamespace

import pytest

from hil.testing.faces import TapFace
from hil.testing.wire_faces import WireFaces
from hil.vocab.bus import FaceKind, WireKind
from hil.vocab.wire import WireInfo

RING = object()
TAP = SimpleNamespace(name="r.client", listeners=[])


class RingTap(TapFace):
    """Face of a tap of a ring."""


def faces(kit: FaceKind | None) -> WireFaces:
    kind = WireKind(
        key="rings",
        about="Rings.",
        model=lambda: object,
        findings=lambda config, devices, real: [],
        fault_places=lambda name, ring, devices: {},
        info=WireInfo("rings", "ring", lambda reports: (), ()),
        add=lambda bench, config, catalogue: None,
        kit=kit,
    )
    runtime = SimpleNamespace(wires={"r": SimpleNamespace(kind="rings")}, wires_of=lambda key: {"r": RING})
    return WireFaces("the bench", runtime, [kind])


def test_a_wire_has_the_face_that_its_bus_makes_once() -> None:
    made = faces(FaceKind("ring", lambda bench, runtime, wire: [bench, wire]))
    face = made.wire("rings", "r")
    assert face == ["the bench", RING]
    assert made.wire("rings", "r") is face


def test_what_is_not_there_is_said_in_the_words_of_its_bus() -> None:
    made = faces(FaceKind("ring", lambda bench, runtime, wire: wire))
    with pytest.raises(KeyError, match="ring"):
        made.wire("rings", "q")
    with pytest.raises(KeyError, match="bus"):
        faces(None).wire("rings", "r")


@pytest.mark.parametrize(("own", "wanted"), [(RingTap, RingTap), (None, TapFace)])
def test_a_tap_has_its_bus_s_face_or_the_usual_one(own: type[TapFace] | None, wanted: type[TapFace]) -> None:
    kit = FaceKind("ring", lambda bench, runtime, wire: wire, own)
    assert type(faces(kit).tap("r.client", TAP)) is wanted
