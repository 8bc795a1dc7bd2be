"""Verbs of a SAC: its own commands, with angles in degrees."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import wraps

from device_profiles.sac.firmware import Sac
from device_profiles.sac.queue_memory import POSITIONS
from device_profiles.sac.typed_text import Text, from_rpm
from hil.vocab.motion import CONTINUOUS_SLOT
from hil.vocab.parameters import Parameter
from hil.vocab.verbs import HOW_TO_STOP, Effect, Verb, VerbRefused

Answer = Mapping[str, float | str | int]
_ANGLE_DEG = 1e6
_STANDBY = 0
_SPEED = Parameter(
    "velocity_rpm",
    "speed on the way; left out: the session's",
    "rpm",
    1,
    2000,
    is_whole=True,
    is_optional=True,
)
_ENTRY_SPEED = replace(_SPEED, about="speed on the way; left out: the entry keeps its own")
_RAMPS = (
    Parameter("acceleration", "as after an a: 1 slow to 998 fast, 0 none", "", 0, 998, is_optional=True),
    Parameter("deceleration", "as after a d", "", 0, 998, is_optional=True),
)
_POSITION = Parameter("position", "of the queue", "", min(POSITIONS), max(POSITIONS), is_whole=True)


def _attributes(velocity_rpm: float | None = None, **ramps: float) -> str:
    """Text to type for ``_SPEED`` and ``_RAMPS``, of which any may be left out."""
    said = "" if velocity_rpm is None else f"v{int(velocity_rpm)}"
    return said + "".join(f"{name[0]}{ramps[name]:.2f}" for name in sorted(ramps))


def one_shot(pulses: int, said: str) -> str:
    """Text after ``xm``: that many pulses, and nothing that the session's defaults would add."""
    return f"{'-' if pulses < 0 else ''}{abs(pulses)}{said}u0p"


def velocity(sac: Sac, velocity_rpm: float) -> None:
    """Turn continuously; in the same direction the speed changes, else the motion begins again."""
    motion, rpm = sac.motion, abs(int(velocity_rpm))
    if rpm == 0:
        sac.moves.stop_gracefully()
        return
    is_ccw = velocity_rpm < 0
    entry = motion.entry(CONTINUOUS_SLOT)
    runs = motion.get("motion_state") != _STANDBY and motion.get("queue_position") == CONTINUOUS_SLOT
    # Another speed would not keep a stopping axis from stopping.
    if runs and not motion.get("is_ending") and entry.is_ccw == is_ccw:
        target = from_rpm(rpm, sac.parameters.steps_per_rev)
        # The entry too: it may be waiting to take the place of what runs in the other direction.
        motion.write_entry(CONTINUOUS_SLOT, replace(entry, rpm=target.rpm, cycle_us=target.cycle_us))
        motion.retarget(target.rpm, target.cycle_us)
        return
    sac.moves.one_shot(Text(f"{'-' if is_ccw else ''}0v{rpm}"))  # without the 0 the default's direction


def move_rel(sac: Sac, angle_deg: float, **how: float) -> Answer:
    """Move as by ``xm``: at once, and nothing is kept. Whole pulses. Answers ``set_point`` as well where it
    is known: while it moves, nobody knows where from."""
    motion = sac.motion
    stands = not (motion.get("motion_state") or motion.get("pending") or motion.get("queue_position") >= 0)
    begins_deg = motion.get("commanded_deg")
    setup = sac.parameters.setup()
    per_rev = setup.steps_per_rev << setup.microstep_exponent
    pulses = round(angle_deg / 360 * per_rev)
    if pulses:
        sac.moves.one_shot(Text(one_shot(pulses, _attributes(**how))))
    angle = pulses * 360 / per_rev
    where = {"set_point": begins_deg + angle} if stands else {}
    return {"pulses": pulses, "angle_deg": angle, **where}


def move_abs(sac: Sac, position_deg: float, **how: float) -> Answer:
    if sac.motion.get("motion_state") != _STANDBY or sac.motion.get("queue_position") >= 0:
        raise VerbRefused("not_now", "it moves, and where it will be is not known; stop it first")
    return move_rel(sac, position_deg - sac.motion.get("commanded_deg"), **how)


