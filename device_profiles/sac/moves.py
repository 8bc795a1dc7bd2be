"""Commands of the SAC that move the motor or set its next motion: a line in, calls of the engine out."""

from dataclasses import replace
from functools import lru_cache

from device_profiles.sac.queue_memory import POSITIONS, QueueMemory
from device_profiles.sac.session import Session
from device_profiles.sac.typed_text import Attributes, Text, Velocity, from_cycle, read_attributes, read_steps
from hil.vocab.motion import CONTINUOUS_SLOT, ONE_SHOT_SLOT, QUEUE_LEN, Motion, MotionEntry

PASSES = 1 << 16
"""Number of values of a loop counter, 16 bits (manual, loop)."""


class Moves:
    """Commands of motion. Each method gets what follows its letter."""

    def __init__(self, motion: Motion, session: Session, queue: QueueMemory) -> None:
        self._motion = motion
        self._session = session
        self._queue = queue

    # ---- motion commands ----

    def queued(self, text: Text) -> None:
        """Queue a motion (``m``) at the next position; without steps continuous."""
        entry = self._entry(text)
        if entry.steps == 0:
            self._continuous(entry)
        elif self._queue.add(entry):
            self._session.keep(entry)

    def one_shot(self, text: Text) -> None:
        """Move at once (``xm``); nothing is kept."""
        entry = self._entry(text)
        if entry.steps == 0:
            self._continuous(entry)
            return
        self._motion.write_entry(ONE_SHOT_SLOT, entry)
        self._motion.run_once(ONE_SHOT_SLOT)

    def recall(self, text: Text) -> None:
        """Run an entry of the queue at once (``xnn``); 0 and 31 up are ignored."""
        position = text.number()
        if position is not None and position in POSITIONS:
            self._motion.run_once(position)

    def _continuous(self, entry: MotionEntry) -> None:
        self._motion.write_entry(CONTINUOUS_SLOT, entry)
        self._motion.run_continuous()

    def _entry(self, text: Text) -> MotionEntry:
        said = Attributes()
        read_steps(text, said)
        attributes = read_attributes(text, self._session.parameters.steps_per_rev)
        return self._session.command(replace(attributes, steps=said.steps or 0, is_ccw=said.is_ccw))

    # ---- unary commands ----

    def acceleration(self, text: Text) -> None:
        self._session.say(Attributes(acc=text.acceleration()))

    def deceleration(self, text: Text) -> None:
        self._session.say(Attributes(dec=text.acceleration()))

    def velocity(self, said: str) -> None:
        """Set the velocity (``v``), by default the system's; a continuous motion follows at once."""
        parameters = self._session.parameters
        if said:
            velocity = _velocity(said, parameters.steps_per_rev)
        else:
            velocity = from_cycle(parameters.cycle_us, parameters.steps_per_rev)
        if velocity:
            self._session.say_velocity(velocity)
            self._motion.retarget(velocity.rpm, velocity.cycle_us)

    # ---- what ends ----

    def stop_gracefully(self) -> None:
        """Stop with the session's deceleration (``s``)."""
        self._motion.stop(self._session.default.dec_hundredths)

    # ---- loops ----

    def loop(self, text: Text) -> None:
        """Execute ``l``: alone it ends what runs in a controlled way, loop or motion (decision)."""
        if not text.peek():
            self._motion.finish()
        elif text.is_digit():
            self.loop_array(text)
        elif text.takes("aA"):
            self._motion.loop_start(1)
            self._motion.loop_finish(QUEUE_LEN)
        elif text.takes("nN"):
            self._motion.loop_passes((text.number() or 0) % PASSES)
        elif text.takes("sS"):
            if (position := text.number()) is not None and position in POSITIONS:
                self._motion.loop_start(position)
        elif text.takes("fF") and (position := text.number()) is not None and position in POSITIONS:
            self._motion.loop_finish(position)

    def loop_array(self, text: Text) -> None:
        """Run the xRef array so many times; 0, and no number: forever."""
        self._motion.loop_array((text.number() or 0) % PASSES)


@lru_cache(maxsize=4)
def _velocity(text: str, steps_per_rev: int) -> Velocity | None:
    """Velocity that a unary ``v`` sets; cached, because a packet to all has every node read the same."""
    return read_attributes(Text("v" + text), steps_per_rev).velocity
