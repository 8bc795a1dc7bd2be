"""Parts of the build that pyproject.toml cannot say yet: the native core, the planner, the packet codec, the
byte faults, Modbus RTU's CRC, bits of CAN, the library of `hil with-lines`, that they are compiled on all
CPUs, and that packages are made of what git tracks."""

import fcntl
import os
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist
from setuptools.errors import FileError

NATIVE = "hil/core/native"
CHIPS = f"{NATIVE}/mcu"
"""Processors: part of the core, and alone in an extension of their own."""
PLANNER = [f"{NATIVE}/motion/{name}.c" for name in ("course", "shape", "spline", "trajectory")]
LINES = "hil.host.libhil_lines"
"""Library that is loaded into other programs, and no module of Python: its file has no tag of a Python."""
ROOT = Path(__file__).parent
COMPILED_BY = ROOT / "build" / f"compiled-by-{sys.implementation.cache_tag}"
"""Tells which Python the modules beside their sources are compiled for: another of this version may have been
built with other flags."""
UNFINISHED = ROOT / "build" / "unfinished"
"""There while something is compiled. One that was there before was left by a build that was killed, or that
found the disk full: what it has written may be cut off, and is made again."""
CORE_FLAGS = (
    "-std=gnu11",
    "-O3",
    "-ffp-contract=off",  # the laws keep the firmware's float32 arithmetic exactly
    "-fvisibility=hidden",
    "-fno-strict-aliasing",  # gcc 12 dropped stores of a law that had moved in a lane
    "-Wno-psabi",  # no vector is handed to a function that is not inlined
    "-pthread",
)
"""Compiler flags of the native core, beside those of Python's own build; benchmarks use them, too."""
BINDINGS = (
    "hil/core/_native.c",
    "hil/core/_trajectory.c",
    "hil/core/_processor.c",
    "bridges/can/bus/_bit_wire.c",
)
"""Generated C that only calls other C. -O3 takes twice as long to compile it as -O1, and makes no call
shorter; nor is other generated C faster than with -O2."""


