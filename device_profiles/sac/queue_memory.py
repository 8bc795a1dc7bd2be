"""Queue and xRef array of the SAC from the terminal's side: listed, edited, cleared, undone.

The engine holds and runs both; here is what may be written into them, and where the next command goes.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace

from device_profiles.sac import screens
from device_profiles.sac.session import Session
from device_profiles.sac.typed_text import Text, read_attributes
from hil.vocab.motion import QUEUE_LEN, Motion, MotionEntry

POSITIONS = range(1, QUEUE_LEN + 1)


class QueueMemory:
    """Queue of one power-up; ``$R`` leaves it alone."""

    def __init__(self, motion: Motion, session: Session) -> None:
        self._motion = motion
        self._session = session
        self._next_position = 1
        self._undo: dict[int, MotionEntry] = {}

    def add(self, entry: MotionEntry) -> bool:
        """Store a command at the next position and let it wait for its turn.

        Answers False when 30 wait already: it is dropped (decision).
        """
        if self._motion.get("pending") >= QUEUE_LEN:
            return False
        position = self._next_position
        self._write({position: entry})
        self._next_position = position % QUEUE_LEN + 1
        self._motion.enqueue(position)
        return True

    def lines(self) -> Iterable[str]:
        """Lines of the listing; in debug the continuous command's entry comes first."""
        shown = range(0 if self._session.is_debug else 1, QUEUE_LEN + 1)
        running = int(self._motion.get("queue_position"))
        at = running if running in POSITIONS else self._next_position
        return screens.queue({position: self._motion.entry(position) for position in shown}, at)

    def edit(self, text: Text) -> None:
        """Edit an entry by ``nn`` and attributes, without a motion. A wrong position: nothing."""
        position = text.number()
        if position is None or position not in POSITIONS:
            return
        parameters = self._session.parameters
        said = read_attributes(text, parameters.steps_per_rev, with_steps=True)
        self._write({position: said.apply(self._motion.entry(position), parameters.ramp)})

    def entries(self) -> list[MotionEntry]:
        return [self._motion.entry(position) for position in POSITIONS]

    def restore(self, saved: list[MotionEntry] | None) -> None:
        """Restore the saved entries, or the system's defaults if there are none (decision)."""
        seeds = saved or [self._session.parameters.default_entry()] * QUEUE_LEN
        self._write(dict(zip(POSITIONS, seeds, strict=True)))

    def seed(self, saved: list[MotionEntry] | None) -> None:
        """Restore at a cold start: there is nothing to undo."""
        self.restore(saved)
        self._undo = {}

    def clear(self) -> None:
        """Clear to the session's defaults; steps and direction as the seeds have them (decision)."""
        seed = self._session.parameters.default_entry()
        entry = replace(self._session.default, steps=seed.steps, is_ccw=seed.is_ccw, extra_pulses=0)
        self._write(dict.fromkeys(POSITIONS, entry))

    def undo(self) -> None:
        """Take the last change of the queue back; once more: make it again (decision)."""
        if self._undo:
            self._write(self._undo)

    def _write(self, entries: Mapping[int, MotionEntry]) -> None:
        self._undo = {position: self._motion.entry(position) for position in entries}
        for position, entry in entries.items():
            self._motion.write_entry(position, entry)

    def edit_xref(self, text: Text) -> bool:
        """Edit the xRef array by ``nn,xx``: entry nn is queue position xx; answers whether it was one.

        Decision: the array has entries 0 to 30, and 30 always ends it.
        """
        index = text.number()
        has_comma = text.takes(",")
        position = text.number()
        if index is None or position is None or not has_comma or max(index, position) > QUEUE_LEN:
            return False
        self._motion.write_xref(index, 0 if index == QUEUE_LEN else position)
        return True

    def xref_lines(self) -> Iterable[str]:
        return screens.xref(self._motion.xref())
