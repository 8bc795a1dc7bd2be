"""Checks that the native sources are layers.

A module is a ``.c`` with its ``.h``. It depends on another one when it includes its header or calls its
functions. No module may depend on itself by way of others. A header declares what its own ``.c`` defines;
only ``hil_core.h``, the public one, declares for all.

The core's own modules have an order, too: none includes or calls what stands above it in ``ORDER``.
"""

import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path, PurePosixPath

import pytest

ROOT = Path(__file__).parents[3]
PUBLIC = "hil/core/native/hil_core"
CORE = "hil/core/native/"
ORDER = (
    "abi fields types cells",
    "mcu/avr/",  # a processor knows nothing but itself
    "motion/ plant/ control/ encoder source follow outputs extremes watch hil_core",  # they know no axis
    "rt/ring rt/seqlock",
    "state",
    "core",
    "shaft",
    "law",
    "law/",
    "laws pins magnet view switches processor rt/lock replay joint_replay rt/watchdog",
    "axis",
    "group fault",
    "lanes batch batch_any batch_avx2 batch_avx512 batch_lanes",
    "rt/thread",
    "arena",
)
"""Modules and folders of modules of the core, the lowest first; those of one row are equals."""
APART = ("law/", "motion/"), "rt/"
"""Folders that know nothing of threads, and the folder that does, what it has below them too."""
INCLUDE = re.compile(r'^#\s*include "([^"]+)"', re.M)
NOT_CODE = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"', re.S)
HEAD = r"^(?!static\b|INLINE\b|typedef\b)[A-Za-z_][\w \t*]*?\b([a-z]\w*)\([^;{}]*\)"
DEFINITION = re.compile(HEAD + r"\s*\{", re.M)
DECLARATION = re.compile(HEAD + r";", re.M)

Sources = dict[str, str]
"""Text by path below the project."""
Graph = dict[str, set[str]]
"""Modules that each module depends on."""


def native_folders() -> list[Path]:
    """Folders ``native`` of the project: all that have C of their own."""
    tops = [init.parent for init in ROOT.glob("*/__init__.py")]
    return sorted(folder for top in tops for folder in top.rglob("native") if folder.is_dir())


def native_sources() -> Sources:
    files = [file for folder in native_folders() for file in folder.rglob("*.*")]
    kept = [file for file in files if file.suffix in {".c", ".h", ".def"} and "tests" not in file.parts]
    return {file.relative_to(ROOT).as_posix(): file.read_text() for file in kept}


def module_of(path: str) -> str:
    return str(PurePosixPath(path).with_suffix(""))


def includes(sources: Sources) -> Graph:
    """Includes of each module, resolved as the compiler does it: beside the file, then in the folder
    ``native``, which ``-I`` names."""
    graph: Graph = {module_of(path): set() for path in sources}
    for path, text in sources.items():
        folder = (ROOT / path).parent
        roots = (folder, ROOT / path[: path.index("/native/")] / "native")
        for name in INCLUDE.findall(text):
            found = [(root / name).resolve().relative_to(ROOT.resolve()).as_posix() for root in roots]
            graph[module_of(path)] |= {next(module_of(file) for file in found if file in sources)}
    return without_itself(graph)


def tables_of(path: str, text: str) -> set[str]:
    return {str(PurePosixPath(path).parent / name) for name in INCLUDE.findall(text) if name.endswith(".def")}


def calls(sources: Sources) -> Graph:
    """Dependencies by the names of functions, pointers to functions too. A static function needs no edge: its
    callers include it.

    Calls in the expressions of a table (``.def``) are those of the ``.c`` that includes it; headers use its
    names alone.
    """
    code = {path: NOT_CODE.sub("", text) for path, text in sources.items() if not path.endswith(".def")}
    for path in code:
        for table in tables_of(path, sources[path]) if path.endswith(".c") else ():
            code[path] += NOT_CODE.sub("", sources[table])
    home = {name: module_of(path) for path, text in code.items() for name in DEFINITION.findall(text)}
    graph: Graph = {module_of(path): set() for path in sources}
    for path, text in code.items():
        words = set(re.findall(r"\w+", DECLARATION.sub("", text)))
        graph[module_of(path)] |= {home[word] for word in words & home.keys()}
    return without_itself(graph)


