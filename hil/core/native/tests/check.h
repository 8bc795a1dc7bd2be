/* A test is a function; a failed check says where, is counted, and the test goes on. */
#ifndef HIL_TESTS_CHECK_H
#define HIL_TESTS_CHECK_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>

typedef struct check_counts {
    int passed, failed; /* tests */
    int wrong;          /* checks of the running test */
} check_counts;

extern check_counts check_state;

/* At most ten lines for a test, in case the check stands in a loop. */
#define CHECK_FAILED(...)                                             \
    do {                                                              \
        if (check_state.wrong++ < 10) {                               \
            fprintf(stderr, "%s:%d: ", __FILE__, __LINE__);           \
            fprintf(stderr, __VA_ARGS__);                             \
            fputc('\n', stderr);                                      \
        }                                                             \
    } while (0)

#define CHECK(condition)                                      \
    do {                                                      \
        if (!(condition)) CHECK_FAILED("not so: %s", #condition); \
    } while (0)

#define CHECK_INT(got, want)                                                                             \
    do {                                                                                                 \
        int64_t got_ = (got), want_ = (want);                                                            \
        if (got_ != want_)                                                                               \
            CHECK_FAILED("%s is %lld, not %s = %lld", #got, (long long)got_, #want, (long long)want_);   \
    } while (0)

#define CHECK_NEAR(got, want, tolerance)                                                       \
    do {                                                                                       \
        double got_ = (got), want_ = (want);                                                   \
        if (!(fabs(got_ - want_) <= (tolerance)))                                              \
            CHECK_FAILED("%s is %.17g, not %s = %.17g", #got, got_, #want, want_);             \
    } while (0)

#define RUN(test)                                                                  \
    do {                                                                           \
        check_state.wrong = 0;                                                     \
        test();                                                                    \
        if (check_state.wrong) {                                                   \
            check_state.failed++;                                                  \
            fprintf(stderr, "FAILED %s: %d checks\n", #test, check_state.wrong);   \
        } else                                                                     \
            check_state.passed++;                                                  \
    } while (0)

/* For main: says how many, and adds "passed failed" to the file that the Makefile sums. */
static inline int check_report(const char *what, const char *counts_path)
{
    printf("%s: %d passed, %d failed\n", what, check_state.passed, check_state.failed);
    FILE *f = counts_path ? fopen(counts_path, "a") : NULL;
    if (!f) return 1;
    fprintf(f, "%d %d\n", check_state.passed, check_state.failed);
    return fclose(f) != 0;
}

#endif
