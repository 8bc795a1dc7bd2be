"""Model of a fault that a configuration has from the start. The descriptions are the reference's text."""

from pydantic import BaseModel, ConfigDict, Field


class FaultConfig(BaseModel):
    """A fault, where it is and from when to when; beside these keys those of its kind."""

    model_config = ConfigDict(strict=True, extra="allow", frozen=True, allow_inf_nan=False, defer_build=True)

    fault: str = Field(description="Its kind.")
    target: str = Field(description="What it is on, as in `s2`.")
