"""Types of contracts for ``lint-imports`` (``[tool.importlinter]`` in pyproject.toml).

Grimp, on which import-linter stands, sees neither compiled modules nor the tests, whose folders are no
packages. Both contracts look at its graph with these added.
"""

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache, cached_property
from graphlib import CycleError, TopologicalSorter
from importlib.util import find_spec, resolve_name
from pathlib import Path
from typing import Any

from grimp import ImportGraph
from importlinter import Contract, ContractCheck, fields, output

MAY, EACH_MAY, TESTS_MAY = "May import", "Each may import", "Tests may import too"
_SIGN = re.compile(rf"(?:\A|\n\s*\n)\s*({MAY}|{EACH_MAY}|{TESTS_MAY}): (.*?)\.?\s*(?=\n\s*\n|\Z)", re.DOTALL)
PURE, STANDARD, ANY = "the pure standard library", "the standard library", "any package"
_TESTS = "tests"


@cache
def signs_in(text: str) -> dict[str, frozenset[str]]:
    """White lists in a module's docstring: paragraphs such as ``May import: hil.vocab, hil.wire.``"""
    docstring = ast.get_docstring(ast.parse(text)) or ""
    return {kind: frozenset(re.split(r",\s+", names)) for kind, names in _SIGN.findall(docstring)}


