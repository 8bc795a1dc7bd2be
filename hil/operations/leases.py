"""The lease of a bench: who may command it now, and who is refused."""

import json
import logging
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from hil.host.new_file import write_file
from hil.live.places import Places
from hil.operations.event_log import EventLog
from hil.operations.table import Asked
from hil.vocab.desk_protocol import Source
from hil.vocab.lease import DOORS, LONGEST_S, Lease, time_said
from hil.vocab.near_words import meant
from hil.vocab.verbs import Role, VerbRefused
from hil.wire.json_text import JsonError, read_json

FILE = "lease.json"
"""Name of its file in the bench's state folder."""
_FILE_BYTES = 4096
_LATEST_NS = 1 << 62
"""The year 2116."""
_NOT_REFUSED = frozenset(
    {
        "halt",
        "stop_site",
        "stop",
        "cancel_run",
        "attach",
        "detach",
        "take_lease",
        "renew_lease",
        "give_lease",
        "break_lease",
    }
)
"""Operations that are no readings and that a lease does not refuse: what stops, what only puts a listener on
a bus, and what is about leases. ``docs/decisions/0088-a-lease-closes-doors.md``."""
_PART_OF_START = frozenset({"look", "join"})
"""Questions of the leader of a run before the run begins; one that has begun goes on."""
_NS = 1_000_000_000

log = logging.getLogger("hil")


