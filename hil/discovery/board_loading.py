"""Import of a board's ``PROFILE``, with the place of whatever is wrong with it."""

import ast
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from functools import cache
from importlib import import_module, invalidate_caches
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec, spec_from_file_location
from traceback import extract_tb

from hil.discovery.board_places import PYTHON, YAML, BoardPlace
from hil.vocab.problem import ConfigError, Problem
from hil.vocab.profile import AxisSpec, Example, MemoryFile, Profile, UartSpec
from hil.vocab.verbs import COMMON, Verb

Place = tuple[int, int]
"""Line and column, from 1."""


class ProfileText:
    """Text of a module that defines ``PROFILE``, which Python has read already."""

    def __init__(self, text: bytes) -> None:
        self._tree = ast.parse(text)
        self._said: ast.expr | None = None
        for node in self._tree.body:
            targets = node.targets if isinstance(node, ast.Assign) else []
            targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
            if any(isinstance(target, ast.Name) and target.id == "PROFILE" for target in targets):
                self._said = node.value  # type: ignore[attr-defined]

    def at(self, part: str | None = None) -> Place:
        """Place of ``PROFILE``, or of a part of it; the first line where it is not written out."""
        node: ast.expr | None = self._said
        if part and isinstance(node, ast.Call):
            node = next((each.value for each in node.keywords if each.arg == part), node)
        return (node.lineno, node.col_offset + 1) if node else (1, 1)

    def twice(self) -> Iterator[tuple[str, Place]]:
        """Find keys that are twice in one written mapping: Python takes the last, and is silent."""
        for node in ast.walk(self._tree):
            keys = node.keys if isinstance(node, ast.Dict) else []
            seen: dict[str, int] = {}
            for key in filter(None, keys):
                name = ast.unparse(key)
                if name in seen:
                    message = f"{name} is given twice, first in line {seen[name]}"
                    yield message, (key.lineno, key.col_offset + 1)
                seen.setdefault(name, key.lineno)


Named = tuple[tuple[str, ...], tuple[str, ...]]
"""Names of a board's UARTs and axes by its ``profile.yaml``; None: that was not read."""
SAY_IT = "write PROFILE = Profile(firmware=...), of hil.vocab.profile"


class Boards(Mapping[str, Profile]):
    """Profiles of boards, from their ``board.py``, imported when one is asked for. ``parts``: answers the
    names of a board's UARTs and axes by its ``profile.yaml``. ``usual``: answers the profile of a board that
    needs no ``board.py``; None: it needs one.

    Raises:
        KeyError: there is no such board.
        ConfigError: it cannot be used, with its problems.
    """

    def __init__(
        self,
        places: Mapping[str, BoardPlace],
        names: Collection[str],
        parts: Callable[[str], Named | None] = lambda name: None,
        usual: Callable[[str], Profile | None] = lambda name: None,
    ) -> None:
        self._places, self._names, self._parts, self._usual = places, names, parts, usual

    def __getitem__(self, name: str) -> Profile:
        if not (self._places[name].folder / PYTHON).exists() and (profile := self._usual(name)):
            return profile
        return _load(self._places[name], self._parts(name))

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


@cache
def _load(place: BoardPlace, named: Named | None) -> Profile:
    if not (place.folder / PYTHON).exists():
        raise ConfigError([place.problem(PYTHON, "this file is missing", SAY_IT)])
    said = _imported(place)
    text = ProfileText((place.folder / PYTHON).read_bytes())
    if not isinstance(said, Profile):
        what = (
            "there is no PROFILE here"
            if said is None
            else f"PROFILE is no Profile, but a {type(said).__name__}"
        )
        raise ConfigError([place.problem(PYTHON, what, SAY_IT, *text.at())])
    problems = [
        place.problem(PYTHON, f"{part}: {message}", remedy, *text.at(part))
        for part, message, remedy in (*_wrong_types(said), *_wrong_names(said, named))
    ]
    problems += [place.problem(PYTHON, message, "keep one of the two", *at) for message, at in text.twice()]
    if problems:
        raise ConfigError(problems)
    return said


def _imported(place: BoardPlace) -> object:
    """Import ``PROFILE``, None where there is none."""
    invalidate_caches()  # the folder may be younger than the import system's cache
    try:
        _make_package(place)
        return getattr(import_module(f"{place.package}.board"), "PROFILE", None)
    except (Exception, SystemExit) as error:
        for name in [each for each in sys.modules if each.startswith(f"{place.package}.")]:
            del sys.modules[name]  # so that a repaired board is imported again
        raise ConfigError([_import_problem(place, error)]) from None


def _make_package(place: BoardPlace) -> None:
    """Let a folder that is in no package be imported as one."""
    if place.package in sys.modules or not place.package.startswith("board_"):
        return
    init = place.folder / "__init__.py"
    spec = spec_from_file_location(place.package, init) if init.exists() else None
    spec = spec or ModuleSpec(place.package, None, is_package=True)
    spec.submodule_search_locations = [str(place.folder)]
    package = sys.modules[place.package] = module_from_spec(spec)
    try:
        if spec.loader and init.exists():
            spec.loader.exec_module(package)
    except BaseException:
        del sys.modules[place.package]
        raise