@cache
def imports_in(text: str) -> list[str]:
    """Names of the modules that a text imports, anywhere in it; what is relative begins with its dots."""
    names: list[str] = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names += (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = "." * node.level + (f"{node.module}." if node.module else "")
            names += (base + alias.name for alias in node.names)
    return names


_C = {"libc", "cpython", "cython"}
_OF_C = {"libc.time": "time"}
"""Python's modules for what C has and the pure standard library has not, by the names in C."""
_CYTHON = re.compile(r"^[ \t]*(?:from\s+([\w.]+)\s+c?import\s|c?import\s+([\w., \t]+))", re.M)


@cache
def cython_imports_in(text: str) -> list[str]:
    """Names of the modules that Cython's source imports or takes declarations from, without C's own."""
    found = (one or many for one, many in _CYTHON.findall(text))
    names = (name.split()[0] for group in found for name in group.split(",") if name.strip())
    return [_OF_C.get(name, name) for name in names if _root(name) not in _C or name in _OF_C]


def is_within(module: str, package: str) -> bool:
    """True if a module is a package or anything in it."""
    return module == package or module.startswith(f"{package}.")


class House:
    """Source files of the root packages, by the names of their modules, and what grimp's graph lacks."""

    def __init__(self, roots: list[str]) -> None:
        self.roots = roots
        self.files: dict[str, Path] = {}
        for root in roots:
            spec = find_spec(root)
            assert spec is not None, f"{root} cannot be imported"
            assert spec.origin is not None, f"{root} has no __init__.py"
            folder = Path(spec.origin).parent
            for path in sorted([*folder.rglob("*.pyi"), *folder.rglob("*.py")]):  # a .py wins
                name = ".".join((root, *path.relative_to(folder).with_suffix("").parts))
                self.files[name.removesuffix(".__init__")] = path

    def is_test(self, module: str) -> bool:
        return _TESTS in module.split(".")

    def complete(self, graph: ImportGraph) -> list[str]:
        """Add compiled modules and tests with their imports. Answers modules that are in no package."""
        known = graph.modules
        unseen = [name for name in self.files if name not in known]
        compiled = {name for name in unseen if self.files[name].suffix == ".pyi"}
        added = compiled | set(filter(self.is_test, unseen))
        for name in added:
            graph.add_module(name)
        known |= added
        importers = set(added)
        # Grimp takes the import of a compiled module for one of a package above it.
        for package in {*self.roots, *(name.rpartition(".")[0] for name in compiled)}:
            for importer in graph.find_modules_that_directly_import(package):
                graph.remove_import(importer=importer, imported=package)
                importers.add(importer)
        for importer in importers:
            for imported in self.imports(importer):
                if _root(imported) in self.roots:
                    graph.add_import(importer=importer, imported=_longest(imported, known))
        for importer in compiled:
            for imported in {_root(name) for name in self._cython_imports(importer)} - set(self.roots):
                graph.add_module(imported, is_squashed=True)
                graph.add_import(importer=importer, imported=imported)
        return [name for name in unseen if name not in added]

    def imports(self, module: str) -> Iterator[str]:
        """Names that a module imports, with that of the module they are from before them."""
        path = self.files[module]
        package = module if path.stem == "__init__" else module.rpartition(".")[0]
        names = [*imports_in(path.read_text()), *self._cython_imports(module)]
        return (resolve_name(name, package) for name in names)

    def _cython_imports(self, module: str) -> list[str]:
        """Modules that a compiled module's source imports; declarations of C (``.pxd``) are none."""
        source = self.files[module].with_suffix(".pyx")
        names = cython_imports_in(source.read_text()) if source.exists() else []
        beside = {f"{module.rpartition('.')[0]}.{path.stem}" for path in source.parent.glob("*.pxd")}
        return [name for name in names if name not in beside]


class _HouseContract(Contract):
    """Contract that finds ``problems``, a line each, in the whole graph."""

    @cached_property
    def house(self) -> House:
        return House(self.session_options["root_packages"])

    def problems(self, graph: ImportGraph) -> Iterator[str]:
        raise NotImplementedError

    def check(self, graph: ImportGraph, verbose: bool) -> ContractCheck:
        problems = [f"{name} is in a folder without __init__.py" for name in self.house.complete(graph)]
        problems += sorted(self.problems(graph))
        return ContractCheck(kept=not problems, metadata={"problems": problems})

    def render_broken_contract(self, check: ContractCheck) -> None:
        for problem in check.metadata["problems"]:
            output.print_error(f"- {problem}")
        output.new_line()


class Signs(_HouseContract):
    """Contract: each module imports what the signs on the doors that it is behind allow, and its own folder.

    A sign is a paragraph in the docstring of a package, or of a module directly in a root: ``May import:``
    and names of modules, ``the standard library``, ``the pure standard library`` (the modules in ``pure``) or
    ``any package``. ``Each may import:`` on a root is the sign of each folder in it that has none of its own.
    ``Tests may import too:`` widens both for the tests behind it; what is not of the project they may import
    anyway.
    """

    pure: Any = fields.SetField(subfield=fields.StringField())

    def problems(self, graph: ImportGraph) -> Iterator[str]:
        signs = self._signs()
        yield from self._misplaced(signs, graph.modules)
        yield from self._circle_of(signs)
        for module in graph.modules:
            if _root(module) in self.house.roots:
                for imported in graph.find_modules_directly_imported_by(module):
                    yield from self._forbidden(module, imported, signs)

    def _signs(self) -> dict[str, dict[str, frozenset[str]]]:
        doors = [
            name
            for name, path in self.house.files.items()
            if not self.house.is_test(name) and (path.stem == "__init__" or name.count(".") == 1)
        ]
        return {door: signs_in(self.house.files[door].read_text()) for door in doors}

    def _misplaced(self, signs: dict[str, dict[str, frozenset[str]]], known: set[str]) -> Iterator[str]:
        for door, sign in signs.items():
            root, _, rest = door.partition(".")
            if rest and "." not in rest and MAY not in sign and EACH_MAY not in signs[root]:
                yield f"{door} has no sign: write what it may import into its docstring"
            for name in frozenset().union(*sign.values()):
                if _root(name) in self.house.roots and name not in known:
                    yield f"the sign of {door} allows {name}, which does not exist"

    def _circle_of(self, signs: dict[str, dict[str, frozenset[str]]]) -> Iterator[str]:
        rooms: dict[str, set[str]] = {}
        for door, sign in signs.items():
            here = _room_of(door, signs)
            allowed = {_room_of(name, signs) for name in sign.get(MAY, ()) if _root(name) in self.house.roots}
            rooms.setdefault(here, set()).update(allowed - {here})
        try:
            TopologicalSorter(rooms).prepare()
        except CycleError as error:
            yield f"signs allow a circle: {' -> '.join(reversed(error.args[1]))}"

    def _forbidden(
        self, module: str, imported: str, signs: dict[str, dict[str, frozenset[str]]]
    ) -> Iterator[str]:
        parts = module.split(".")
        doors = [".".join(parts[:end]) for end in range(1, len(parts) + 1)]
        if len(doors) == 1:
            yield f"{module} imports {imported}: a root imports nothing"
            return
        if imported == doors[0]:
            return  # it has nothing but its sign
        own = signs.get(doors[1], {})
        rules = [] if MAY in own else [(doors[1], signs[doors[0]].get(EACH_MAY))]
        rules += [(door, signs[door].get(MAY)) for door in doors if door in signs]
        too: frozenset[str] = frozenset()
        if self.house.is_test(module):
            if _root(imported) not in self.house.roots:
                return
            too = too.union(*(signs[door].get(TESTS_MAY, ()) for door in doors if door in signs))
        for door, allowed in rules:
            if allowed is None or is_within(imported, door):
                continue
            if not any(self._allows(name, imported) for name in allowed | too):
                yield f"{module} imports {imported}, which the sign for {door} does not name"

    def _allows(self, name: str, imported: str) -> bool:
        if name == PURE:
            return imported in self.pure
        if name == STANDARD:
            return imported in sys.stdlib_module_names
        if name == ANY:
            return _root(imported) not in self.house.roots
        return is_within(imported, name)


class PrivateNames(_HouseContract):
    """Contract: what begins with ``_`` is imported in its own room alone. A compiled module has such a name,
    and is no private one."""

    def problems(self, graph: ImportGraph) -> Iterator[str]:
        for module in self.house.files:
            for name in self.house.imports(module):
                if _root(name) in self.house.roots and _room(name) != _room(module):
                    inside = name.removeprefix(_longest(name, graph.modules)).removeprefix(".")
                    if inside.startswith("_") and not inside.startswith("__"):
                        yield f"{module} imports {name}, which is private to {_room(name)}"


class NoCircles(_HouseContract):
    """Contract: no module imports itself by way of others, also for types alone."""

    def problems(self, graph: ImportGraph) -> Iterator[str]:
        left = graph.modules & self.house.files.keys()
        while left:
            module = left.pop()
            circle = graph.find_upstream_modules(module) & graph.find_downstream_modules(module)
            left -= circle
            if circle:
                yield f"these import each other: {', '.join(sorted({module, *circle}))}"


def _longest(name: str, known: set[str]) -> str:
    """Longest known name that a name begins with: the module itself, or the one that defines it."""
    while name not in known:
        name = name.rpartition(".")[0]
    return name


def _root(module: str) -> str:
    return module.partition(".")[0]


def _room_of(name: str, signs: dict[str, dict[str, frozenset[str]]]) -> str:
    """Room of a circle: of a bridge, whose folder has a whole protocol's world, the signed folder in it."""
    inner = [door for door in signs if MAY in signs[door] and is_within(name, door)]
    return max(inner, key=len) if _root(name) == "bridges" and inner else _room(name)


def _room(module: str) -> str:
    return ".".join(module.split(".")[:2])
