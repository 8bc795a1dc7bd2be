"""Model of a bench's labels: words by which benches of a lab are chosen."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from hil.config.port_model import Name
from hil.vocab.bench_labels import LABEL_CHARACTERS, is_label_value

MOST_LABELS = 64


def _label_value(value: str) -> str:
    if is_label_value(value):
        return value
    shape = f"a label is one word: letters, digits and . _ / : -, at most {LABEL_CHARACTERS} characters"
    raise PydanticCustomError("label", "this is no label", {"remedy": shape})


Labels = Annotated[
    Mapping[Name, Annotated[str, AfterValidator(_label_value)]],
    Field(
        max_length=MOST_LABELS,
        description='Words by which benches of a lab are chosen, as in `{rig: press, floor: "2"}`:'
        " `hil list --label rig=press`. A change takes effect with a reload.",
    ),
]