def tracked() -> set[str] | None:
    """Files that belong to the project, as git knows it; None where this is no checkout, as below an
    sdist."""
    if not (ROOT / ".git").exists():
        return None
    # Also for root in somebody's checkout, as for `sudo make install-service`.
    command = ["git", "-c", "safe.directory=*", "-C", str(ROOT), "ls-files", "-z"]
    try:
        listed = subprocess.run(command, capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise FileError(f"git has to say which files of this checkout belong to hil: {error}") from None
    return set(listed.decode().strip("\0").split("\0"))


def native_sources(folder: str) -> list[str]:
    """C below a folder, without its tests."""
    found = (path.relative_to(ROOT) for path in (ROOT / folder).rglob("*.c"))
    return sorted(path.as_posix() for path in found if "tests" not in path.parts)


def headers(folder: str) -> list[str]:
    """Headers that sources below a folder may include: a change of one compiles them again."""
    found = (path.relative_to(ROOT) for path in (ROOT / folder).rglob("*.*") if path.suffix in {".h", ".def"})
    return sorted(path.as_posix() for path in found if "tests" not in path.parts)


class Progress:
    """Bytes of C that are compiled, of all, and when that began, for ``packaging/build_venv.py``: in the file
    that HIL_BUILD_PROGRESS names, if it does."""

    def __init__(self, extensions: list[Extension]) -> None:
        sources = [source.replace(".pyx", ".c") for each in extensions for source in each.sources]
        self._sizes = {source: os.path.getsize(source) for source in sources}
        self._done, self._begun, self._lock = 0, time.time(), threading.Lock()

    def add(self, source: str) -> None:
        """Note that a source is compiled."""
        with self._lock:
            self._done += self._sizes.get(source, 0)
            if file := os.environ.get("HIL_BUILD_PROGRESS"):
                Path(f"{file}.new").write_text(f"{self._done} {sum(self._sizes.values())} {self._begun}")
                os.replace(f"{file}.new", file)


class BuildOnAllCpus(build_ext):
    """Translates and compiles sources side by side: in half the time on two CPUs."""

    def run(self) -> None:
        """Build all, one build of a checkout after the other."""
        with (ROOT / "setup.py").open() as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            self.force = self.force or UNFINISHED.exists()
            UNFINISHED.parent.mkdir(exist_ok=True)
            UNFINISHED.touch()
            super().run()
            UNFINISHED.unlink()

    def get_ext_filename(self, fullname: str) -> str:
        is_ours = LINES.endswith(fullname)  # it is asked by the last part alone, too
        return f"{fullname.replace('.', '/')}.so" if is_ours else str(super().get_ext_filename(fullname))

    def build_extension(self, ext: Extension) -> None:
        """Build an extension, or take what is beside its sources and newer than they are: what an editable
        install has compiled is there for its next one, a wheel, a package and the service."""
        built = Path(self.get_ext_filename(ext.name))
        if self._is_taken and built.exists():
            changed = max(os.path.getmtime(file) for file in ("setup.py", *self._written[ext.name]))
            if changed < built.stat().st_mtime:
                made = Path(self.get_ext_fullpath(ext.name))
                made.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(built, made)
                return
        super().build_extension(ext)

    def build_extensions(self) -> None:
        self._written = {each.name: (*each.sources, *each.depends) for each in self.extensions}
        is_ours = COMPILED_BY.exists() and COMPILED_BY.read_text() == sys.version
        self._is_taken = is_ours and not self.force and "SOURCE_DATE_EPOCH" not in os.environ
        from Cython.Build import cythonize  # metadata is made without it

        cpus = len(os.sched_getaffinity(0))
        cythonize(self.extensions, nthreads=cpus, force=self.force, quiet=True)
        for extension in self.extensions:
            extension.extra_compile_args.append("-g1")  # lines for debuggers; -g takes twice as long
            if "SOURCE_DATE_EPOCH" in os.environ:  # a release: the same bytes from any folder
                extension.extra_compile_args.append(f"-ffile-prefix-map={ROOT.resolve()}=.")
        compile_one_by_one, progress = self.compiler.compile, Progress(self.extensions)
        begun: dict[str, Future[list[str]]] = {}  # a source of two extensions is compiled once
        begins = threading.Lock()
        with ThreadPoolExecutor(cpus) as pool:

            def compile(sources: list[str], **options: Any) -> list[str]:
                def one(source: str) -> list[str]:
                    flags = list(options["extra_postargs"] or ())
                    if Path(source).with_suffix(".pyx").exists():
                        flags.append("-O1" if source in BINDINGS else "-O2")
                    made = compile_one_by_one([source], **{**options, "extra_postargs": flags})
                    progress.add(source)
                    return list(made)

                # The longest first: the last of them would be waited for alone.
                with begins:
                    for source in sorted(sources, key=lambda source: -os.path.getsize(source)):
                        if source not in begun:
                            begun[source] = pool.submit(one, source)
                return [each for source in sources for each in begun[source].result()]

            self.compiler.compile = compile
            self.parallel = len(self.extensions)  # those wait; the pool has the work
            super().build_extensions()
        if self.editable_mode and not is_ours:
            COMPILED_BY.parent.mkdir(exist_ok=True)
            COMPILED_BY.write_text(sys.version)


class BuildOfTracked(build_py):
    """Refuses what git does not track: a file that lies around, or one that somebody has forgotten. What an
    earlier build has left of files that are gone is removed: a wheel has all that is in its folder."""

    def run(self) -> None:
        if not self.editable_mode and (known := tracked()) is not None:
            outside = (file for _, files in self.distribution.data_files or () for file in files)
            files = {Path(file).as_posix() for file in (*self.get_output_mapping().values(), *outside)}
            if strange := sorted(files - known):
                raise FileError(f"git does not track {', '.join(strange)}: `git add` them, or move them away")
            self.remove_old()
        super().run()

    def remove_old(self) -> None:
        made = {*self.get_outputs(), *self.get_finalized_command("build_ext").get_outputs()}
        expected = {Path(file).resolve() for file in made}
        for package in {name.partition(".")[0] for name in self.packages or ()}:
            for file in (Path(self.build_lib) / package).rglob("*"):
                if file.is_file() and file.resolve() not in expected:
                    file.unlink()


class SdistOfTracked(sdist):
    """Source distribution of all that git tracks, and no more; a wheel and the tests can be made of it."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        if (known := tracked()) is not None:
            files = [*sorted(known), *(file for file in files if ".egg-info/" in file)]
        super().make_release_tree(base_dir, files)


setup(
    cmdclass={"build_ext": BuildOnAllCpus, "build_py": BuildOfTracked, "sdist": SdistOfTracked},
    ext_modules=[
        Extension(
            "hil.core._native",
            [
                "hil/core/_native.pyx",
                *(file for file in native_sources(NATIVE) if file not in PLANNER),
            ],
            depends=["hil/core/hil_core.pxd", *headers(NATIVE)],
            include_dirs=["hil/core"],
            libraries=["m"],
            extra_compile_args=list(CORE_FLAGS),
            extra_link_args=["-pthread"],
        ),
        Extension(
            "hil.core._processor",
            ["hil/core/_processor.pyx", *native_sources(CHIPS)],
            depends=headers(CHIPS),
            include_dirs=["hil/core"],
            extra_compile_args=list(CORE_FLAGS),
            extra_link_args=["-pthread"],
        ),
        Extension(
            "hil.core._trajectory",
            [
                "hil/core/_trajectory.pyx",
                *PLANNER,
            ],
            depends=headers(f"{NATIVE}/motion"),
            include_dirs=["hil/core"],
            libraries=["m"],
            extra_compile_args=["-std=gnu11", "-O3", "-ffp-contract=off", "-fvisibility=hidden"],
        ),
        Extension(
            "hil.wire._byte_faults",
            ["hil/wire/_byte_faults.pyx"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
        Extension(
            "bridges.modbus.protocol._crc16",
            ["bridges/modbus/protocol/_crc16.pyx"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
        Extension(
            "bridges.can.frames._wire_bits",
            ["bridges/can/frames/_wire_bits.pyx"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
        Extension(
            "hil.sim._each_packet",
            ["hil/sim/_each_packet.pyx"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
        Extension(
            LINES,
            native_sources("hil/host/native"),
            libraries=["dl"],  # dlsym, where the libc has it elsewhere: before glibc 2.34
            extra_compile_args=[
                "-std=gnu11",
                "-O2",
                "-fvisibility=hidden",
                "-Wall",
                "-Wextra",
                "-Werror",
            ],
        ),
        Extension(
            "bridges.can.bus._bit_wire",
            [
                "bridges/can/bus/_bit_wire.pyx",
                *native_sources("bridges/can/bus/native"),
            ],
            depends=headers("bridges/can/bus/native"),
            include_dirs=["bridges/can/bus"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
        Extension(
            "device_profiles.sac._packet",
            ["device_profiles/sac/_packet.pyx", *native_sources("device_profiles/sac/native")],
            depends=headers("device_profiles/sac/native"),
            include_dirs=["device_profiles/sac"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
    ],
)
