"""Checks of the C++ that is made of a sketch's text."""

import pytest

from hil.toolchain.ino_source import cpp_text, lines_of, preprocessed_lines, prototypes_of

SKETCH = """// a comment with f() {
#define X 3
const char text[] = "void no() {";
struct Point { int x; void move() { x++; } };
Point p = {1};

void setup() {
  later(3);
}

// above
unsigned long
later(int a, int b = 3) { if (a) { while (b) {} } return a; }
ISR(TIMER1_COMPA_vect) { }
template <typename T> T twice(T a) { return a + a; }
static inline Point* find(const Point &of, int (&rows)[4], char c = '}') { return 0; }
int Point::far() { return 1; }
namespace inside { void hidden() {} }
bool operator==(const Point &a, const Point &b) { return true; }
int declared(int a);
int declared(int a) { return a; }
void loop() {}
"""


def texts(source: str) -> list[str]:
    return [each.text for each in prototypes_of(lines_of([("a.ino", source)]))]


def test_functions_of_a_sketch_get_prototypes() -> None:
    assert texts(SKETCH) == [
        "void setup();",
        "unsigned long later(int a, int b = 3);",
        "template <typename T> T twice(T a);",
        "static inline Point* find(const Point &of, int (&rows)[4], char c = '}');",
        "void loop();",
    ]


@pytest.mark.parametrize(
    "source",
    [
        "int table[] = {1, 2};",
        "class A { A() {} void f() {} };",
        "enum { ONE, TWO };",
        "auto f = [](int a) { return a; };",
        "/* void f() { } */",
        "void f(void);\nvoid f() {}",
        'extern "C" { void f() {} }',
        'extern "C" void f() {}',
        "const long_name " * 2000 + "table[] PROGMEM = {1}; class A {};",
    ],
)
def test_what_is_no_function_of_its_own_gets_none(source: str) -> None:
    assert texts(source) == []


def test_a_brace_in_a_default_argument_ends_no_header() -> None:
    assert texts("void f(Point p = Point{1, 2}) {}\nvoid g() {}") == [
        "void f(Point p = Point{1, 2});",
        "void g();",
    ]


def test_each_line_keeps_its_file_and_number() -> None:
    lines = lines_of([("/s/a.ino", "int x;\nvoid loop() {}"), ("/s/b.ino", "void more() {}")])
    assert cpp_text(lines, prototypes_of(lines)).splitlines() == [
        "#include <Arduino.h>",
        '#line 1 "/s/a.ino"',
        "int x;",
        '#line 2 "/s/a.ino"',
        "void loop();",
        '#line 1 "/s/b.ino"',
        "void more();",
        '#line 2 "/s/a.ino"',
        "void loop() {}",
        '#line 1 "/s/b.ino"',
        "void more() {}",
    ]


def test_a_sketch_without_functions_has_no_prototypes() -> None:
    assert cpp_text(lines_of([("a.ino", "int x;")])) == '#include <Arduino.h>\n#line 1 "a.ino"\nint x;\n'


def test_what_the_preprocessor_left_out_is_not_seen() -> None:
    text = '# 1 "/c/Arduino.h" 1\nvoid core() {}\n# 3 "/s/a \\"b\\".ino" 2\nint x;\n\nvoid f() {}\n'
    lines = preprocessed_lines(text, ['/s/a "b".ino'])
    assert [(line.number, line.text) for line in lines[:3]] == [(3, "int x;"), (4, ""), (5, "void f() {}")]
    assert [each.text for each in prototypes_of(lines)] == ["void f();"]
