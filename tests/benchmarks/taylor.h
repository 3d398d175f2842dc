/* What the programs of the Taylor benchmark share: series of a fixed ORDER (-DORDER=K), steps as
 * long as their last terms allow, first roots that are bounded before they are sought, a main. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define EACH_ORDER _Pragma("GCC unroll 32")
enum { DEEPEST = 50 };
static const double NO_ROOT = 2, ROUNDING = 2e-15, NARROW = 1e-7, LAST = 1e-12;

typedef double Series[ORDER + 1];
static Series OVER, BINOMIAL; /* 1 / k, and 1 over the binomial coefficients of ORDER */

/* Even and odd powers apart: two short chains of operations instead of a long one. */
static inline double value(const Series p, double x) {
    double even = p[ORDER - ORDER % 2], odd = p[ORDER - 1 + ORDER % 2], square = x * x;
    EACH_ORDER for (int k = ORDER - ORDER % 2 - 2; k >= 0; k -= 2) even = even * square + p[k];
    EACH_ORDER for (int k = ORDER - 3 + ORDER % 2; k > 0; k -= 2) odd = odd * square + p[k];
    return even + x * odd;
}

static inline double slope(const Series p, double x) {
    double sum = ORDER * p[ORDER];
    EACH_ORDER for (int k = ORDER - 1; k > 0; k--) sum = sum * x + k * p[k];
    return sum;
}

/* The root of p on [low, high], where it falls from positive to negative, from x on. */
static double newton(const Series p, double low, double high, double x) {
    for (int i = 0; i < 100; i++) {
        double here = value(p, x), next = x - here / slope(p, x);
        *(here > 0 ? &low : &high) = x;
        if (!(low < next && next < high)) next = (low + high) / 2;
        if (fabs(next - x) <= LAST || !(low < next && next < high)) return next;
        x = next;
    }
    return x;
}

/* First root on [low, high] of what has these Bernstein coefficients there, halved until they
 * change sign once. */
static double bounded(const Series p, Series b, double low, double high, double small, int depth) {
    int changes = 0, place = 0, touches = 0;
    for (int j = 1, negative = 0; j <= ORDER; j++) {
        touches |= b[j] <= small;
        if (negative ? b[j] > small : b[j] < -small) {
            changes++, negative = !negative;
            if (!place) place = j;
        }
    }
    if (!changes && !touches) return NO_ROOT;
    if (changes == 1) {
        double part = (place - 1 + b[place - 1] / (b[place - 1] - b[place])) / ORDER;
        return newton(p, low, high, low + (high - low) * part);
    }
    double middle = (low + high) / 2;
    if (high - low < NARROW || depth == DEEPEST)
        return changes || value(p, middle) <= small ? middle : NO_ROOT;
    Series left;
    for (int j = 0; j <= ORDER; j++) {
        left[j] = b[0];
        for (int i = 0; i < ORDER - j; i++) b[i] = (b[i] + b[i + 1]) / 2;
    }
    double root = bounded(p, left, low, middle, small, depth + 1);
    return root == NO_ROOT ? bounded(p, b, middle, high, small, depth + 1) : root;
}

/* First root of a function over a step, as a fraction of it; its first `zero` terms are known to
 * be zero. It is positive before. */
static inline double first_root(const Series function, double step, int zero) {
    Series p = {0}, b;
    double power = 1, total = 0, end = 0;
    for (int k = 0; k <= ORDER - zero; k++, power *= step) {
        p[k] = function[k + zero] * power;
        total += fabs(p[k]);
        end += p[k];
    }
    double small = ROUNDING * total, rest = (total - end) / 2 + fmin(p[1], 0);
    if (p[0] <= 0) return 0;
    if (p[0] + p[1] - rest > small) return NO_ROOT;
    EACH_ORDER for (int k = 0; k <= ORDER; k++) b[k] = p[k] * BINOMIAL[k];
    EACH_ORDER for (int row = 1; row <= ORDER; row++)
        EACH_ORDER for (int j = ORDER; j >= row; j--) b[j] += b[j - 1];
    return bounded(p, b, 0, 1, small, 0);
}

/* Coefficient k of a product. */
static inline double product(const Series p, const Series q, int k) {
    double sum = p[0] * q[k];
    EACH_ORDER for (int j = 1; j <= k; j++) sum += p[j] * q[k - j];
    return sum;
}

/* Step over which the last two terms of all series stay below rtol times their own scales. */
static inline double step_of(const Series *all, int count, double rtol, double last) {
    double worst = 0, before = 0, wanted = log2(rtol);
    for (int i = 0; i < count; i++) {
        const double *p = all[i];
        double scale = fmax(fabs(p[0]), fmax(fabs(p[1]) * last, fabs(p[2]) * last * last));
        if (scale == 0) continue;
        worst = fmax(worst, fabs(p[ORDER]) / scale);
        before = fmax(before, fabs(p[ORDER - 1]) / scale);
    }
    return exp2(fmin((wanted - log2(worst)) / ORDER, (wanted - log2(before)) / (ORDER - 1)));
}

/* A run at a parameter; prints the states at slip->stick and the last where asked to. */
static double run(double parameter, double until, double rtol, int prints);

/* PROGRAM RTOL SECONDS points VALUE        the states at slip->stick, then the last
 * PROGRAM RTOL SECONDS REPEATS VALUE...    processor time of a run, s */
int main(int count, char **given) {
    double rtol = atof(given[1]), until = atof(given[2]), sum = 0;
    BINOMIAL[0] = 1;
    for (int k = 1; k <= ORDER; k++) {
        OVER[k] = 1.0 / k;
        BINOMIAL[k] = BINOMIAL[k - 1] * k / (ORDER + 1 - k);
    }
    if (!strcmp(given[3], "points")) return run(atof(given[4]), until, rtol, 1) != 0;
    int repeats = atoi(given[3]);
    clock_t begun = clock();
    for (int i = 0; i < repeats; i++)
        for (int j = 4; j < count; j++) sum += run(atof(given[j]), until, rtol, 0);
    double taken = (double)(clock() - begun) / CLOCKS_PER_SEC;
    return printf("%.9g %g\n", taken / repeats / (count - 4), sum) < 0;
}