def _import_problem(place: BoardPlace, error: BaseException) -> Problem:
    """Say what an import raised, at the line of the board's own that raised it."""
    file, line, column = str(place.folder / PYTHON), 1, 1
    for frame in extract_tb(error.__traceback__):
        if frame.filename.startswith(f"{place.folder}/"):
            file, line, column = frame.filename, frame.lineno or 1, (frame.colno or 0) + 1
    if isinstance(error, SyntaxError) and error.filename:
        file, line, column = error.filename, error.lineno or 1, error.offset or 1
    remedy = "mend this line"
    if isinstance(error, ModuleNotFoundError) and error.name:
        remedy = f"install {error.name.partition('.')[0]}, or correct the name"
        if error.name.partition(".")[0] in (place.name, place.folder.name):
            remedy = "modules of the board's own folder are imported with a dot: from .firmware import ..."
    said = " ".join(str(error).replace(f"{place.package}.", ".").split())
    return Problem(file, line, column, f"{type(error).__name__}: {said}", remedy)


def _wrong_types(profile: Profile) -> Iterator[tuple[str, str, str]]:
    for part, wanted, is_good in (
        (
            "firmware",
            "a class or a function that takes a Board",
            profile.firmware is None or callable(profile.firmware),
        ),
        ("uarts", "a mapping of names to UartSpec", _maps(profile.uarts, UartSpec)),
        ("axes", "a mapping of names to AxisSpec", _maps(profile.axes, AxisSpec)),
        ("verbs", "a tuple of Verb", _holds(profile.verbs, Verb)),
        ("starve", "a function", profile.starve is None or callable(profile.starve)),
        ("follow", "a function", profile.follow is None or callable(profile.follow)),
        ("dialogues", "a mapping of verbs' names to functions", _maps_to_calls(profile.dialogues)),
        ("readers", "a mapping of names to functions", _maps_to_calls(profile.readers)),
        ("terminal_axis", "a class", profile.terminal_axis is None or callable(profile.terminal_axis)),
        ("shown_first", "a tuple of fields' names", _holds(profile.shown_first, str)),
        ("examples", "a tuple of Example with bytes", _are_examples(profile.examples)),
        ("memory_file", "a MemoryFile", isinstance(profile.memory_file, MemoryFile | None)),
        ("commands", "a function", profile.commands is None or callable(profile.commands)),
    ):
        if not is_good:
            given = type(getattr(profile, part)).__name__
            yield part, f"{wanted} is wanted here, not this {given}", f"write {wanted}"


def _wrong_names(profile: Profile, named: Named | None) -> Iterator[tuple[str, str, str]]:
    for part, here, there in zip(("uarts", "axes"), (profile.uarts, profile.axes), named or (), strict=False):
        if isinstance(here, Mapping) and set(here) != set(there):
            these, those = (", ".join(map(str, names)) or "none" for names in (here, there))
            remedy = "write the same names in both" + ', and "{}" for none' * (part == "uarts" and not here)
            yield part, f"these are {these}, and those of {YAML} {those}", remedy
    if profile.uarts == {}:
        yield from _without_terminal(profile)
    if _maps(profile.uarts, UartSpec) and _are_examples(profile.examples):
        known = ", ".join(profile.uarts) or "none"
        for example in profile.examples:
            if (example.uart or next(iter(profile.uarts), "")) not in profile.uarts:
                yield "examples", f'there is no serial interface "{example.uart}"', f"write one of {known}"
    if not _holds(profile.verbs, Verb) or not _maps_to_calls(profile.dialogues):
        return
    names = [verb.name for verb in (*COMMON, *profile.verbs)]
    for name in sorted({each for each in names if names.count(each) > 1}):
        yield "verbs", f'there are two verbs "{name}"', "give one of them another name"
    for name in profile.dialogues:
        if name not in names:
            yield "dialogues", f'there is no verb "{name}"', f"write one of {', '.join(sorted(names))}"


def _without_terminal(profile: Profile) -> Iterator[tuple[str, str, str]]:
    """Parts that type at a terminal, of a board that has no UART."""
    if _holds(profile.verbs, Verb) and any(verb.types for verb in profile.verbs):
        yield "verbs", "there is no UART at which one could type", "give the verb a run instead"
    for part in ("dialogues", "terminal_axis", "commands"):
        if getattr(profile, part):
            yield part, "there is no UART at which one could type", "leave it out"


def _holds(value: object, kind: type) -> bool:
    return isinstance(value, tuple) and all(isinstance(each, kind) for each in value)


def _are_examples(value: object) -> bool:
    return (
        isinstance(value, tuple)
        and _holds(value, Example)
        and _holds(tuple(part for each in value for part in (each.types, each.answer)), bytes)
    )


def _maps(value: object, kind: type) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and isinstance(each, kind) for name, each in value.items()
    )


def _maps_to_calls(value: object) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and callable(each) for name, each in value.items()
    )
