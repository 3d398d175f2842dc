/* The pin on the disc as a careful engineer writes it in C: RK4 with a fixed step, every event
 * bisected. The opponent of the benchmark of maps; nothing of fiv is used.
 *
 *   rk4_pin STEP SECONDS map                  every point of Figure 7.6, silently
 *   rk4_pin STEP SECONDS points OMEGA N0      the states at slip->stick, then the last
 *
 * J_c phi'' and J_L theta'' of thesis 7.12, 7.13, 7.17 with the values of tables 7.1 and 7.2;
 * start: phi' = Omega, all else zero. A run ends where the normal force vanishes. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double J_C = 12e-4, J_L = 5e-4, K1 = 1500, K2 = 1000, K3 = 1000, C1 = 1e-3,
                    C2 = 1e-3, ARM = 0.1, MU_S = 0.4, MU_K = 0.23;
enum { HALVINGS = 45 };

typedef struct {
    double phi, theta, phi_dot, theta_dot;
} State;
typedef struct {
    double omega, preload;
    int sign; /* of the slip velocity; 0: sticking */
} Pin;

static double stretch(State y) { return ARM * y.theta + ARM * y.phi * y.phi * 0.5; }
static double normal_force(const Pin *pin, State y) { return pin->preload - K2 * stretch(y); }

static double moment(State y) {
    return -K1 * ARM * ARM * y.phi - K2 * ARM * y.phi * stretch(y) -
           K3 * ARM * ARM * (y.theta + y.phi) - C1 * y.phi_dot;
}

/* The friction force that holds the pin. */
static double demand(State y) { return -moment(y) * (1 / ARM); }

static State rate(const Pin *pin, State y) {
    double friction = pin->sign ? pin->sign * MU_K * normal_force(pin, y) : demand(y);
    return (State){y.phi_dot, y.theta_dot, (moment(y) + ARM * friction) * (1 / J_C),
                   (-K3 * ARM * ARM * (y.theta + y.phi) - K2 * ARM * stretch(y) - C2 * y.theta_dot) *
                       (1 / J_L)};
}

static State along(State y, double h, State f) {
    return (State){y.phi + h * f.phi, y.theta + h * f.theta, y.phi_dot + h * f.phi_dot,
                   y.theta_dot + h * f.theta_dot};
}

static State step(const Pin *pin, State y, double h) {
    State a = rate(pin, y), b = rate(pin, along(y, h / 2, a)), c = rate(pin, along(y, h / 2, b)),
          d = rate(pin, along(y, h, c));
    return along(along(along(along(y, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
}

/* Positive while the contact stays as it is. */
static double until_event(const Pin *pin, State y) {
    double force = normal_force(pin, y);
    double guard = pin->sign ? pin->sign * (pin->omega - y.phi_dot) : MU_S * force - fabs(demand(y));
    return guard < force ? guard : force;
}

/* The largest part of the step that has no event. */
static double bisected(const Pin *pin, State y, double h) {
    double low = 0, high = h;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = (low + high) / 2;
        if (until_event(pin, step(pin, y, middle)) > 0)
            low = middle;
        else
            high = middle;
    }
    return high;
}

/* Which contact state follows an event. */
static void pass(Pin *pin, State *y) {
    double force = demand(*y), can = MU_S * normal_force(pin, *y);
    if (pin->sign) {
        y->phi_dot = pin->omega;
        force = demand(*y);
        pin->sign = fabs(force) <= can ? 0 : (force > 0 ? 1 : -1);
    } else
        pin->sign = force > 0 ? 1 : -1;
}

static void print(State y) { printf("%.17g %.17g %.17g %.17g\n", y.phi, y.theta, y.phi_dot, y.theta_dot); }

static double run(Pin pin, double h, double seconds, int aloud) {
    State y = {0, 0, pin.omega, 0};
    double t = 0;
    while (t < seconds && normal_force(&pin, y) > 0) {
        double part = h < seconds - t ? h : seconds - t;
        State next = step(&pin, y, part);
        if (!(until_event(&pin, next) > 0)) {
            part = bisected(&pin, y, part);
            y = step(&pin, y, part);
            if (normal_force(&pin, y) <= 0) break;
            int slipped = pin.sign;
            pass(&pin, &y);
            if (aloud && slipped && !pin.sign) print(y);
        } else
            y = next;
        t += part;
    }
    if (aloud) print(y);
    return y.phi;
}

int main(int count, char **given) {
    if (count < 4) return 2;
    double h = atof(given[1]), seconds = atof(given[2]), sum = 0;
    if (!strcmp(given[3], "points") && count == 6)
        return run((Pin){atof(given[4]), atof(given[5]), 0}, h, seconds, 1), 0;
    for (int i = 0; i < 47; i++)
        for (int j = 1; j <= 40; j++) sum += run((Pin){0.5 + 0.25 * i, j, 0}, h, seconds, 0);
    return sum > 1e300;
}
