"""Driver of labgrid: the face of a live bench, for a test that has the place."""

import os
from contextlib import ExitStack
from typing import Any

import attr
from labgrid.driver import Driver
from labgrid.driver.exception import ExecutionError
from labgrid.factory import target_factory

from hil.client import Axis, Bench, ClientError, connect_sync
from hil.client.held_bench import held


@target_factory.reg_driver
@attr.s(eq=False)
class HilBenchDriver(Driver):  # type: ignore[misc,unused-ignore]
    """Face of a bench while the driver is active. ``config``: a user's zenoh.json as `hil zenoh keys` makes
    it, which says the door too, or the variable HIL_LAB_CONFIG names one; without it the resource's door is
    asked without a user. ``lease``: take the bench's lease for that time, which needs a user; ``doors``:
    those that stay open meanwhile.

    Raises:
        ExecutionError: the bench is away, or somebody else has it.
    """

    bindings = {"resource": {"HilBench"}}  # noqa: RUF012 - as labgrid has it
    config: str = attr.ib(default="", validator=attr.validators.instance_of(str))
    lease: bool = attr.ib(default=True, validator=attr.validators.instance_of(bool))
    doors: list[str] = attr.ib(factory=list, validator=attr.validators.instance_of(list))

    def __attrs_post_init__(self) -> None:
        super().__attrs_post_init__()
        self._stack = ExitStack()
        self._face: Bench | None = None

    def on_activate(self) -> None:
        """Connect to the bench, and take its lease."""
        config = self.config or os.environ.get("HIL_LAB_CONFIG", "")
        if config and self.target.env:
            config = self.target.env.config.resolve_path(config)
        name = self.resource.bench
        try:
            face = self._stack.enter_context(connect_sync(name, self.resource.connect, config=config or None))
            if self.lease and config:
                why = f"labgrid: {self.target.name}"
                self._stack.enter_context(held(face, why, doors=self.doors))
        except ClientError as error:
            self._stack.close()
            raise ExecutionError(f"the bench {name} cannot be had: {error}") from None
        self._face = face

    def on_deactivate(self) -> None:
        """Give the bench back."""
        self._face = None
        self._stack.close()

    @property
    def face(self) -> Bench:
        """Bench that is connected, with runs and leases. Raises ExecutionError: the driver is not active."""
        if self._face is None:
            raise ExecutionError("the driver of the bench is not active: `target.activate(driver)`")
        return self._face

    def axis(self, name: str) -> Axis:
        """Axis of a device, with its verbs."""
        return self.face.axis(name)

    def perform(self, run: Any, **options: Any) -> dict[str, Any]:
        """Submit a run and wait for its end; options as of ``hil.client.Bench.perform``."""
        return self.face.perform(run, **options)

    def read(self, key: str) -> dict[str, Any]:
        """Read the document under a key of the bench, as in ``sim/health``."""
        return self.face.read(key)
