/* The slider on an elastically supported belt, five degrees of freedom with plastic impacts, as a
 * careful engineer writes it in C; nothing of fiv is used.
 *
 * Thesis 6.1 with the values of tables 6.1 to 6.3, k_nl = 1e4, F = 200, mu_s = 3; it starts in
 * slip from zero. The parameter is mu_k. */
#include "taylor.h"

static const double M = 1, m = 1, J = 0.1, C = 0.1, K1 = 1e4, K2 = 5e3, K3 = 6e3, K4 = 1e4,
                    K5 = 1e4, K6 = 1e4, ARM = 0.2, BELT = 1, PRELOAD = 200, K_NL = 1e4, MU_S = 3;
enum { X1, Y1, X2, Y2, PHI, COUNT, STATES = 2 * COUNT };
typedef enum { SLIP, STICK, OPEN } Contact;

typedef struct {
    double time, y[STATES], mu_k, last; /* last: length of the last step */
    Contact contact;
    double sign;                  /* of the slip velocity, belt less slider */
    int zero_slip, zero_gap;      /* known zeros of either at the start of the step */
} Slider;

/* Friction that keeps slider and belt together (thesis 6.6), of coefficients of the states. */
static inline double held(double x1, double y1, double x2, double x1_dot, double x2_dot) {
    double slider = C * x1_dot + K1 * x1 + 0.5 * K3 * (x1 - y1), belt = C * x2_dot + K4 * x2;
    return slider - M / (M + m) * (slider + belt);
}

static inline double held_of(const Series *y, int k) {
    return held(y[X1][k], y[Y1][k], y[X2][k], y[COUNT + X1][k], y[COUNT + X2][k]);
}

/* The series of a contact state: states, compression, normal force. */
static inline __attribute__((always_inline)) void series(const Slider *s, const Contact contact,
                                                         Series *y, Series depth, Series normal) {
    Series lever, square;
    for (int i = 0; i < STATES; i++) y[i][0] = s->y[i];
    EACH_ORDER for (int k = 0; k <= ORDER; k++) {
        lever[k] = y[X1][k] - y[X2][k];
        depth[k] = y[Y2][k] - y[Y1][k] - product(lever, y[PHI], k);
        double force = 0, moment = 0;
        if (contact != OPEN) {
            square[k] = product(depth, depth, k);
            normal[k] = force = K2 * depth[k] + K_NL * product(depth, square, k);
            moment = product(normal, lever, k);
        }
        if (k == ORDER) return;
        const double friction = contact == OPEN    ? 0
                                : contact == STICK ? held_of(y, k)
                                                   : s->sign * s->mu_k * force;
        const double over = OVER[k + 1], *dot[COUNT] = {y[5], y[6], y[7], y[8], y[9]};
        double diagonal = 0.5 * K3 * (y[X1][k] - y[Y1][k]);
        double first = C * (dot[Y2][k] + ARM * dot[PHI][k]) + K5 * (y[Y2][k] + ARM * y[PHI][k]);
        double second = C * (dot[Y2][k] - ARM * dot[PHI][k]) + K6 * (y[Y2][k] - ARM * y[PHI][k]);
        double load = k ? 0 : PRELOAD;
        y[5][k + 1] = (friction - C * dot[X1][k] - K1 * y[X1][k] - diagonal) * (over / M);
        y[6][k + 1] = (force - load - C * dot[Y1][k] + diagonal) * (over / M);
        y[7][k + 1] = (-friction - C * dot[X2][k] - K4 * y[X2][k]) * (over / m);
        y[8][k + 1] = (-force - first - second) * (over / m);
        y[9][k + 1] = (moment - ARM * (first - second)) * (over / J);
        EACH_ORDER for (int i = 0; i < COUNT; i++) y[i][k + 1] = dot[i][k] * over;
    }
}

/* The state after a plastic impact (thesis 6.10 to 6.12 with the full gap rate). */
static void strike(double *y) {
    double lever = y[X1] - y[X2];
    double closing = y[8] - lever * y[9] - (y[5] - y[7]) * y[PHI] - y[6];
    double impulse = closing / (1 / M + 1 / m + lever * lever / J);
    y[6] += impulse / M;
    y[8] -= impulse / m;
    y[9] += impulse * lever / J;
}

