/* What the tests with threads need: a thread, the time. */
#ifndef HIL_TESTS_THREADS_H
#define HIL_TESTS_THREADS_H

#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <time.h>

static inline int64_t wall_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static inline pthread_t spawn(void *(*run)(void *), void *argument)
{
    pthread_t thread;
    if (pthread_create(&thread, NULL, run, argument)) exit(2);
    return thread;
}

#endif
