"""Kind of axis with a board's own fields: each stands in the place of a field that the kind has not, so that
the binary layout is the same for all."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache

from hil.core.axis_kind import AxisKind, NoRoom, Settable
from hil.core.fields import FIELDS, INDEX, Field
from hil.vocab.faults import OWN_FIELD
from hil.vocab.own_fields import OwnField

_DRAWN = 4
"""Number of a board's own fields that are drawn by default."""


def free_places(kind: AxisKind, type_: str) -> list[int]:
    """Indices in the table of the fields of a type that a kind of axis has not."""
    taken = set(kind.fields.values())
    return [INDEX[name] for name, field in FIELDS.items() if field.type == type_ and INDEX[name] not in taken]


@lru_cache
def kind_with_fields(kind: AxisKind, own: tuple[OwnField, ...]) -> AxisKind:
    """Kind of axis that has these fields too. Raises NoRoom."""
    made = {each.name: (_field(each), index) for each, index in _placed(kind, own)}
    return replace(
        kind,
        fields={**kind.fields, **{name: index for name, (_, index) in made.items()}},
        own_fields={**kind.own_fields, **{name: field for name, (field, _) in made.items()}},
        default_signals=kind.default_signals or tuple(made)[:_DRAWN],
        settable={
            **kind.settable,
            **{each.name: Settable(each.low, each.high, is_around=True) for each in own if each.is_input},
        },
        board_fields={each.name: each for each in own},
        fault_targets=kind.fault_targets | {OWN_FIELD},
    )


def _placed(kind: AxisKind, own: tuple[OwnField, ...]) -> Iterator[tuple[OwnField, int]]:
    room = {type_: free_places(kind, type_) for type_ in {each.type for each in own}}
    free = {type_: iter(places) for type_, places in room.items()}
    for each in own:
        index = next(free[each.type], None)
        if index is None:
            raise NoRoom(each.name, len(room[each.type]))
        yield each, index


def _field(own: OwnField) -> Field:
    return Field(own.name, own.type, own.unit, own.is_input, own.about)