static double demand(const double *y) { return held(y[X1], y[Y1], y[X2], y[5], y[7]); }

static double capacity(const double *y) {
    double depth = y[Y2] - y[Y1] - (y[X1] - y[X2]) * y[PHI];
    return MU_S * (K2 * depth + K_NL * depth * depth * depth);
}

/* The step, or what an event leaves of it. */
static double go_on(Slider *s, const Series *y, double step, double root) {
    s->last = step;
    if (root < 1) step *= root;
    EACH_ORDER for (int i = 0; i < STATES; i++) s->y[i] = value(y[i], step);
    s->time += step;
    s->zero_slip = s->zero_gap = 0;
    return root;
}

static void open_contact(Slider *s, double root) {
    s->contact = OPEN;
    s->zero_gap = root == 0 ? 2 : 1;
}

static void advance_slip(Slider *s, double until, double rtol, int prints) {
    Series y[STATES + 1], depth, normal, *gap = y + STATES;
    series(s, SLIP, y, depth, normal);
    EACH_ORDER for (int k = 0; k <= ORDER; k++) (*gap)[k] = s->sign * (y[7][k] - y[5][k]);
    (*gap)[0] += s->sign * BELT;
    double step = fmin(step_of(y, STATES, rtol, s->last), until - s->time);
    double meets = first_root(*gap, step, s->zero_slip), opens = first_root(depth, step, s->zero_gap);
    double root = go_on(s, y, step, fmin(meets, opens));
    if (root >= 1) return;
    if (opens < meets) {
        open_contact(s, root);
        return;
    }
    s->y[5] = BELT + s->y[7];
    double force = demand(s->y);
    s->zero_slip = 1;
    if (fabs(force) > capacity(s->y)) {
        s->sign = force > 0 ? 1 : -1;
        return;
    }
    s->contact = STICK;
    if (!prints) return;
    for (int i = 0; i < STATES; i++) printf("%.17g%c", s->y[i], i == STATES - 1 ? '\n' : ' ');
}

static void advance_stick(Slider *s, double until, double rtol) {
    Series y[STATES + 2], depth, normal, *left = y + STATES;
    series(s, STICK, y, depth, normal);
    EACH_ORDER for (int k = 0; k <= ORDER; k++) {
        double force = held_of(y, k);
        left[0][k] = MU_S * normal[k] - force, left[1][k] = MU_S * normal[k] + force;
    }
    double step = fmin(step_of(y, STATES, rtol, s->last), until - s->time);
    double up = first_root(left[0], step, 0), down = first_root(left[1], step, 0);
    double opens = first_root(depth, step, s->zero_gap), released = fmin(up, down);
    double root = go_on(s, y, step, fmin(released, opens));
    s->y[5] = BELT + s->y[7];
    if (root >= 1) return;
    if (opens < released) {
        open_contact(s, root);
        return;
    }
    s->contact = SLIP;
    s->sign = up < down ? 1 : -1;
    s->zero_slip = 1;
}

static void advance_open(Slider *s, double until, double rtol) {
    Series y[STATES], depth, gap, normal;
    series(s, OPEN, y, depth, normal);
    EACH_ORDER for (int k = 0; k <= ORDER; k++) gap[k] = -depth[k];
    double step = fmin(step_of(y, STATES, rtol, s->last), until - s->time);
    if (go_on(s, y, step, first_root(gap, step, s->zero_gap)) >= 1) return;
    strike(s->y);
    s->contact = SLIP;
    s->sign = BELT + s->y[7] - s->y[5] > 0 ? 1 : -1;
    s->zero_gap = 2;
}

static double run(double mu_k, double until, double rtol, int prints) {
    Slider s = {.mu_k = mu_k, .sign = 1, .last = 1e-3, .contact = SLIP, .zero_gap = 2};
    while (s.time < until)
        if (s.contact == SLIP)
            advance_slip(&s, until, rtol, prints);
        else if (s.contact == STICK)
            advance_stick(&s, until, rtol);
        else
            advance_open(&s, until, rtol);
    for (int i = 0; prints && i < STATES; i++)
        printf("%.17g%c", s.y[i], i == STATES - 1 ? '\n' : ' ');
    return prints ? 0 : s.y[X1];
}