def without_itself(graph: Graph) -> Graph:
    return {module: others - {module} for module, others in graph.items()}


def circle(*graphs: Graph) -> list[str]:
    """The modules of a circle in the graphs taken together, in order; [] when there is none."""
    whole = {module: set().union(*(graph[module] for graph in graphs)) for module in graphs[0]}
    try:
        TopologicalSorter(whole).prepare()
    except CycleError as error:
        return list(reversed(error.args[1]))
    return []


def rank(module: str) -> int:
    """Row of ``ORDER`` that a module of the core is in: its own, else that of its folder."""
    rows = {each: number for number, row in enumerate(ORDER) for each in row.split()}
    return rows[module] if module in rows else rows[module.rpartition("/")[0] + "/"]


def climbs(*graphs: Graph) -> list[str]:
    """Dependencies of the core's modules on modules that stand above them, or that they are apart from."""
    edges = {(module, other) for graph in graphs for module, others in graph.items() for other in others}
    core = [[name.removeprefix(CORE) for name in edge] for edge in edges if edge[0].startswith(CORE)]
    found = [
        f"{module} -> {other}"
        for module, other in core
        if rank(other) > rank(module) or (module.startswith(APART[0]) and other.startswith(APART[1]))
    ]
    return sorted(found)


def strangers(sources: Sources) -> list[str]:
    """Functions that headers declare and their own module does not define."""
    code = {path: NOT_CODE.sub("", text) for path, text in sources.items()}
    found = []
    for path, text in code.items():
        if not path.endswith(".h") or module_of(path) == PUBLIC:
            continue
        own = set(DEFINITION.findall(code.get(module_of(path) + ".c", "")))
        found += [f"{path}: {name}" for name in DECLARATION.findall(text) if name not in own]
    return found


def test_no_circle_of_includes_or_calls() -> None:
    sources = native_sources()
    assert circle(includes(sources), calls(sources)) == []


def test_a_header_declares_its_own_functions() -> None:
    assert strangers(native_sources()) == []


def test_the_sources_are_read() -> None:
    sources = native_sources()
    functions = [name for text in sources.values() for name in DEFINITION.findall(NOT_CODE.sub("", text))]
    assert len(functions) == len(set(functions)), "a name is defined twice"
    declared = DECLARATION.findall(NOT_CODE.sub("", sources[PUBLIC + ".h"]))
    assert len(declared) >= 60
    assert set(declared) <= set(functions)


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("hil/core/native/encoder.h", '#include "axis.h"'),
        ("hil/core/native/law/servo.c", "static void ahead(hil_core *c) { hil_group_advance(c, 0, 0); }"),
        ("hil/core/native/law/stepper.c", "static void *const next = axis_advance;"),
        ("hil/core/native/motion/profile.c", "static int run(motion *m) { return motion_run(m); }"),
        ("bridges/can/bus/native/can_odd.c", "static void again(can_wire *w) { can_tick(w, 0); }"),
    ],
)
def test_a_planted_circle_is_found(file: str, line: str) -> None:
    sources = native_sources()
    sources[file] += line
    assert module_of(file) in circle(includes(sources), calls(sources))


def test_the_core_goes_by_its_order() -> None:
    sources = native_sources()
    assert climbs(includes(sources), calls(sources)) == []


@pytest.mark.parametrize(
    ("file", "line", "climb"),
    [
        ("law/servo.c", '#include "../rt/lock.h"', "law/servo -> rt/lock"),
        ("law/stepper.h", '#include "../rt/ring.h"', "law/stepper -> rt/ring"),
        ("motion/queue.c", '#include "../rt/ring.h"', "motion/queue -> rt/ring"),
        ("plant/full.h", '#include "../law.h"', "plant/full -> law"),
        ("law/walter.c", "static void *const look = view_publish;", "law/walter -> view"),
    ],
)
def test_a_planted_climb_is_found(file: str, line: str, climb: str) -> None:
    sources = native_sources()
    sources[CORE + file] += line
    assert climbs(includes(sources), calls(sources)) == [climb]


def test_a_planted_declaration_is_found() -> None:
    sources = native_sources()
    sources["hil/core/native/core.h"] += "int axis_is_idle(const hil_axis *a);\n"
    assert strangers(sources) == ["hil/core/native/core.h: axis_is_idle"]
