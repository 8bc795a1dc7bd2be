"""Homes a slide that a SAC moves, and moves it to places: pyserial, and nothing of hil.

    python home.py PORT [STEPS ...]

The switch at the slide's end pulls Estop low. Homing turns the motor towards it until it stands, then leaves
the switch by some steps: there is 0. Exits with 1 if the SAC is silent, the switch does not come, or a move
takes longer than it may.
"""

import argparse
import queue
import signal
import sys
import threading
import time

import serial

BAUD = 38_400
PROMPT = b"SAC>"
STEPS_PER_TURN = 200
HOMING_RPM, MOVING_RPM = 30, 120
LEAVE_STEPS = 100
LOOK_S = 0.05


class SlideError(Exception):
    """Something that somebody at the slide has to see to."""


class Sac:
    """SAC at a serial port. A thread of its own reads, so that nothing that it says is lost."""

    def __init__(self, port: str) -> None:
        self.port = serial.Serial(port, BAUD, timeout=0.1)
        self.answers: queue.Queue[str] = queue.Queue()
        self.is_open = True
        self.reader = threading.Thread(target=self._read, name="reader", daemon=True)
        self.reader.start()

    def _read(self) -> None:
        heard = b""
        try:
            while self.is_open:
                heard += self.port.read(self.port.in_waiting or 1)
                *answers, heard = heard.split(PROMPT)
                for answer in answers:
                    self.answers.put(answer.decode(errors="replace"))
        except (serial.SerialException, OSError) as error:
            if self.is_open:
                self.answers.put(f"lost: {error}")

    def ask(self, command: str, within_s: float = 1.0) -> str:
        """Send a command; what stands between its echo and the next prompt."""
        while not self.answers.empty():
            self.answers.get()
        self.port.write(command.encode() + b"\r")
        try:
            answer = self.answers.get(timeout=within_s)
        except queue.Empty:
            raise SlideError(f"no answer to {command!r} within {within_s:g} s") from None
        if answer.startswith("lost: "):
            raise SlideError(answer)
        return answer.removeprefix(command).strip()

    def wake(self) -> None:
        """Wait for its prompt: after power-up it takes a second."""
        for _ in range(5):
            try:
                self.ask("", within_s=0.5)
                return
            except SlideError:
                continue
        raise SlideError("nobody answers there")

    @property
    def rpm(self) -> int:
        """Speed of now; 0: it stands."""
        said = self.ask("vd").split("\t")[0]
        if not said.isdecimal():
            raise SlideError(f"this is no speed: {said!r}")
        return int(said)

    def close(self) -> None:
        """Whatever has happened, leave a motor that stands."""
        self.port.write(b"S\r")
        self.is_open = False
        self.reader.join()
        self.port.close()


class Slide:
    """Slide that a SAC moves; its place is counted in steps from home."""

    def __init__(self, sac: Sac) -> None:
        self.sac = sac
        self.steps = 0
        self.stopped = threading.Event()

    def home(self, within_s: float) -> None:
        """Go to the switch, and leave it."""
        self._go(f"m-v{HOMING_RPM}")
        self._stand(within_s, "the switch did not come")
        self._go(f"m{LEAVE_STEPS}v{HOMING_RPM}")
        self._stand(self._duration_s(LEAVE_STEPS, HOMING_RPM), "the switch was not left")
        self.steps = 0

    def move(self, to_steps: int) -> None:
        """Go to a place, in time."""
        way = to_steps - self.steps
        if way:
            self._go(f"m{way}v{MOVING_RPM}")
            self._stand(self._duration_s(abs(way), MOVING_RPM), f"{to_steps} was not reached")
        self.steps = to_steps

    def _duration_s(self, steps: int, rpm: int) -> float:
        return 1.0 + 1.5 * steps / STEPS_PER_TURN / rpm * 60

    def _go(self, command: str) -> None:
        self.sac.ask(command)
        self.stopped.clear()
        self.watcher = threading.Thread(target=self._watch, name="watcher", daemon=True)
        self.watcher.start()

    def _watch(self) -> None:
        """Look at the speed until the motor stands."""
        self.trouble = ""
        try:
            time.sleep(LOOK_S)
            while self.sac.is_open and self.sac.rpm:
                time.sleep(LOOK_S)
        except SlideError as error:
            self.trouble = str(error)
        self.stopped.set()

    def _stand(self, within_s: float, why: str) -> None:
        stood = self.stopped.wait(within_s)
        if not stood or self.trouble:
            raise SlideError(self.trouble or f"{why} within {within_s:g} s; the motor was stopped")


def main() -> int:
    parser = argparse.ArgumentParser(description="Home a slide, and move it to places.")
    parser.add_argument("port")
    parser.add_argument("places", nargs="*", type=int, metavar="STEPS")
    parser.add_argument("--home-within", type=float, default=20.0, metavar="SECONDS")
    given = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    try:
        sac = Sac(given.port)
        try:
            sac.wake()
            slide = Slide(sac)
            slide.home(given.home_within)
            print("home", flush=True)
            for place in given.places:
                slide.move(place)
                print(f"at {place}", flush=True)
        finally:
            sac.close()
    except (SlideError, serial.SerialException) as error:
        print(f"home.py: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
