"""Only what pyproject.toml cannot say yet: the native core, the planner, and of the line the packet codec and
byte faults."""

from setuptools import Extension, setup

NATIVE = "hil/core/native"

setup(
    ext_modules=[
        Extension(
            "hil.core._native",
            [
                "hil/core/_native.pyx",
                f"{NATIVE}/core.c",
                f"{NATIVE}/axis.c",
                f"{NATIVE}/batch.c",
                f"{NATIVE}/batch_any.c",
                f"{NATIVE}/batch_avx2.c",
                f"{NATIVE}/fault.c",
                f"{NATIVE}/follow.c",
                f"{NATIVE}/control/mechaduino.c",
                f"{NATIVE}/plant/full.c",
                f"{NATIVE}/plant/simple.c",
                f"{NATIVE}/rt/thread.c",
                f"{NATIVE}/rt/watchdog.c",
                f"{NATIVE}/motion/motion.c",
                f"{NATIVE}/motion/profile.c",
                f"{NATIVE}/motion/ramp.c",
                f"{NATIVE}/source.c",
                f"{NATIVE}/stepper.c",
                f"{NATIVE}/watch.c",
            ],
            depends=["hil/core/hil_core.pxd"]
            + [
                f"{NATIVE}/{name}"
                for name in (
                    "batch.h",
                    "batch_lanes.h",
                    "core.h",
                    "hil_core.h",
                    "fields.def",
                    "control/mechaduino.h",
                    "motion/motion.h",
                    "motion/profile.h",
                    "motion/ramp.h",
                    "stepper.h",
                    "control/mechaduino_x4.h",
                    "plant/full.h",
                    "plant/simple.h",
                    "plant/full_kernel.h",
                    "plant/real.h",
                    "plant/simple_kernel.h",
                    "plant/trig.h",
                    "plant/trig_kernel.h",
                    "rt/ring.h",
                    "rt/seqlock.h",
                )
            ],
            include_dirs=["hil/core"],
            libraries=["m"],
            # No contraction: the laws keep the firmware's float32 arithmetic exactly.
            extra_compile_args=[
                "-std=gnu11",
                "-O3",
                "-ffp-contract=off",
                "-fvisibility=hidden",
                "-fno-strict-aliasing",  # gcc 12 dropped stores of a law that had moved in a lane
                "-Wno-psabi",  # no vector is handed to a function that is not inlined
                "-pthread",
            ],
            extra_link_args=["-pthread"],
        ),
        Extension(
            "hil.core._trajectory",
            [
                "hil/core/_trajectory.pyx",
                f"{NATIVE}/motion/course.c",
                f"{NATIVE}/motion/shape.c",
                f"{NATIVE}/motion/spline.c",
                f"{NATIVE}/motion/trajectory.c",
            ],
            depends=[f"{NATIVE}/motion/shape.h", f"{NATIVE}/motion/trajectory.h"],
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
            "hil.wire._packet",
            ["hil/wire/_packet.pyx", "hil/wire/native/packet.c"],
            depends=["hil/wire/native/packet.h"],
            include_dirs=["hil/wire"],
            extra_compile_args=["-std=gnu11", "-O3", "-fvisibility=hidden"],
        ),
    ]
)
