/* Runs the tests of every file that the Makefile has found. */
#include "check.h"

check_counts check_state;

#define SUITE(name) void name##_tests(void);
#include "suites.def"
#undef SUITE

int main(int argc, char **argv)
{
#define SUITE(name) name##_tests();
#include "suites.def"
#undef SUITE
    return check_report("unit", argc > 1 ? argv[1] : NULL);
}
