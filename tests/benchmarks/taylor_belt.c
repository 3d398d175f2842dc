/* The base-excited belt as a careful engineer writes it in C; nothing of fiv is used.
 *
 * m x'' = -k (x - u0 cos(omega t)) + sign mu_k N, the belt at v; m = k = v = 1, N = 10,
 * mu_s = 0.4, mu_k = 0.23, u0 = 0.5; start: at rest at zero. The parameter is omega. */
#include "taylor.h"

static const double BELT = 1, KINETIC = 2.3, STATIC = 4, U0 = 0.5;

typedef struct {
    double time, x, v, omega, last; /* last: length of the last step */
    int sign;                       /* of the slip velocity, belt less mass; 0: sticking */
    int zero;                       /* 1: the slip velocity is zero at the start of the step */
} Mass;

static inline void excitation(const Mass *mass, Series drive) {
    double even = U0 * cos(mass->omega * mass->time), odd = -U0 * sin(mass->omega * mass->time);
    drive[0] = even;
    EACH_ORDER for (int k = 1; k <= ORDER; k++) {
        double rate = mass->omega * OVER[k], next = odd * rate;
        odd = -even * rate;
        drive[k] = even = next;
    }
}

static inline void slip(const Mass *mass, Series *y, Series gap) {
    Series drive;
    excitation(mass, drive);
    drive[0] += mass->sign * KINETIC;
    y[0][0] = mass->x, y[1][0] = mass->v;
    EACH_ORDER for (int k = 0; k < ORDER; k++) {
        y[0][k + 1] = y[1][k] * OVER[k + 1];
        y[1][k + 1] = (drive[k] - y[0][k]) * OVER[k + 1];
    }
    EACH_ORDER for (int k = 0; k <= ORDER; k++) gap[k] = -mass->sign * y[1][k];
    gap[0] += mass->sign * BELT;
}

/* What is left of the capacity in either direction. */
static inline void stick(const Mass *mass, Series *left) {
    Series drive;
    excitation(mass, drive);
    drive[0] -= mass->x, drive[1] -= BELT;
    EACH_ORDER for (int k = 0; k <= ORDER; k++) left[0][k] = -drive[k], left[1][k] = drive[k];
    left[0][0] += STATIC, left[1][0] += STATIC;
}

static void advance_slip(Mass *mass, double until, double rtol, int prints) {
    Series y[2], gap;
    slip(mass, y, gap);
    double step = fmin(step_of(y, 2, rtol, mass->last), until - mass->time);
    double root = first_root(gap, step, mass->zero);
    mass->last = step;
    if (root < 1) step *= root;
    mass->x = value(y[0], step), mass->v = value(y[1], step), mass->time += step;
    mass->zero = root < 1;
    if (!mass->zero) return;
    mass->v = BELT;
    double demand = mass->x - U0 * cos(mass->omega * mass->time);
    mass->sign = fabs(demand) <= STATIC ? 0 : demand > 0 ? 1 : -1;
    if (prints && !mass->sign) printf("%.17g %.17g\n", mass->x, mass->v);
}

static void advance_stick(Mass *mass, double until, double rtol) {
    Series left[2];
    stick(mass, left);
    double step = fmin(step_of(left, 2, rtol, mass->last), until - mass->time);
    double down = first_root(left[0], step, 0), up = first_root(left[1], step, 0);
    mass->last = step;
    if (fmin(down, up) < 1) {
        step *= fmin(down, up);
        mass->sign = up < down ? 1 : -1;
        mass->zero = 1;
    }
    mass->x += BELT * step, mass->time += step;
}

static double run(double omega, double until, double rtol, int prints) {
    Mass mass = {.omega = omega, .sign = 1, .last = 1};
    while (mass.time < until)
        if (mass.sign)
            advance_slip(&mass, until, rtol, prints);
        else
            advance_stick(&mass, until, rtol);
    if (prints) printf("%.17g %.17g\n", mass.x, mass.v);
    return prints ? 0 : mass.x;
}
