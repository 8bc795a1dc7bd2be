"""Puts clocks, locks, threads and waits of simulated time in the place of Python's, for a whole process."""

import _thread
import multiprocessing.process
import os
import queue
import select
import selectors
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

import serial
from serial import serialposix, serialutil
from serial.tools import list_ports, list_ports_linux, list_ports_posix

from hil.testing.owned_time.children import Children
from hil.testing.owned_time.clocks import Clocks
from hil.testing.owned_time.file_times import FileTimes
from hil.testing.owned_time.owned_locks import lock_classes
from hil.testing.owned_time.owned_signals import OwnedSignals
from hil.testing.owned_time.selecting import SELECTORS, Selecting
from hil.testing.owned_time.threads import Threads
from hil.testing.owned_time.turns import Turns

_OURS = (
    *("hil", "bridges", "virtual_ports", "device_profiles"),
    *("importlib", "_thread", "_frozen_importlib", "_frozen_importlib_external", "posix"),
)
"""Packages that keep Python's own clocks, locks and times of files: the bench, and imports."""

_OF_SIGNAL = (
    *("setitimer", "getitimer", "alarm", "pause", "sigwait", "sigwaitinfo", "sigtimedwait"),
    *("raise_signal", "pthread_kill"),
)


class Replacements:
    """Names that were replaced, and what is there now."""

    def __init__(self) -> None:
        self._by_identity: dict[int, tuple[Any, Any]] = {}

    def put(self, module: Any, ours: Mapping[str, Any]) -> None:
        """Replace names of a module or class; those that it has not are left out."""
        for name, new in ours.items():
            if (old := getattr(module, name, None)) is not None:
                self._by_identity[id(old)] = old, new
                setattr(module, name, new)

    def put_everywhere(self) -> None:
        """Replace what was imported from these modules elsewhere, by ``from ... import``."""
        for name, module in [*sys.modules.items()]:  # noqa: TID251 - of the program, whatever it has
            if module and name.partition(".")[0] not in _OURS:
                self._put_in(module)

    def _put_in(self, module: ModuleType) -> None:
        for name, value in [*vars(module).items()]:
            known = self._by_identity.get(id(value))
            if known and known[0] is value:
                setattr(module, name, known[1])


def put_in_place(
    turns: Turns,
    clocks: Clocks,
    children: Children,
    port_class: type[serial.Serial],
    port_fds: Any,
    comports: Callable[..., Any],
) -> None:
    """Let the program live on simulated time from now on. ``port_class``: its ``serial.Serial``;
    ``port_fds``: answers the descriptors of ports; ``comports``: lists them."""
    places = Replacements()
    lock, rlock = lock_classes(turns)
    real_start = getattr(_thread, "start_joinable_thread", None)
    plain, joinable = Threads(turns, _thread.start_new_thread), Threads(turns, real_start or print)
    signals, selecting = OwnedSignals(turns), Selecting(turns, port_fds)
    turns.timers, turns.outside = signals, children

    places.put(time, clocks.of_time())
    clocks.put_in_datetime()
    places.put(threading, {"RLock": rlock, "Lock": lock, "_allocate_lock": lock, "_CRLock": rlock})
    places.put(_thread, {"start_new_thread": plain.start_new_thread, "start_new": plain.start_new_thread})
    places.put(
        threading,
        {
            "_start_new_thread": plain.start_new_thread,
            "_start_joinable_thread": joinable.start_new_thread,
            "_shutdown": plain.shut_down,
        },
    )
    places.put(
        threading.Thread,
        {
            "join": lambda thread, timeout=None: plain.join(thread, timeout),
            "is_alive": lambda thread: plain.is_alive(thread),
        },
    )
    places.put(queue, {"SimpleQueue": queue._PySimpleQueue})  # type: ignore[attr-defined]
    places.put(select, selecting.of_select())
    places.put(
        selectors,
        {
            **{each.__name__: selecting.selector_class(each) for each in SELECTORS},
            "DefaultSelector": selecting.selector_class(selectors.DefaultSelector),
        },
    )
    places.put(os, {"pipe": selecting.pipe, "read": selecting.read})
    places.put(socket, {"socketpair": selecting.socketpair})
    places.put(socket.socket, selecting.of_socket())
    places.put(signal, {"signal": signals.set_handler, "getsignal": signals.handler})
    places.put(signal, {name: getattr(signals, name) for name in _OF_SIGNAL})
    places.put(_thread, {"interrupt_main": signals.interrupt_main})
    places.put(multiprocessing.process.BaseProcess, {"start": _no_process})
    places.put(os, {"kill": signals.kill, "waitpid": children.waitpid, "fork": _no_fork, "forkpty": _no_fork})
    places.put(
        subprocess.Popen,
        {"_execute_child": lambda child, *options: children.execute_child(child, *options)},
    )
    if deleted := getattr(subprocess, "_del_safe", None):
        places.put(deleted, {"waitpid": children.waitpid})
    for module in (list_ports, list_ports_linux, list_ports_posix):
        places.put(module, {"comports": comports})
    for module in (serial, serialposix):
        places.put(module, {"Serial": port_class})
    places.put(serialutil, {"Timeout": _timeout(clocks)})
    clocks.put_in_uuid()
    places.put(os, FileTimes(clocks.date_ns).of_os())
    os.environ |= children.environment()
    places.put_everywhere()


def _timeout(clocks: Clocks) -> type[Any]:
    class Timeout(serialutil.Timeout):
        TIME = clocks.monotonic

    return Timeout


def _no_fork() -> int:
    raise RuntimeError(_NO_PROCESS)


def _no_process(process: object) -> None:
    raise RuntimeError(_NO_PROCESS)


_NO_PROCESS = (
    "hil virtual: a process of multiprocessing, or a forked one, would have a simulated time of its own;"
    " use threads, or a child by subprocess, which has the wall's time"
)
