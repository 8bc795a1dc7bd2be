from collections.abc import Sequence

class BitWire:
    """Wire with up to 256 CAN controllers, bit by bit at one rate, in bits per second. Time goes on by
    ``advance`` and ``run`` only, and nothing depends on how it is cut.

    A controller has a number, from 0. It drives a level, reads the wire's in each bit, and follows the CAN
    Specification 2.0. Those that have the rate of the wire are in step, without delay. One with a rate of its
    own begins a bit at each edge to dominant, and reads in the bit's middle. ``leaps``: a frame that nothing
    disturbs is passed at once, with the same result. ``other``: the wire whose frames it shares.
    """

    def __init__(self, rate: int, other: BitWire | None = None, leaps: bool = True) -> None: ...
    leaps: bool
    @property
    def is_asleep(self) -> bool:
        """True if nothing will happen until somebody does something; time then stands still."""

    @property
    def is_held(self) -> bool:
        """True if it is asleep and dominant."""

    @property
    def busy_bits(self) -> int:
        """Bits in which the wire was not free: frames, error and overload frames, three bits behind each."""

    @property
    def decided_ns(self) -> int:
        """Start of the last bit in which somebody could begin to send: what is loaded later waits."""

    @property
    def sender(self) -> int:
        """The controller that has sent, if this and that others have heard it is all that happened in the
        last bit; else -1."""

    def add(self, index: int, is_listening: bool, recovers: bool) -> None:
        """Add a controller, which waits for 11 recessive bits. ``is_listening``: it never drives.
        ``recovers``: it comes back from bus-off."""

    def remove(self, index: int) -> None: ...
    def take_over(self, other: BitWire, index: int, with_time: bool) -> None:
        """Take a controller over: in the middle of whatever it does, with the other wire's time; or to wait
        until this wire has been recessive for 11 bits."""

    def load(self, index: int, bits: bytes, key: int) -> int:
        """Set what a controller sends next, until it is sent; answers its place, 0 or 1."""

    def unload(self, index: int) -> None: ...
    def set_listening(self, index: int, is_listening: bool) -> None: ...
    def set_recovery(self, index: int, recovers: bool) -> None: ...
    def set_stuck(self, index: int, is_stuck: bool) -> None: ...
    def set_no_ack(self, index: int, limit: int, seed: int) -> None:
        """Set how many of 2**64 draws let a frame go unacknowledged."""

    def set_rate(self, index: int, rate: int) -> None:
        """Give a controller a clock of its own, in bits per second; 0: the wire's."""

    def set_noise(self, pairs: Sequence[tuple[int, int]]) -> None:
        """Set all noises: how many of 2**64 draws invert a bit, and the state to draw from.

        Raises:
            ValueError: more than 16.
        """

    def noise_states(self) -> list[int]: ...
    def force_bus_off(self, index: int) -> None: ...
    def look(self, index: int) -> tuple[int, int, int, int]:
        """State, transmit and receive error counter, and how often it has lost the arbitration."""

    def sent_slot(self, index: int) -> int: ...
    def is_sending(self, index: int) -> bool: ...
    @property
    def now_ns(self) -> int:
        """Time at which the next bit begins."""

    def wake(self, now_ns: int) -> None:
        """Let the next bit begin now, if the wire sleeps or everybody only waits. To be called before any
        change."""

    def copy(self, other: BitWire) -> None:
        """Become what another wire is."""

    def advance(self, until_ns: int) -> None:
        """Go on to the end of the last bit that ends by then, or to where it sleeps."""

    def run(self) -> int:
        """Go on to the end of the bit in which something happens, by 2000 bits at most; answers that time, or
        -1 if it falls asleep before."""

    def has_heard(self, index: int) -> bool: ...
    def started_ns(self, index: int) -> int: ...
    def events(self) -> list[tuple[int, int, int]]:
        """All that happened in the last bit: controller; 1 sent, 2 heard, 4 error, 8 other state, or several;
        the error: 1 bit, 2 stuff, 3 CRC, 4 form, 5 acknowledgement."""

    def heard(self, index: int) -> tuple[int, bytes, bool, bool, int]:
        """Fields of the frame that a controller has heard, as of ``CanFrame``."""
