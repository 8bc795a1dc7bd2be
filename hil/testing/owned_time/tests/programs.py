"""Programs as users write them, with what each prints on simulated time. ``p`` of a Mechaduino prints the
first half of a line at once and the rest 100 ms later."""

PROGRAMS = {
    "reads with a time-out": (
        """
import serial, time
s = serial.Serial("m1", 115200, timeout=1); s.reset_input_buffer()
start = time.monotonic(); s.write(b"p"); line = s.readline(); took = time.monotonic() - start
print(line.startswith(b"stepNumber"), 0.1 <= took < 0.101, s.read(5), time.monotonic() - start < 1.2)
""",
        "True True b'' True",
    ),
    "polls without a sleep": (
        """
import serial, time
s = serial.Serial("m1", 115200, timeout=0); s.reset_input_buffer()
end, got = time.time() + 2, b""; s.write(b"p")
while not got.endswith(b"\\r\\n") and time.time() < end:
    if s.in_waiting: got += s.read(s.in_waiting)
print(got.count(b"Angle"), 1.88 < end - time.time() < 1.9)
""",
        "1 True",
    ),
    "a reading thread, a queue, an event": (
        """
import queue, serial, threading, time
s = serial.Serial("m1", 115200, timeout=0.2); s.reset_input_buffer()
lines, done = queue.Queue(), threading.Event()
def receive():
    while not done.is_set():
        if line := s.readline(): lines.put(line)
thread = threading.Thread(target=receive); thread.start()
s.write(b"p"); first = lines.get(timeout=1); start = time.monotonic()
try: lines.get(timeout=0.5)
except queue.Empty: print(len(first) > 20, 0.5 <= time.monotonic() - start < 0.51)
done.set(); thread.join(); print(thread.is_alive(), threading.active_count())
""",
        "True True\nFalse 1",
    ),
    "locks, conditions, a semaphore, a barrier, a timer": (
        """
import threading, time
order, condition, barrier = [], threading.Condition(), threading.Barrier(3)
def work(n):
    time.sleep(n / 10); barrier.wait()
    with condition: order.append(n); condition.notify_all()
for n in (3, 1): threading.Thread(target=work, args=(n,)).start()
start = time.monotonic(); barrier.wait()
print(round(time.monotonic() - start, 2))
with condition: print(condition.wait_for(lambda: len(order) == 2, 5), sorted(order))
few, lock = threading.BoundedSemaphore(2), threading.RLock()
with few, lock, lock: print(few.acquire(timeout=0.1), few.acquire(timeout=0.1), lock.acquire(blocking=False))
threading.Timer(0.5, order.append, [9]).start(); time.sleep(0.6); print(order[-1])
""",
        "0.3\nTrue [1, 3]\nTrue False True\n9",
    ),
    "spins on a queue and sleeps nothing": (
        """
import queue, threading, time
q = queue.Queue()
threading.Thread(target=lambda: (time.sleep(0.1), q.put(1), time.sleep(0.1), q.put(2))).start()
while q.empty(): pass
while q.qsize() < 2: time.sleep(0)
print(q.get(), q.get_nowait())
""",
        "1 2",
    ),
    "an executor and asyncio": (
        """
import asyncio, concurrent.futures, serial
s = serial.Serial("m1", 115200, timeout=1); s.reset_input_buffer()
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    s.write(b"p"); print(len(pool.submit(s.readline).result(timeout=2)) > 20)
async def main():
    loop, heard = asyncio.get_running_loop(), asyncio.StreamReader()
    loop.add_reader(s.fileno(), lambda: heard.feed_data(s.read(s.in_waiting))); s.write(b"p")
    start = loop.time(); line = await asyncio.wait_for(heard.readline(), 1); took = loop.time() - start
    loop.remove_reader(s.fileno()); s.write(b"p")
    rest = await loop.run_in_executor(None, s.readline)
    async with asyncio.timeout(5): await asyncio.sleep(0.2)
    return len(line) > 20, 0.1 <= took < 0.11, len(rest) > 20, loop.time() - start < 0.5
print(asyncio.run(main()))
""",
        "True\n(True, True, True, True)",
    ),
    "select, poll and selectors": (
        """
import select, selectors, serial, time
s = serial.Serial("m1", 115200, timeout=0); s.reset_input_buffer()
start = time.monotonic(); print(select.select([s], [], [], 0.25), round(time.monotonic() - start, 2))
s.write(b"p"); print(len(select.select([s], [], [], 1)[0]), s.read(99)[:4])
poll = select.poll(); poll.register(s, select.POLLIN); print(len(poll.poll(500))); s.read(99)
chosen = selectors.DefaultSelector(); chosen.register(s, selectors.EVENT_READ); print(chosen.select(0.1))
""",
        "([], [], []) 0.25\n1 b'step'\n1\n[]",
    ),
    "cancels a read": (
        """
import serial, threading, time
s = serial.Serial("m1", 115200); s.reset_input_buffer(); out = []
t = threading.Thread(target=lambda: out.append(s.read(100))); t.start(); start = time.monotonic()
time.sleep(0.2); s.cancel_read(); t.join(1); print(out, t.is_alive(), time.monotonic() - start < 0.21)
""",
        "[b''] False True",
    ),
    "timers by signal": (
        """
import serial, signal, time
class Late(Exception): pass
def ring(number, frame): raise Late
signal.signal(signal.SIGALRM, ring)
s = serial.Serial("m1", 115200); s.reset_input_buffer(); start = time.monotonic(); signal.alarm(2)
try: s.read(1)
except Late: print("late", round(time.monotonic() - start, 3))
rung = []; signal.signal(signal.SIGALRM, lambda number, frame: rung.append(time.monotonic()))
signal.setitimer(signal.ITIMER_REAL, 0.1, 0.05); time.sleep(0.32)
print(len(rung), signal.getitimer(signal.ITIMER_REAL)[1]); signal.setitimer(signal.ITIMER_REAL, 0)
signal.alarm(1); signal.pause(); print(len(rung))
""",
        "late 2.0\n5 0.05\n6",
    ),
    "handlers of signals, as Python calls them": (
        """
import os, queue, select, serial, signal, threading, time
s = serial.Serial("m1", 115200, timeout=1); s.reset_input_buffer(); heard, q = [], queue.SimpleQueue()
def ring(number, frame): s.write(b"p"); heard.append((s.readline()[:4], frame.f_code.co_name)); q.put(1)
signal.signal(signal.SIGALRM, ring); print(signal.getsignal(signal.SIGALRM) is ring)
signal.setitimer(signal.ITIMER_REAL, 0.5, 0.5)
while len(heard) < 2: signal.pause()
print(heard, q.qsize()); signal.setitimer(signal.ITIMER_REAL, 0)
out, into = os.pipe(); os.set_blocking(into, False); signal.set_wakeup_fd(into); signal.alarm(1)
print(select.select([out], [], [], 3)[0] == [out], os.read(out, 9)); signal.set_wakeup_fd(-1)
rung = []; signal.signal(signal.SIGALRM, lambda *_: rung.append(1)); signal.setitimer(signal.ITIMER_REAL, 0.3)
while not rung: pass
print(rung)
""",
        "True\n[(b'step', '<module>'), (b'step', '<module>')] 2\nTrue b'\\x0e'\n[1]",
    ),
    "signals that are blocked and waited for": (
        """
import signal, threading, time
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM]); start = time.monotonic()
signal.setitimer(signal.ITIMER_REAL, 0.25, 0.25); print(signal.sigwait([signal.SIGALRM]).name)
print(signal.sigtimedwait([signal.SIGALRM], 1).si_signo, signal.sigtimedwait([signal.SIGALRM], 0.1))
print(round(time.monotonic() - start, 1)); time.sleep(0.3); print(signal.sigpending()); signal.alarm(0)
""",
        "SIGALRM\n14 None\n0.6\n{<Signals.SIGALRM: 14>}",
    ),
    "signals from another thread": (
        """
import _thread, os, queue, serial, signal, threading, time
s = serial.Serial("m1", 115200); s.reset_input_buffer(); here = os.getpid(), signal.SIGINT
sends = [lambda: os.kill(*here), _thread.interrupt_main, lambda: signal.raise_signal(signal.SIGINT)]
for send in (*sends, lambda: signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)):
    for wait in (lambda: s.read(1), queue.Queue().get, threading.Event().wait, lambda: time.sleep(9)):
        threading.Timer(0.2, send).start(); start = time.monotonic()
        try: wait()
        except KeyboardInterrupt: print(round(time.monotonic() - start, 3), end=" ")
stop = threading.Event(); signal.signal(signal.SIGTERM, lambda *_: stop.set())
threading.Timer(1, os.kill, [os.getpid(), signal.SIGTERM]).start(); print(stop.wait(5))
""",
        f"{'0.2 ' * 16}True",
    ),
    "asyncio hears a signal": (
        """
import asyncio, os, signal
async def main():
    loop, rung = asyncio.get_running_loop(), asyncio.Event()
    loop.add_signal_handler(signal.SIGALRM, rung.set)
    signal.setitimer(signal.ITIMER_REAL, 0.2); start = loop.time(); await asyncio.wait_for(rung.wait(), 1)
    print(round(loop.time() - start, 2))
asyncio.run(main())
""",
        "0.2",
    ),
    "calendars": (
        """
import datetime, pickle, time
from datetime import datetime as stamp
a = stamp.now(datetime.timezone.utc); time.sleep(86400); b = stamp.now(datetime.timezone.utc)
print(a.isoformat()[:19], b.isoformat()[:10], (b - a).days, time.strftime("%H:%M", time.gmtime()))
print(isinstance(a, datetime.datetime), isinstance(stamp.strptime("2020", "%Y"), stamp))
print(issubclass(stamp, datetime.date), pickle.loads(pickle.dumps(a)) == a)
print(datetime.date.today().year, isinstance(datetime.date.today(), stamp))
""",
        "2026-01-01T00:00:00 2026-01-02 1 00:00\nTrue True\nTrue True\n2026 False",
    ),
    "dates are Python's own objects": (
        """
import copy, datetime, time, uuid
from datetime import datetime as stamp
class Mine(stamp): pass
a = stamp.now(); print(type(a) is stamp, isinstance(a, Mine), type(Mine.now()) is Mine)
print(type(a.date()) is datetime.date)
print(type(stamp.combine(a.date(), a.time())) is stamp, type(stamp.min) is stamp, copy.copy(a) == a)
print(abs((uuid.uuid1().time - 0x01b21dd213814000) / 1e7 - time.time()) < 1, time.time.__name__)
""",
        "True False True\nTrue\nTrue True True\nTrue time",
    ),
    "files have the program's dates": (
        """
import glob, logging, os, pathlib, tempfile, time
from logging.handlers import TimedRotatingFileHandler
folder = pathlib.Path(tempfile.mkdtemp()); file = folder / "log"
log = logging.getLogger(); log.addHandler(TimedRotatingFileHandler(file, when="S"))
for _ in range(4): log.warning("x"); time.sleep(1)
print(len(list(folder.iterdir()))); file.touch(); made = time.time(); time.sleep(5)
print(abs(made - file.stat().st_mtime) < 0.1, time.time() - os.path.getmtime(file) > 4.9)
os.utime(file, (0, made - 3600)); print(round(made - os.stat(file).st_mtime), file.lstat().st_atime)
print(os.path.getmtime(os.__file__) < made - 5)
""",
        "4\nTrue True\n3600 0.0\nTrue",
    ),
    "pipes within the program": (
        """
import os, select, threading, time
out, into = os.pipe(); start = time.monotonic()
def send():
    for _ in range(2): time.sleep(60); os.write(into, b"a")
threading.Thread(target=send).start(); print(os.read(out, 9), select.select([out], [], [], 61)[0] == [out])
print(os.read(out, 9), time.monotonic() - start < 121)
""",
        "b'a' True\nb'a' True",
    ),
    "a socket is closed while another thread waits": (
        """
import socket, threading, time
one, other = socket.socketpair(); told = []
def wait():
    try: one.recv(1)
    except OSError as error: told.append(error.errno)
thread = threading.Thread(target=wait); thread.start(); time.sleep(1); one.close(); thread.join(); print(told)
""",
        "[9]",
    ),
    "a child that has the port": (
        """
import subprocess, sys, time
code = "import serial; s = serial.Serial('m1', 115200, timeout=2); s.reset_input_buffer(); s.write(b'p')"
code += "; print(s.readline()[:10])"
print(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip())
lock = "import serial\\ntry: serial.Serial('m1', exclusive=True); print('free')"
lock += "\\nexcept serial.SerialException as error: print(error)"
import serial; ours = serial.Serial("m1", exclusive=True)
def ask(): return subprocess.run([sys.executable, "-c", lock], capture_output=True).stdout[:18]
print(ask()); ours.close(); print(ask())
holds = "import serial; s = serial.Serial('m1', exclusive=True); print(flush=True); input(); s.close()"
holds += "; print(flush=True); input()"
child = subprocess.Popen([sys.executable, "-c", holds], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
child.stdout.readline()
try: serial.Serial("m1", exclusive=True)
except serial.SerialException as error: print(str(error)[:18])
child.stdin.write(b"\\n"); child.stdin.flush(); child.stdout.readline()
print(serial.Serial("m1", exclusive=True).is_open); child.communicate(b"\\n")
late = "import time; time.sleep(0.3); print('child')"
child = subprocess.Popen([sys.executable, "-c", late], stdout=subprocess.PIPE)
start = time.time(); print(child.communicate()[0], child.returncode, time.time() - start < 20)
""",
        "b'stepNumber'\nb'[Errno 11] Could n'\nb'free\\n'\n[Errno 11] Could n\nTrue\nb'child\\n' 0 True",
    ),
    "sockets within the program": (
        """
import socket, threading, time
server = socket.create_server(("127.0.0.1", 0))
def serve():
    came, _ = server.accept(); came.sendall(came.recv(9).upper()); time.sleep(1); came.close()
threading.Thread(target=serve).start()
client = socket.create_connection(server.getsockname(), timeout=5); client.sendall(b"abc")
print(client.recv(9))
client.settimeout(0.2)
try: client.recv(1) and print("more")
except TimeoutError: print("timed out")
client.close()
""",
        "b'ABC'\ntimed out",
    ),
    "is closed and opened, and is a Serial": (
        """
import serial
class Mine(serial.Serial):
    def ask(self): self.write(b"p"); return self.readline()[:4]
with Mine("m1", 115200, timeout=1) as s: s.reset_input_buffer(); print(s.ask(), isinstance(s, serial.Serial))
with serial.serial_for_url("m1", 115200) as s: print(type(s) is serial.Serial)
try: serial.Serial("/dev/ttyUSB7")
except serial.SerialException as error: print(error.errno, "there are m1" in str(error))
""",
        "b'step' True\nTrue\n2 True",
    ),
}
