import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil.vocab.address import NAME_PATTERN, Address, DeviceParts, address_of, no_part, owner_of, pin_of

NAMES = st.from_regex(NAME_PATTERN.replace("$", r"\Z"))


@given(NAMES, NAMES)
def test_an_address_is_read_as_it_is_written(owner: str, part: str) -> None:
    for address in (Address(owner), Address(owner, part)):
        assert address_of(str(address)) == address
        assert owner_of(str(address)) == owner


@given(st.text(max_size=20))
def test_no_text_is_more_than_it_says(text: str) -> None:
    owner, part = address_of(text)
    assert str(Address(owner, part)) in (text, text + ".")
    assert owner_of(text) == owner


def test_a_point_without_a_name_behind_it_is_not_the_first() -> None:
    assert address_of("m1.") == ("m1", ".")
    assert "." not in DeviceParts({"main": 1})


@pytest.mark.parametrize(
    ("text", "axis", "pin"),
    [("m1.step", "m1", "step"), ("arm.elbow.step", "arm.elbow", "step"), ("step", "", "step")],
)
def test_the_last_name_of_a_pin_is_the_pin(text: str, axis: str, pin: str) -> None:
    assert pin_of(text) == (axis, pin)


def test_the_first_part_has_the_address_of_its_device() -> None:
    axes = DeviceParts({"shoulder": 1, "elbow": 2})
    assert [axes.label("arm", name) for name in ("", *axes)] == ["arm", "arm", "arm.elbow"]
    assert [axes[name] for name in ("", "shoulder", "elbow")] == [1, 1, 2]
    assert [axes.short(name) for name in axes] == ["", "elbow"]
    assert "" in axes
    assert "wrist" not in axes


def test_a_device_without_parts_has_no_first() -> None:
    axes = DeviceParts[int]({})
    assert (axes.first, len(axes), "" in axes, axes.get("")) == ("", 0, False, None)
    assert axes.label("pinger", "") == "pinger"


@pytest.mark.parametrize(
    ("name", "known", "said"),
    [
        ("elbo", {"elbow": 1, "wrist": 2}, "arm has no axis 'elbo'; it has elbow, wrist"),
        ("elbo", {}, "arm has no axis 'elbo'; it has none"),
        ("", {}, "arm has no axis"),
    ],
)
def test_what_a_device_does_not_have(name: str, known: dict[str, int], said: str) -> None:
    assert no_part("arm", "axis", name, known) == said
