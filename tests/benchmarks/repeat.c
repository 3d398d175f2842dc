/* Calls the driver as a sweep in compiled code would: nothing of Python between two motions. */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef int64_t Driver(int64_t frame, double until, double interval, bool measuring);

/* Runs a motion from what its frame held at the beginning, so many times; why the last stopped. */
int64_t repeat(Driver *driver, int64_t *frame, const int64_t *begun, int64_t words, double until,
               int64_t times) {
    int64_t stop = 0;
    while (times--) {
        memcpy(frame, begun, words * sizeof *frame);
        stop = driver((int64_t)frame, until, 0, false);
    }
    return stop;
}
