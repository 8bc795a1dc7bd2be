"""Kinds of axis, a folder for each control law.

``kind.py`` has all that hil asks of the kind, in the form of ``hil.core.axis_kind``; beside it is the face of
an axis that is more than others. No other module names a law. The law itself is C, in ``native/law``.
"""

from collections.abc import Mapping

from hil.core.axis_kind import AxisKind
from hil.core.kinds.a3967.kind import KIND as A3967
from hil.core.kinds.as5047d.kind import KIND as AS5047D
from hil.core.kinds.mechaduino.kind import KIND as MECHADUINO
from hil.core.kinds.own_fields.kind import KIND as OWN_FIELDS
from hil.core.kinds.own_fields.with_fields import kind_with_fields
from hil.core.kinds.pin_bank.kind import KIND as PIN_BANK
from hil.core.kinds.pin_bank.named_pins import named_kind
from hil.core.kinds.sac.kind import KIND as SAC
from hil.core.kinds.walter.kind import KIND as WALTER
from hil.vocab.axis_plan import ProcessorPlan
from hil.vocab.own_fields import OwnField

KINDS: Mapping[str, AxisKind] = {
    kind.law.name: kind for kind in (MECHADUINO, SAC, WALTER, A3967, PIN_BANK, AS5047D, OWN_FIELDS)
}
"""Kinds of axis by their laws' names in ``profile.yaml``."""

PROCESSOR_LAWS = (PIN_BANK.law.name,)
"""Names of laws of pins that a processor can have."""


FIELDS_LAW = OWN_FIELDS.law.name
"""Name of the law of a board that has fields of its own, and no axis."""


def kind_of(law: str, processor: ProcessorPlan | None = None, fields: tuple[OwnField, ...] = ()) -> AxisKind:
    """Kind of axis by its law's name; pins of a processor have the names that their board gives them.
    ``fields``: those of the board's own that it has too.

    Raises:
        KeyError: there is no such law.
        NoRoom: it has no place for so many fields.
    """
    kind = named_kind(processor.pins) if processor and processor.pins else KINDS[law]
    return kind_with_fields(kind, fields) if fields else kind
