"""Sketches in Python that a configuration names: ``sketch``, of a board whose firmware takes one."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from hil.config.document import Document, Finding, KeyPath
from hil.config.explain import shown
from hil.config.port_model import is_path
from hil.vocab.problem import Problem, not_text

if TYPE_CHECKING:
    from ast import Module

SKETCH = "sketch"
_AS_LOGGED = {"file", "text"}
"""Keys of a sketch in a log, which has its text: a replay runs what ran."""
_LOOP_US, _TURNS_US = "LOOP_US", (0.001, 1e9)
"""Time of a turn of loop(), and its limits, as ``hil.firmware.sketch_waits`` has them."""
_HOOKS = ("setup", "loop", "controller", "step_interrupt")


@dataclass(frozen=True)
class SketchText:
    """Text of a sketch. ``file``: its path, for messages."""

    file: str
    text: str


def _read(value: Any) -> SketchText | None:
    if value is not None and not isinstance(value, SketchText):
        raise PydanticCustomError("path", "this is not a path", {"remedy": "write the path, or null"})
    return value


SketchKey = Annotated[
    SketchText | None,
    PlainValidator(_read),
    PlainSerializer(lambda sketch: sketch and {"file": sketch.file, "text": sketch.text}),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "null"}]}),
]
"""Key of a sketch: a path in a configuration, ``SketchText`` when it was checked."""


class SketchCheck:
    """Check of the sketch of one device. ``findings``: mistakes in the configuration; ``problems``: in the
    file."""

    def __init__(
        self, path: KeyPath, given: Any, document: Document, read_text: Callable[[Path], str] | None
    ) -> None:
        self._path: KeyPath = (*path, SKETCH)
        self._given, self._folder, self._read_text = given, Path(document.file).parent, read_text
        self.findings: list[Finding] = []
        self.problems: list[Problem] = []

    def read(self, profile: str, *, takes: bool) -> SketchText | None:
        """Read it; None: it cannot be used. ``takes``: whether the board takes any."""
        if not takes:
            message = f"the firmware of a {profile} takes no sketch"
            self.findings.append(Finding(self._path, message, "leave this key out", at_key=True))
            return None
        found = self._text()
        if found is None:
            return None
        self.problems += problems_of(found)
        if self.problems:
            message = f"the sketch {found.file} cannot be used"
            self.findings.append(Finding(self._path, message, "mend what is said of it below"))
            return None
        return found

    def _text(self) -> SketchText | None:
        if isinstance(self._given, Mapping) and self._given.keys() == _AS_LOGGED:
            return SketchText(str(self._given["file"]), str(self._given["text"]))
        if not is_path(self._given):
            what = f"a file's path is wanted here, not {shown(self._given)}"
            self.findings.append(Finding(self._path, what, "write the path, as in button.py"))
            return None
        assert self._read_text is not None, "this catalogue reads no files"
        path = self._folder / self._given
        try:
            return SketchText(str(path), self._read_text(path))
        except UnicodeDecodeError as error:
            self.problems.append(not_text(str(path), error))
            self.findings.append(
                Finding(self._path, "the sketch is no text", "mend what is said of it below")
            )
        except OSError as error:
            message = f"{path} cannot be read: {error.strerror}"
            self.findings.append(Finding(self._path, message, "write where it is, from this file on"))
        return None


def problems_of(sketch: SketchText) -> Iterator[Problem]:
    """Problems of a sketch's text: what is no Python, functions that are missing, or take something else."""
    import ast  # who has no sketch does not wait for it

    if sketch.file.lower().endswith((".ino", ".cpp", ".c")):
        remedy = "write setup() and loop() in a .py file: `hil docs own-mechaduino`"
        yield Problem(
            sketch.file, 1, 1, "this is C++, and a sketch beside the stock firmware is Python", remedy
        )
        return

    try:
        tree = ast.parse(sketch.text, sketch.file)
    except SyntaxError as error:
        yield Problem(
            sketch.file, error.lineno or 1, error.offset or 1, f"this is no Python: {error.msg}", "mend it"
        )
        return
    except ValueError as error:  # a 0 byte
        yield Problem(sketch.file, 1, 1, f"this is no Python: {error}", "mend it")
        return
    functions = {
        each.name: each for each in tree.body if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    if "loop" not in functions:
        yield Problem(sketch.file, 1, 1, "the sketch has no loop()", 'write "def loop(board):"')
    yield from _turn_problems(sketch.file, tree)
    for name in functions.keys() & set(_HOOKS):
        each = functions[name]
        place = each.lineno, each.col_offset + 1
        if isinstance(each, ast.AsyncFunctionDef):
            yield Problem(sketch.file, *place, f"{name}() is async", "write def, and yield what waits")
        elif len(each.args.posonlyargs + each.args.args) - len(each.args.defaults) != 1:
            yield Problem(sketch.file, *place, f"{name}() takes one argument", f'write "def {name}(board):"')


def _turn_problems(file: str, tree: "Module") -> Iterator[Problem]:
    """Problem of a time of a turn that there is not; of one that is computed the sketch finds it."""
    from ast import Assign, Constant, Name

    for each in tree.body:
        names = [of.id for of in each.targets if isinstance(of, Name)] if isinstance(each, Assign) else []
        if not isinstance(each, Assign) or _LOOP_US not in names or not isinstance(each.value, Constant):
            continue
        us = each.value.value
        if not (isinstance(us, int | float) and _TURNS_US[0] <= us <= _TURNS_US[1]):
            what = f"{_LOOP_US} is the time of a turn in us, above 0, and not {us!r}"
            yield Problem(
                file, each.value.lineno, each.value.col_offset + 1, what, f'write "{_LOOP_US} = 100"'
            )
