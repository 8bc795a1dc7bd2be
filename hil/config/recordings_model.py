"""Model of what is kept of a bench's recordings."""

from pydantic import Field

from hil.config.explain import StrictModel


class RecordingsConfig(StrictModel):
    """Numbers of recordings that are kept of a bench's runs."""

    keep_runs: int = Field(
        default=20,
        ge=0,
        le=100_000,
        description="Number of runs whose recordings are kept, this one among them: of more the oldest go"
        " when the bench starts. 0: nothing is recorded, and none is removed.",
    )
    keep_MB: int = Field(
        default=500,
        ge=1,
        le=1_000_000,
        description="Room for all of them, in millions of bytes: the oldest go when it is used. When the"
        " recording of the run that goes on takes all of it, that recording ends, and the bench goes on.",
    )


KEPT_RECORDINGS = Field(
    default=RecordingsConfig(),
    description="What is kept of the recordings of the bench's runs, which `hil recordings` lists; a"
    " change takes effect at the next start.",
)
"""Key `recordings` of a bench."""
