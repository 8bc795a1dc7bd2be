"""Dataclasses that are made when they are first used, against those of the standard library."""

import subprocess
import sys

CODE = """
import dataclasses, sys
from hil.vocab.late_dataclass import dataclass, make_later

make_later()

@dataclass(frozen=True)
class Base:
    a: int
    b: list[int] = dataclasses.field(default_factory=list)

@dataclass(frozen=True, kw_only=True)
class Below(Base):
    c: str = "c"

@dataclass
class Own:
    a: int = 1
    def __post_init__(self):
        self.doubled = 2 * self.a

@dataclass(slots=True)
class Slots:
    a: int

class Plain(Own):
    def __init__(self):
        super().__init__(3)

assert "__eq__" not in vars(Base) and "__eq__" not in vars(Below)
assert [each.name for each in dataclasses.fields(Below)] == ["a", "b", "c"]
assert "__eq__" in vars(Base), "the one below is made of it"
one, same = Below(1, c="d"), Below(1, c="d")
assert one == same and repr(one) == "Below(a=1, b=[], c='d')" and dataclasses.replace(one, a=2).a == 2
assert Plain().doubled == 6 and Own() == Own(1) and dataclasses.is_dataclass(Own)
assert not hasattr(Slots(1), "__dict__")
try:
    one.a = 2
except dataclasses.FrozenInstanceError:
    pass
else:
    raise AssertionError
try:
    Base()
except TypeError as error:
    assert "'a'" in str(error), error
"""


def test_is_made_when_it_is_used() -> None:
    """In a process of its own: what is imported later there is made later."""
    subprocess.run([sys.executable, "-c", CODE], check=True)


def test_is_made_at_once() -> None:
    code = CODE.replace("\nmake_later()\n", "\n").replace("not in", "in")
    subprocess.run([sys.executable, "-c", code], check=True)
