"""Client for programs without asyncio."""

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from hil.client.link import ENDPOINT, TIMEOUT_S, Credentials, Link
from hil.client.messages import Ack, ClientError, State, ack_of, read, state_of
from hil.client.verbs import MOTION_S, AxisVerbs


class Axis(AxisVerbs[Ack]):
    """Axis of one device. Its verbs are methods; ``do`` takes any by name.

    Raises:
        CommandError: the bench refused.
        ClientError: nobody answered.
    """

    def __init__(self, link: Link, name: str) -> None:
        self.name = name
        self._link = link

    def do(self, /, verb: str, *, wait: bool = False, timeout_s: float = MOTION_S, **given: object) -> Ack:
        return self._link.do(self.name, verb, given, wait, timeout_s)

    def put(self, verb: str, **given: object) -> None:
        """Carry out a verb without an answer: for set-points in a stream."""
        self._link.put(f"axis/{self.name}/cmd/{verb}", given)

    def state(self) -> State:
        """The present state, at most 20 ms old."""
        return state_of(self._link.ask(f"axis/{self.name}/state")[0])

    def states(self) -> Iterator[State]:
        """Iterate over states as they come, until the iterator is closed."""
        with self.subscribe() as subscriber:
            while True:
                yield state_of(subscriber.recv().payload.to_bytes())

    def subscribe(self, call: Callable[[bytes], object] | None = None) -> Any:
        """Subscribe to the axis's states, as ``Link.subscribe``."""
        return self._link.subscribe(f"axis/{self.name}/state", call)

    def parameter(self, name: str) -> float:
        """Value of a settable field."""
        return float(self._link.read(f"axis/{self.name}/param/{name}")[name])

    def set_parameter(self, name: str, value: float) -> Ack:
        """Set a settable field."""
        return ack_of(self._link.ask(f"axis/{self.name}/param/{name}", value)[0])

    def fault(self, /, fault: str, **parameters: object) -> int:
        """Begin a fault; answers its number."""
        answer = self._link.ask(f"axis/{self.name}/fault", {"fault": fault, **parameters})
        return int(ack_of(answer[0]).answer["number"])

    def clear_fault(self, number: int | str = "all") -> None:
        """End a fault, or all."""
        self._link.ask(f"axis/{self.name}/fault", {"clear": number})


class Bench:
    """Bench that was connected to; ``connect_sync`` makes it."""

    def __init__(self, link: Link) -> None:
        self.name = link.bench
        self.link = link

    def axis(self, name: str) -> Axis:
        """Axis of a device."""
        return Axis(self.link, name)

    def submit(self, run: Mapping[str, object] | str) -> dict[str, Any]:
        """Submit a multi-axis run, as data or as YAML; answers its progress.

        Raises:
            CommandError: with all problems, if it cannot be done.
        """
        text = run if isinstance(run, str) else json.dumps(run)
        return read(self.link.ask_text("run/submit", text)[0])

    def run_state(self, name: str) -> dict[str, Any]:
        """Progress of a run."""
        return self.link.read(f"run/{name}/state")

    def cancel(self, name: str, how: Literal["grace", "prejudice"] = "grace") -> dict[str, Any]:
        """End a run."""
        return read(self.link.ask(f"run/{name}/cancel", {"how": how})[0])

    def perform(
        self, run: Mapping[str, object] | str, *, timeout_s: float = MOTION_S, poll_s: float = 0.05
    ) -> dict[str, Any]:
        """Submit a run and wait for its end; answers its progress. Raises ClientError: it does not end."""
        progress = self.submit(run)
        deadline_s = time.monotonic() + timeout_s
        while progress["state"] in ("queued", "running"):
            if time.monotonic() > deadline_s:
                raise ClientError(
                    f"run {progress['run']} was still {progress['state']} after {timeout_s:g} s"
                )
            time.sleep(poll_s)
            progress = self.run_state(progress["run"])
        return progress

    def leased(self) -> dict[str, Any] | None:
        """Lease of the bench: ``user``, ``until_wall_ns``, ``why``, ``doors``; None: nobody has it."""
        lease: dict[str, Any] | None = self.link.read("lease")["lease"]
        return lease

    def lease(self, why: str, *, for_s: float, doors: Sequence[str] = ()) -> dict[str, Any]:
        """Take a lease: until it ends others may look and not command. ``doors``: those without users that
        stay open.

        Raises:
            CommandError: somebody has it, or the bench does not know who asks.
        """
        return self._lease("take", why=why, for_s=for_s, doors=list(doors))

    def renew_lease(self, *, for_s: float) -> dict[str, Any]:
        """Let the own lease end so long from now."""
        return self._lease("renew", for_s=for_s)

    def give_lease(self) -> None:
        """Give the own lease back."""
        self._lease("give")

    def break_lease(self) -> None:
        """End a lease of somebody else; the bench's log says who did."""
        self._lease("break")

    def _lease(self, do: str, **given: object) -> dict[str, Any]:
        answer: dict[str, Any] = read(self.link.ask(f"lease/{do}", given)[0])["lease"]
        return answer

    def alive(self) -> list[str]:
        """Names of what is alive: ``daemon``, ``axis/m1``, ``segment/bus0``."""
        return self.link.alive()

    def clock(self) -> tuple[int, int]:
        """Simulated and wall time, ns."""
        clock = self.link.read("sim/clock")
        return int(clock["sim_ns"]), int(clock["wall_ns"])

    def read(self, key: str) -> dict[str, Any]:
        """Read the document under a key of the bench, as in ``sim/health`` or ``segment/bus0/stats``."""
        return self.link.read(key)

    def close(self) -> None:
        self.link.close()

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def connect_sync(
    bench: str,
    endpoint: str = ENDPOINT,
    *,
    user: str | None = None,
    password: str = "",
    config: Path | str | None = None,
    timeout_s: float = TIMEOUT_S,
) -> Bench:
    """Connect to a bench at a zenoh endpoint; where it has users, as one of them. ``config``: the file of a
    user that `hil zenoh site` or `hil zenoh keys` made, which says all that, instead.

    Raises:
        ClientError: nobody lets us in there.
    """
    credentials = Credentials(user, password) if user is not None else None
    return Bench(Link(bench, endpoint, credentials, None if config is None else Path(config), timeout_s))
