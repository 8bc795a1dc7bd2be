"""Agreement of C, Cython and Python about the native core's face."""

import ast
import re
from pathlib import Path

import pytest

import write_abi
from hil.core import _native, abi
from hil.core.fields import FIELDS
from hil.vocab import motion

CORE = Path(__file__).parent.parent
METHOD = re.compile(r"^    def (\w+)\(self(?:, )?(.*)\):$", re.M)


@pytest.mark.parametrize("file", write_abi.FILES, ids=lambda file: file.name)
def test_written_files_are_fresh(file: Path) -> None:
    assert file.read_text() == write_abi.FILES[file](), "run `make abi`"


def test_every_row_of_the_table_is_read() -> None:
    text = (write_abi.NATIVE / "abi.def").read_text()
    table = text[text.rindex("#endif\n") : text.index("#undef")]
    assert len(write_abi.rows()) == len(re.findall(r"^[A-Z_]+\(", table, re.M)) > 50


def test_a_number_has_one_name_but_for_pins() -> None:
    for macro, (name, _) in write_abi.enums().items():
        values = [row.value for row in write_abi.rows() if row.macro == macro]
        assert macro == "SERVO_INPUT" or len(values) == len(set(values)), name


def test_every_member_of_a_struct_is_read() -> None:
    stats = {member.name: member for member in write_abi.structs()["hil_rt_stats"]}
    assert [*stats][:2] == ["ticks", "missed"]
    assert stats["wake_latency"].size == "HIL_HISTOGRAM_LEN"
    assert [each.type for each in write_abi.structs()["hil_field_info"]][:2] == ["const char *"] * 2


def compiled_methods() -> dict[str, list[str]]:
    """Names of parameters by class and method, of the Cython source."""
    text = (CORE / "_native.pyx").read_text()
    found = {}
    for name, body in re.findall(r"^cdef class (\w+):(.*?)(?=^\S|\Z)", text, re.M | re.S):
        for method, given in METHOD.findall(body):
            names = [each.split()[-1] for each in given.split(",") if each]
            found[f"{name}.{method.replace('__cinit__', '__init__')}"] = names
    return {method: names for method, names in found.items() if not method.endswith("__dealloc__")}


def declared_methods() -> dict[str, list[str]]:
    """Names of parameters by class and method, of the stub that mypy reads."""
    classes = [
        node for node in ast.parse((CORE / "_native.pyi").read_text()).body if isinstance(node, ast.ClassDef)
    ]
    return {
        f"{each.name}.{method.name}": [argument.arg for argument in method.args.args[1:]]
        for each in classes
        for method in each.body
        if isinstance(method, ast.FunctionDef)
    }


def test_the_stub_declares_what_is_compiled() -> None:
    assert len(compiled_methods()) > 50
    assert declared_methods() == compiled_methods()


def test_what_is_compiled_is_of_this_table() -> None:
    """The wrong pin, slot or index is refused at the table's limits."""
    core = _native.NativeCore(1)
    motor = dict.fromkeys(
        ("inertia_kg_m2", "torque_constant_Nm_per_A", "rotor_teeth", "phase_current_A"), 1.0
    )
    motor |= dict.fromkeys(("viscous_Nm_s_per_rad", "start_deg", "load_torque_Nm", "driver"), 0.0)
    axis = core.axis_open(core.group_open(0), abi.Law.sac, motor, None, None, 0)
    assert len(core.motion_xref(axis)) == abi.MOTION_QUEUE + 1
    with pytest.raises(IndexError, match=f"0 to {abi.MOTION_SLOTS - 1}"):
        core.motion_read(axis, abi.MOTION_SLOTS)
    with pytest.raises(ValueError, match=f"of {abi.WATCHES}"):
        core.watch(axis, abi.WATCHES, 1, 1, 1, 1)


def test_firmware_and_core_mean_the_same_slots() -> None:
    assert motion.QUEUE_LEN == abi.MOTION_QUEUE
    assert (motion.CONTINUOUS_SLOT, motion.ONE_SHOT_SLOT) == (
        abi.MOTION_CONTINUOUS_SLOT,
        abi.MOTION_ONE_SHOT_SLOT,
    )


def test_a_field_is_of_a_kind() -> None:
    of_no_field = {abi.Kind.own_fields}
    assert {field.kind for field in FIELDS.values()} == set(abi.Kind) - of_no_field
    assert (FIELDS["yw"].kind, FIELDS["pulses"].kind) == (abi.Kind.servo, abi.Kind.stepper)
