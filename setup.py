"""Only what pyproject.toml cannot say yet: the native core."""

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
            depends=[
                f"{NATIVE}/{name}"
                for name in (
                    "core.h",
                    "hil_core.h",
                    "fields.def",
                    "control/mechaduino.h",
                    "motion/motion.h",
                    "motion/profile.h",
                    "motion/ramp.h",
                    "stepper.h",
                    "plant/full.h",
                    "plant/simple.h",
                    "plant/trig.h",
                    "rt/ring.h",
                    "rt/seqlock.h",
                )
            ],
            include_dirs=["hil/core"],
            libraries=["m"],
            # No contraction: the laws keep the firmware's float32 arithmetic exactly.
            extra_compile_args=["-std=gnu11", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-pthread"],
            extra_link_args=["-pthread"],
        )
    ]
)
