"""Model of names and ports in a configuration, checked."""

from typing import Annotated

from pydantic import BaseModel, Field, SerializeAsAny

from hil.config.explain import StrictModel
from hil.vocab.address import NAME_PATTERN

SERIAL = "serial"
"""Kind of port at which hil itself uses a real adapter."""

USUAL_BAUD = 38400
"""Speed of a segment without stations, if nobody says another."""

Name = Annotated[str, Field(pattern=NAME_PATTERN)]


class PortConfig(StrictModel):
    """Port at which clients reach a device: its kind and that kind's own options."""

    kind: str
    options: SerializeAsAny[BaseModel]