class Leases:
    """Lease of one bench. ``file``: where it is kept over a restart, None: nowhere; ``wall_ns``: the wall's
    time since 1970. ``look`` has to be called now and then: it notes the lease's end, and what ports did not
    deliver."""

    def __init__(
        self, file: Path | None, places: Places, events: EventLog, wall_ns: Callable[[], int]
    ) -> None:
        self._file, self._places, self._events, self._wall_ns = file, places, events, wall_ns
        self._lease: Lease | None = None
        self._told: dict[str, int] = {}
        """Bytes of clients that were not delivered, by place, as far as they were told."""
        if file and (kept := _read(file)):
            self._lease = kept
            self._shut()
            self.current()

    # ---- who may ----

    def current(self) -> Lease | None:
        """Lease that holds now. Notes the end of one that is over."""
        if (lease := self._lease) and lease.until_wall_ns <= self._wall_ns():
            self._end(lease, "bench", f"lease of {lease.user} ended: {lease.why}")
        return self._lease

    def check(self, source: Source, operation: str, given: Mapping[str, Any]) -> None:
        """Refuse an asker while somebody else has the bench.

        Raises:
            VerbRefused: it is leased.
        """
        if self._lease is None or operation in _NOT_REFUSED:
            return
        if operation == "run" and given.get("check"):
            return
        if operation == "part" and dict(given.get("given", {})).get("do") not in _PART_OF_START:
            return
        lease = self.current()
        if lease is None or source.person == lease.user or source.door in lease.doors:
            return
        raise VerbRefused("leased", self._said(lease))

    def _said(self, lease: Lease) -> str:
        left_s = (lease.until_wall_ns - self._wall_ns()) / _NS
        until = time.strftime("%Y-%m-%d %H:%M UTC", time.gmtime(lease.until_wall_ns / _NS))
        return f"{lease.user} has this bench until {until}, {time_said(left_s)} more: {lease.why}"

    # ---- operations ----

    def told(self, asked: Asked | None = None) -> dict[str, Any]:
        """Answer of the operation ``lease``."""
        if (lease := self.current()) is None:
            return {"lease": None}
        counts = {label: n for label, link in self._places.items() if (n := link.undelivered_bytes)}
        row = vars(lease) | {"doors": list(lease.doors), "closed": list(lease.closed)}
        left_s = (lease.until_wall_ns - self._wall_ns()) / _NS
        return {"lease": row | {"left_s": round(left_s, 3), "undelivered": counts}}

    def begin(
        self,
        asked: Asked,
        why: str,
        doors: Sequence[str] = (),
        for_s: float | None = None,
        until_wall_ns: int | None = None,
    ) -> dict[str, Any]:
        """Take a lease, for so long or until then."""
        user = _named(asked.source)
        if lease := self.current():
            whose = "you have it already: `hil lease renew`; " if lease.user == user else ""
            raise VerbRefused("leased", whose + self._said(lease))
        if not why.strip() or not why.isprintable():
            raise VerbRefused(
                "bad_parameter",
                "why: this is no line of text; write in a line what the bench is for, for the others",
            )
        for door in doors:
            if door not in DOORS:
                raise VerbRefused("bad_parameter", f"doors: there is no {door[:80]!r}; {meant(door, DOORS)}")
        until_ns, now_ns = self._until_ns(for_s, until_wall_ns), self._wall_ns()
        lease = Lease(user, why.strip(), tuple(dict.fromkeys(doors)), now_ns, until_ns)
        self._keep(lease)
        self._lease = lease
        self._shut()
        self._tell(user, f"lease taken: {self._said(lease)}")
        return self.told()

    def renew(
        self, asked: Asked, for_s: float | None = None, until_wall_ns: int | None = None
    ) -> dict[str, Any]:
        """Let the asker's lease end at another time, counted from now."""
        lease = self._own(asked.source, "renew")
        until_ns = self._until_ns(for_s, until_wall_ns)
        lease = Lease(lease.user, lease.why, lease.doors, lease.since_wall_ns, until_ns)
        self._keep(lease)
        self._lease = lease
        self._tell(lease.user, f"lease renewed: {self._said(lease)}")
        return self.told()

    def give(self, asked: Asked) -> dict[str, Any]:
        """End the asker's own lease."""
        lease = self._own(asked.source, "give back")
        self._end(lease, lease.user, f"lease of {lease.user} given back: {lease.why}")
        return self.told()

    def end_anothers(self, asked: Asked) -> dict[str, Any]:
        """End a lease of somebody else, and say so to all."""
        if (lease := self.current()) is None:
            raise VerbRefused("not_now", "nobody has a lease of this bench; `hil lease take` takes one")
        who = asked.source.person or asked.source.name
        self._end(lease, who, f"{who} broke the lease of {lease.user}: {lease.why}", is_loud=True)
        return self.told()

    def _own(self, source: Source, what: str) -> Lease:
        if (lease := self.current()) is None:
            raise VerbRefused(
                "not_now", f"there is no lease to {what}; it may have ended; `hil lease take` takes one"
            )
        if lease.user != source.person:
            raise VerbRefused("leased", f"this is no lease of yours to {what}: {self._said(lease)}")
        return lease

    def _until_ns(self, for_s: float | None, until_wall_ns: int | None) -> int:
        """Wall time of the end. Raises VerbRefused: it is not given once, or past, or too far away."""
        if (for_s is None) == (until_wall_ns is None):
            raise VerbRefused("bad_parameter", "give either for_s or until_wall_ns")
        now_ns = self._wall_ns()
        until_ns = until_wall_ns if until_wall_ns is not None else now_ns + round((for_s or 0) * _NS)
        if until_ns <= now_ns:
            now = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(now_ns / _NS))
            raise VerbRefused("bad_parameter", f"the lease's end is past: this bench's clock says {now}")
        if until_ns - now_ns > LONGEST_S * _NS:
            raise VerbRefused("bad_parameter", f"a lease ends within {time_said(LONGEST_S)}; renew it then")
        return until_ns

    # ---- its time ----

    def look(self) -> None:
        """Note the end of a lease that is over, and bytes of clients that were not delivered since."""
        if (lease := self.current()) is None:
            return
        for label, link in list(self._places.items()):
            count = link.undelivered_bytes
            if more := count - self._told.get(label, 0):
                if label not in self._told:
                    log.warning("%s: bytes of a client are not delivered: %s", label, self._said(lease))
                self._told[label] = count
                text = f"{more} bytes not delivered: {lease.user} has the bench"
                self._events.put("refusals", label, label, text, common="leased")

    def _end(self, lease: Lease, who: str, text: str, *, is_loud: bool = False) -> None:
        self._say_undelivered()
        self._lease = None
        self._told.clear()
        self._shut()
        self._keep(None)
        self._tell(who, text, is_loud=is_loud)

    def _tell(self, who: str, text: str, *, is_loud: bool = False) -> None:
        (log.warning if is_loud else log.info)("%s", text)
        self._events.put("clients", "", who, text)

    def _say_undelivered(self) -> None:
        """Say how much was not delivered, at the end of a lease."""
        if counts := {label: n for label, link in self._places.items() if (n := link.undelivered_bytes)}:
            said = ", ".join(f"{label} {count}" for label, count in counts.items())
            log.warning("lease: bytes of clients that were not delivered: %s", said)

    def _shut(self) -> None:
        """Shut ports, or open them, as the lease has it."""
        self._places.shut(self._lease is not None and "ports" not in self._lease.doors)

    def _keep(self, lease: Lease | None) -> None:
        """Keep a lease for the next start. One that cannot be kept holds until the bench ends."""
        if self._file is None:
            return
        try:
            if lease is None:
                self._file.unlink(missing_ok=True)
            else:
                write_file(self._file, json.dumps(vars(lease)).encode() + b"\n")
        except OSError as error:
            log.warning("lease: %s: %s; a restart of the bench forgets it", self._file, error.strerror)


def _named(source: Source) -> str:
    """Name of the asker. Raises VerbRefused: nobody knows who asks, or he may only look."""
    if source.role < Role.OPERATOR:
        raise VerbRefused("forbidden", "a lease needs the role operator")
    if not source.person:
        raise VerbRefused(
            "forbidden",
            f"a lease needs a name, and the door {source.door} knows none: log in as a user, or ask on the"
            " bench's own computer with `hil lease take`",
        )
    return source.person


def _read(file: Path) -> Lease | None:
    """Read the lease that was kept, if there is one that can be read."""
    try:
        text = file.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        log.warning("lease: %s cannot be read: %s; nobody has the bench", file, error.strerror)
        return None
    try:
        match read_json(text[:_FILE_BYTES]):
            case {
                "user": str(user),
                "why": str(why),
                "doors": list(doors),
                "since_wall_ns": int(since_ns),
                "until_wall_ns": int(until_ns),
            } if user and set(map(str, doors)) <= DOORS.keys() and 0 <= until_ns < _LATEST_NS:
                return Lease(user, why, tuple(doors), since_ns, until_ns)
    except JsonError:
        pass
    log.warning("lease: %s is no lease; nobody has the bench", file)
    return None