def queue(sac: Sac, position: float, steps: float, sync: float = 0, **how: float) -> None:
    sac.queue.edit(Text(f"{int(position)}m{int(steps)}{_attributes(**how)}s{int(sync)}f"))


def recall(sac: Sac, position: float) -> None:
    sac.moves.recall(Text(f"{int(position)}"))


def loop(sac: Sac, first: float, last: float, passes: float) -> None:
    if last < first:
        raise VerbRefused("bad_parameter", f"last: {last:g} comes before first, {first:g}")
    for said in (f"n{int(passes)}", f"s{int(first)}", f"f{int(last)}"):
        sac.moves.loop(Text(said))


def sync(sac: Sac) -> None:
    sac.motion.release_sync()


def pulse(sac: Sac, direction: str) -> None:
    sac.motion.pulse(direction == "ccw")


def stop(sac: Sac, how: str) -> None:
    """Stop. ``grace``: with the session's deceleration."""
    if how == "grace":
        sac.moves.stop_gracefully()
    else:
        sac.motion.stop(None)


def starve(sac: Sac, policy: str, acceleration_rpm_per_s: float) -> None:
    """Stop, as no set-point came for the time-out. A SAC has its own ramps, and holds after each stop."""
    stop(sac, "grace" if policy == "decelerate" else "prejudice")


def _started(run: Callable[..., Answer | None]) -> Callable[..., Answer | None]:
    """Refuse a verb during the cold start, whose end would undo it."""

    @wraps(run)
    def checked(sac: Sac, **parameters: float | str) -> Answer | None:
        if not sac.is_started:
            raise VerbRefused("not_now", "it is starting: wait for its prompt")
        return run(sac, **parameters)

    return checked


_VERBS = (
    Verb(
        "velocity",
        "continuous motion at a speed, clockwise if positive; 0: a controlled stop",
        (Parameter("velocity_rpm", "the speed", "rpm", -2000, 2000, is_whole=True),),
        velocity,
        Effect.STREAM,
    ),
    Verb(
        "move_rel",
        "go by an angle, clockwise if positive, at once; in whole pulses",
        (Parameter("angle_deg", "how far", "deg", -_ANGLE_DEG, _ANGLE_DEG), _SPEED, *_RAMPS),
        move_rel,
        Effect.ENDS,
    ),
    Verb(
        "move_abs",
        "go to an angle, counted from that at power-up or from `hil zero`; in whole pulses",
        (Parameter("position_deg", "where to", "deg", -_ANGLE_DEG, _ANGLE_DEG), _SPEED, *_RAMPS),
        move_abs,
        Effect.ENDS,
    ),
    Verb(
        "queue",
        "write an entry of the queue",
        (
            _POSITION,
            Parameter("steps", "full steps, clockwise if positive", "", -(2**31), 2**31 - 1, is_whole=True),
            _ENTRY_SPEED,
            *_RAMPS,
            Parameter("sync", "1: it waits for the sync", default=0, is_whole=True),
        ),
        queue,
    ),
    Verb("run", "run an entry of the queue at once", (_POSITION,), recall, Effect.ENDS),
    Verb(
        "loop",
        "run entries of the queue in a loop",
        (
            replace(_POSITION, name="first", about="entry"),
            replace(_POSITION, name="last", about="entry"),
            Parameter("passes", "0: forever", "", 0, 65535, 1, is_whole=True),
        ),
        loop,
        Effect.ENDS,
    ),
    Verb("sync", "release what waits for the sync", run=sync),
    Verb(
        "pulse",
        "a single pulse, while it stands",
        (Parameter("direction", "which way round", choices=("cw", "ccw"), default="cw"),),
        pulse,
    ),
    Verb(
        "stop",
        "end all motion: with the session's deceleration, or at once",
        (HOW_TO_STOP,),
        stop,
        Effect.ENDS,
    ),
)
VERBS = tuple(replace(verb, run=_started(verb.run)) for verb in _VERBS if verb.run)
