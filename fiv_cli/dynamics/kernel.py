"""The driver: contact state machine, event location, sections and measures, for every model.

It knows a model only by tables of addresses and switching functions (`system.py` fills them).
All state of a run is in arrays, so a run can be stopped and taken up again; the named constants
below are the only indices.

One step: the generated code writes the series of the state and of every switching function; the
step is as long as the last coefficients allow; the earliest root of any switching function ends
it. What follows an event is decided by `decide`: of the candidate contact states, sticking ones
first, the first one is taken in which every switching function is positive in the sense of its
first non-vanishing derivative. That single rule covers stick against reversal, release in the
direction of the demanded force, several contacts at once, grazing, re-contact at zero
compression, and transitions that follow one another at one instant.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numba.extending import register_jitable

from fiv_cli.dynamics.call import at, call_generated
from fiv_cli.dynamics.compiled import CACHE, INLINE, INNER
from fiv_cli.dynamics.roots import NO_ROOT, POLYNOMIAL, first_root

# Contact kinds and kinds of switching function: as in codegen/derive.py (a test compares them).
SLIP, STICK, SEPARATION = 0, 1, 2
VELOCITY, CAPACITY_UP, CAPACITY_DOWN, NORMAL, GAP, JAMMING = 0, 1, 2, 3, 4, 5

# Codes of a contact's state in ledgers and samples.
CODE_SLIP_PLUS, CODE_SLIP_MINUS, CODE_STICK, CODE_SEPARATION = 0, 1, 2, 3

# table[state, ...]
TAYLOR, FIELD, TANGENT, N_GUARDS, HAS_ANGLE, N_ARGUMENTS = 0, 1, 2, 3, 4, 5
TABLE_WIDTH = 6

# config[...]
N_STATES, N_CONTACTS, ORDER, N_PARAMETERS, N_COORDINATES, COEFFICIENTS, STATE, METHOD = range(8)
ZONE_START, ZONE_WIDTH, ZONE_CONTACT = 8, 9, 10  # parameter slots of the sector; -1: none
CONFIG_WIDTH = 11
METHOD_TAYLOR, METHOD_RK4 = 0, 1

# clock[...]
TIME, LAST_STEP, ZONE_LOW, ZONE_HIGH, NEXT_PHASE, FIRST_STEP, FILLED_FOR, TASK = range(8)
CLOCK_WIDTH = 8
# FIRST_STEP: of the contact state just decided, whose series is at hand; 0: none.
# FILLED_FOR: the slip signs and the sector that the coefficients were computed for; 0: none.
# TASK: what `advance` begins with: going on, deciding the contact state anew, or entering it.
GO_ON, DECIDE, ENTER = 0.0, 1.0, 2.0

# tolerances[...]
RTOL, FIXED_STEP, BOUND = 0, 1, 2

# counters[...]
STEPS, EVENTS, CHAINED, SECTIONS, SAMPLED, LEDGER, GRAZINGS, IMPACTS = range(8)
COUNTERS_WIDTH = 8

# limits[...]
MAX_STEPS, MAX_EVENTS, MAX_SECTIONS = 0, 1, 2

# section[...]: what ends up in the section buffer
SECTION_KIND, SECTION_FROM, SECTION_TO, SECTION_CONTACT, SECTION_STATE, SECTION_DIRECTION = range(6)
SECTION_NONE, SECTION_EVENT, SECTION_ZERO, SECTION_PHASE = 0, 1, 2, 3

# measures[...]
M_TIME, M_SPREAD, M_OTHER, M_FRICTION, M_DRIVE, M_IMPACT, M_RESIDUAL = range(7)
MEASURES_WIDTH = 7

# options[contact, ...]: candidates of `decide`, (kind, sign) pairs from OFFERS on; BEFORE: the
# code of the contact's state before the event; ONE_WAY: 1 where the sign of slip never changes
COUNT, AT_REST, BEFORE, ONE_WAY, OFFERS = 0, 1, 2, 3, 4
OPTIONS_WIDTH = 4 + 2 * 4

# Why `advance` returned.
REACHED, SECTION_FULL, STEP_BUDGET, EVENT_BUDGET = 0, 1, 2, 3
DIVERGED, CONTACT_LOST, NO_STATE, JAMMED, CHATTERING = 4, 5, 6, 7, 8

ENDLESS = 1e300  # step over which every series is a polynomial
POLYNOMIAL_STEPS = 16.0  # length of a step in stick, in steps of the last slip
CHAIN_CAP = 50  # transitions at one instant
PLATEAU = 1.0 / 6.0  # share by which the argument of tanh or exp may change over a step
LAYER = 2.0  # ... and the change that is always allowed
GRAZING = 1e-5  # a switching function that falls slower than this share of its scale may graze
ZERO = 1e-12  # a switching function this small against its scale over a step is at zero
VANISHING = 1e-10  # ... and so is a derivative
BISECTIONS = 80
NEGLIGIBLE = 1e-200  # a scale this small is none: quotients by it overflow
POLISHES = 4  # looks at a switching function at an event, Newton steps between them
ROUNDING = 1e-16  # a residual, relative to the scale, that no further step improves

# field output: state, rates, switching, the sector's angle if any, then per contact
# (F_N, F_T, v_rel), then energies
PER_CONTACT = 3
KINETIC, POTENTIAL, OTHER_POWER, FRICTION_POWER, DRIVE_POWER = range(5)
N_ENERGIES = 5


@register_jitable(**INNER)
def state_index(kinds, contacts):  # type: ignore[no-untyped-def]
    """Index of a combination of kinds: base 3, contact 0 first."""
    index = 0
    for i in range(contacts - 1, -1, -1):
        index = 3 * index + kinds[i]
    return index


@register_jitable(**INNER)
def code_of(kind, sign):  # type: ignore[no-untyped-def]
    """Code of a contact's state in ledgers."""
    if kind == SLIP:
        return CODE_SLIP_PLUS if sign > 0.0 else CODE_SLIP_MINUS
    return CODE_STICK if kind == STICK else CODE_SEPARATION


@register_jitable(**INNER)
def kind_of(code):  # type: ignore[no-untyped-def]
    """Kind of a contact's state from its code."""
    return SLIP if code <= CODE_SLIP_MINUS else code - 1


@njit(**INNER)
def series_value(series, offset, order, x):  # type: ignore[no-untyped-def]
    """Value of the series that begins at `offset`.

    Even and odd powers are summed apart: two short chains of operations instead of a long one.
    """
    square = x * x
    even = at(series, offset + order - order % 2)
    for k in range(order - order % 2 - 2, -1, -2):
        even = even * square + at(series, offset + k)
    odd = at(series, offset + order - 1 + order % 2)
    for k in range(order - 3 + order % 2, 0, -2):
        odd = odd * square + at(series, offset + k)
    return even + x * odd


@njit(**INNER)
def series_slope(series, offset, order, x):  # type: ignore[no-untyped-def]
    """Derivative of the series that begins at `offset`."""
    value = 0.0
    for k in range(order, 0, -1):
        value = value * x + k * at(series, offset + k)
    return value


@njit(**INNER)
def scale_and_slope(series, offset, order, step, x):  # type: ignore[no-untyped-def]
    """`series_scale` over a step and the derivative a time x into it."""
    scale, slope = abs(at(series, offset)), 0.0
    reach, power, number = 1.0, 1.0, 0.0
    for k in range(1, order + 1):
        number += 1.0
        reach *= step
        scale += abs(at(series, offset + k)) * reach
        slope += number * at(series, offset + k) * power
        power *= x
    return scale, slope


@njit(**INNER)
def series_scale(series, offset, order, step):  # type: ignore[no-untyped-def]
    """Sum of the absolute terms of a series over a step."""
    scale = 0.0
    power = 1.0
    for k in range(order + 1):
        scale += abs(at(series, offset + k)) * power
        power *= step
    return scale


@njit(**INNER)
def time_scale(series, n, order):  # type: ignore[no-untyped-def]
    """Shortest time in which a series' last terms catch up with its first ones."""
    shortest = ENDLESS
    for i in range(n):
        first = i * (order + 1)
        for top in range(order - 1, order + 1):
            high = abs(at(series, first + top))
            for k in range(3):
                low = abs(at(series, first + k))
                ratio = low / high if high > 0.0 else 0.0
                if ratio > 0.0:  # a value so small that its share is lost sets no scale
                    shortest = min(shortest, ratio ** (1.0 / (top - k)))
    return shortest


@njit(**INLINE)
def step_size(series, n, order, rtol, last):  # type: ignore[no-untyped-def]
    """Step for which the last two terms stay below rtol times each series' own scale.

    `n` counts the states and the switching functions: in stick the state may be a polynomial
    while the demanded force is not. The scale of a series is the largest of its first terms over
    the last step, so it follows the motion and not the units.
    """
    if last <= 0.0:
        last = time_scale(series, n, order)
        if last == ENDLESS:
            return ENDLESS
    worst = 0.0
    worst_before = 0.0
    for i in range(n):
        first = i * (order + 1)
        scale = max(abs(at(series, first)), abs(at(series, first + 1)) * last)
        scale = max(scale, abs(at(series, first + 2)) * last * last)
        if scale > NEGLIGIBLE:
            worst = max(worst, abs(at(series, first + order)) / scale)
            worst_before = max(worst_before, abs(at(series, first + order - 1)) / scale)
    # The term before the last decides if it is the larger one over the step that the last allows.
    before_decides = worst == 0.0 or (worst_before / worst) ** order > rtol / worst
    if worst_before > 0.0 and before_decides:
        return (rtol / worst_before) ** (1.0 / (order - 1))
    return (rtol / worst) ** (1.0 / order) if worst > 0.0 else ENDLESS


@njit(**INNER)
def within_plateau(series, offset, order, step):  # type: ignore[no-untyped-def]
    """Step over which the argument of tanh or exp keeps within sight of where it is.

    Far from zero they are constant to rounding, and the known terms of their series tell nothing
    of the layer about zero: without a limit a step would jump over it.
    """
    allowed = max(LAYER, PLATEAU * abs(at(series, offset)))
    while series_scale(series, offset + 1, order - 1, step) * step > allowed:
        step *= 0.75
    return step


@njit(**INNER)
def polynomial_step(series, n, n_guards, order, last):  # type: ignore[no-untyped-def]
    """Step for a motion that is a polynomial, exact over any length.

    Roots are located as fractions of the step, so it must not dwarf the time to the next event.
    """
    if last > 0.0:
        return POLYNOMIAL_STEPS * last
    step = ENDLESS
    for g in range(n_guards):
        offset = (n + g) * (order + 1)
        if series[offset + 1] != 0.0:
            step = min(step, 2.0 * abs(series[offset] / series[offset + 1]))
    return step if step > 0.0 else ENDLESS


@njit(**INLINE)
def leading(series, offset, order, step, known_zeros):  # type: ignore[no-untyped-def]
    """First non-vanishing derivative of a switching function: its order + 1, with its sign.

    0 when all vanish. `step` is the time over which derivatives are compared; without one (0)
    the first that is not exactly zero counts.
    """
    scale = series_scale(series, offset, order, step)
    if step == 0.0:
        step, scale = 1.0, 0.0
    power = 1.0
    for k in range(order):
        term = at(series, offset + k) * power
        tolerance = (ZERO if k == 0 else VANISHING) * scale
        if k >= known_zeros and abs(term) > tolerance:
            return k + 1 if term > 0.0 else -k - 1
        power *= step
    return 0


@njit(**INLINE)
def fill(config, clock, parameters, coefficients):  # type: ignore[no-untyped-def]
    """Compute the coefficients, unless they are those of these slip signs and this sector."""
    contacts, end = config[N_CONTACTS], config[N_PARAMETERS] - 1
    wanted = 1.0 + parameters[end]
    for i in range(contacts):
        wanted = 2.0 * wanted + (1.0 if parameters[end - contacts + i] > 0.0 else 0.0)
    if clock[FILLED_FOR] != wanted:
        call_generated(config[COEFFICIENTS], coefficients, 0.0, parameters, coefficients)
        clock[FILLED_FOR] = wanted


@njit(**INLINE)
def consistent(  # type: ignore[no-untyped-def]
    table,
    guards,
    config,
    clock,
    kinds,
    parameters,
    coefficients,
    y,
    series,
    tolerances,
    strips,
    trigger_kind,
    trigger_contact,
    options,
    lenient,
):
    """Whether a candidate contact state can follow: every switching function leads positive.

    `lenient` leaves out that another contact opens or closes at the same instant, or that this
    one loses its normal force together with its capacity: the next event, chained to this one.
    """
    n, order, contacts = config[N_STATES], config[ORDER], config[N_CONTACTS]
    index = state_index(kinds, contacts)
    if table[index, TAYLOR] == 0:
        return False
    fill(config, clock, parameters, coefficients)
    call_generated(table[index, TAYLOR], coefficients, clock[TIME], y, series)
    rows = n + table[index, N_GUARDS] + table[index, HAS_ANGLE]
    step = step_size(series, rows, order, tolerances[RTOL], clock[LAST_STEP])
    for i in range(table[index, N_ARGUMENTS]):
        step = within_plateau(series, (rows + i) * (order + 1), order, step)
    clock[FIRST_STEP] = step
    if step == ENDLESS:  # a motion that is a polynomial has no time scale of its own
        step = clock[LAST_STEP] if clock[LAST_STEP] > 0.0 else 0.0
    for g in range(table[index, N_GUARDS]):
        kind, contact = guards[index, g, 0], guards[index, g, 1]
        known_zeros = 0
        if kind == VELOCITY and options[contact, AT_REST] == 1:
            known_zeros = 1
        if kind == trigger_kind and contact == trigger_contact:
            known_zeros = 1
        if kind == GAP and trigger_kind == NORMAL and contact == trigger_contact:
            known_zeros = 1
        if kind == VELOCITY and contact == trigger_contact:
            sign = parameters[config[N_PARAMETERS] - 1 - contacts + contact]
            released = trigger_kind == (CAPACITY_UP if sign > 0.0 else CAPACITY_DOWN)
            if released and series[(n + g) * (order + 1) + 1] < 0.0:
                known_zeros = 2  # slip friction does not exceed the capacity: this is rounding
        lead = leading(series, (n + g) * (order + 1), order, step, known_zeros)
        if lenient and kind == NORMAL and trigger_kind == GAP and contact == trigger_contact:
            # the last of ever shorter flights: the open contact finds no gap rate left, this one
            # a force, or a rate of it, that is negative by rounding
            offset = (n + g) * (order + 1)
            rounding = VANISHING * series_scale(series, offset, order, step)
            if lead == -2 or (lead == -1 and series[offset] >= -rounding):
                lead = leading(series, offset, order, step, 2)
        opens = kind == NORMAL or kind == GAP
        if contact == trigger_contact:
            opens = kind == NORMAL and trigger_kind < NORMAL
        at_zero = lead < -1
        if lead < 0 and not (lenient and opens and at_zero):
            return False
        # A function that is zero throughout (a capacity that stays just reached) has no root.
        strips[g] = max(lead - 1, 0) if lead != 0 else order + 1
    return True


@register_jitable(**INNER)
def contact_outputs(table, index, n):  # type: ignore[no-untyped-def]
    """Where the contact outputs begin in the field output."""
    return 2 * n + table[index, N_GUARDS] + table[index, HAS_ANGLE]


@njit(**INNER)
def slip_velocity(  # type: ignore[no-untyped-def]
    table, config, clock, kinds, coefficients, y, field, contact
):
    """v_rel of a contact; zero when it is zero to rounding."""
    n, contacts = config[N_STATES], config[N_CONTACTS]
    index = state_index(kinds, contacts)
    call_generated(table[index, FIELD], coefficients, clock[TIME], y, field)
    v = field[contact_outputs(table, index, n) + PER_CONTACT * contact + 2]
    scale = 0.0
    for i in range(config[N_COORDINATES], n):
        scale += abs(y[i])
    return 0.0 if abs(v) <= ZERO * scale else v


@njit(**INNER)
def offer(options, contact, kind, sign):  # type: ignore[no-untyped-def]
    """Add a candidate state of a contact."""
    place = OFFERS + 2 * options[contact, COUNT]
    options[contact, place], options[contact, place + 1] = kind, sign
    options[contact, COUNT] += 1


@njit(**INLINE)
def decide(  # type: ignore[no-untyped-def]
    table,
    guards,
    config,
    clock,
    kinds,
    parameters,
    coefficients,
    y,
    series,
    field,
    tolerances,
    strips,
    trigger_kind,
    trigger_contact,
    grazing,
    options,
):
    """Choose the contact state that follows at (t, y); False when none is consistent.

    Selection rule where several are consistent (stiction is not unique at zero slip): sticking
    before slipping, staying closed before separating, and all contacts jointly; contacts that did
    not trigger stay as they are if they can. `grazing` says that the switching function that
    triggered may only touch zero, so staying is a candidate.
    """
    contacts = config[N_CONTACTS]
    first_sign = config[N_PARAMETERS] - 1 - contacts
    combinations = 1
    for i in range(contacts):
        sign = 1 if parameters[first_sign + i] > 0.0 else -1
        triggered = trigger_contact == i
        options[i, COUNT], options[i, AT_REST] = 0, 0
        if kinds[i] == SEPARATION and not (triggered and trigger_kind == GAP):
            offer(options, i, SEPARATION, sign)
            continue
        if kinds[i] == STICK or (triggered and trigger_kind == VELOCITY):
            options[i, AT_REST] = 1
        else:  # re-contact, or a slip that ends at the same instant
            v = slip_velocity(table, config, clock, kinds, coefficients, y, field, i)
            options[i, AT_REST] = 1 if v == 0.0 else 0
            if kinds[i] == SEPARATION and v != 0.0 and options[i, ONE_WAY] == 0:
                sign = 1 if v > 0.0 else -1
        released = triggered and (trigger_kind == CAPACITY_UP or trigger_kind == CAPACITY_DOWN)
        if released and not grazing:  # the demanded force passes the capacity: it slips its way
            offer(options, i, SLIP, 1 if trigger_kind == CAPACITY_UP else -1)
            combinations *= options[i, COUNT]
            continue
        # What triggers falls through zero, unless it grazes: it cannot stay as it was.
        passes = triggered and not grazing
        if not (passes and trigger_kind == NORMAL):
            if options[i, AT_REST] == 1:
                offer(options, i, STICK, sign)
            if not (passes and trigger_kind == VELOCITY):
                offer(options, i, SLIP, sign)
            if options[i, AT_REST] == 1:
                offer(options, i, SLIP, -sign)
        if trigger_kind < 0 or (triggered and (trigger_kind == GAP or trigger_kind == NORMAL)):
            offer(options, i, SEPARATION, sign)
        combinations *= options[i, COUNT]
    for attempt in range(2 * combinations):
        rest = attempt % combinations
        for place in range(contacts, -1, -1):  # the contact that triggered first: others stay
            i = trigger_contact if place == contacts else place
            if i < 0 or (i == trigger_contact and place < contacts):
                continue
            pick = rest % options[i, COUNT]
            rest //= options[i, COUNT]
            kinds[i] = options[i, OFFERS + 2 * pick]
            parameters[first_sign + i] = options[i, OFFERS + 2 * pick + 1]
        if consistent(
            table,
            guards,
            config,
            clock,
            kinds,
            parameters,
            coefficients,
            y,
            series,
            tolerances,
            strips,
            trigger_kind,
            trigger_contact,
            options,
            attempt >= combinations,
        ):
            return True
    return False


@njit(**INNER)
def state_after(  # type: ignore[no-untyped-def]
    table, config, index, coefficients, t, y, series, x, stages, out
):
    """State a time x into the step that begins at (t, y)."""
    n = config[N_STATES]
    if config[METHOD] == METHOD_TAYLOR:
        call_generated(config[STATE], coefficients, x, series, out)
        return
    field, inner = stages[0], stages[1]
    call_generated(table[index, FIELD], coefficients, t, y, field)
    for i in range(n):  # stage by stage: classical Runge-Kutta of order 4 (thesis 3.39, 3.40)
        out[i] = field[i] + x / 6.0 * field[n + i]
        inner[i] = field[i] + 0.5 * x * field[n + i]
    start = stages[2]
    for i in range(n):
        start[i] = field[i]
    call_generated(table[index, FIELD], coefficients, t + 0.5 * x, inner, field)
    for i in range(n):
        out[i] += x / 3.0 * field[n + i]
        inner[i] = start[i] + 0.5 * x * field[n + i]
    call_generated(table[index, FIELD], coefficients, t + 0.5 * x, inner, field)
    for i in range(n):
        out[i] += x / 3.0 * field[n + i]
        inner[i] = start[i] + x * field[n + i]
    call_generated(table[index, FIELD], coefficients, t + x, inner, field)
    for i in range(n):
        out[i] += x / 6.0 * field[n + i]
    call_generated(table[index, FIELD], coefficients, t + x, out, field)
    for i in range(n):
        out[i] = field[i]  # constrained entries exactly


@njit(**INNER)
def bisected(  # type: ignore[no-untyped-def]
    table, config, index, coefficients, t, y, series, step, stages, out, entry, factor, shift
):
    """Where ``factor * (output entry) + shift`` falls to zero in a step, by bisection (rk4).

    NO_ROOT when it is positive at the end of the step; entries count in the field output.
    """
    state_after(table, config, index, coefficients, t, y, series, step, stages, out)
    call_generated(table[index, FIELD], coefficients, t + step, out, stages[0])
    if factor * stages[0, entry] + shift > 0.0:
        return NO_ROOT
    low, high = 0.0, step
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        state_after(table, config, index, coefficients, t, y, series, middle, stages, out)
        call_generated(table[index, FIELD], coefficients, t + middle, out, stages[0])
        if factor * stages[0, entry] + shift > 0.0:
            low = middle
        else:
            high = middle
    return high / step


@njit(**INLINE)
def located(series, offset, order, step, strip, factor, shift, roots):  # type: ignore[no-untyped-def]
    """First root of ``factor * series + shift`` over a step, as a fraction of it (Taylor)."""
    power = factor
    for _ in range(strip):  # the first coefficients are known zeros
        power *= step
    start = power * at(series, offset + strip) + (shift if strip == 0 else 0.0)
    roots[POLYNOMIAL] = start
    total, end = abs(start), start
    for k in range(1, order + 1 - strip):
        power *= step
        coefficient = at(series, offset + strip + k) * power
        roots[POLYNOMIAL + k] = coefficient
        total += abs(coefficient)
        end += coefficient
    return first_root(order - strip, roots, total, end)


@njit(**INNER)
def take_samples(  # type: ignore[no-untyped-def]
    table,
    config,
    index,
    kinds,
    parameters,
    coefficients,
    clock,
    y,
    series,
    tau,
    stages,
    out,
    counters,
    sample_times,
    sample_states,
    sample_outputs,
    sample_codes,
):
    """Record the samples that fall into the step of length tau."""
    n, contacts = config[N_STATES], config[N_CONTACTS]
    first_sign = config[N_PARAMETERS] - 1 - contacts
    first = contact_outputs(table, index, n)
    t = clock[TIME]
    while counters[SAMPLED] < len(sample_times) and sample_times[counters[SAMPLED]] <= t + tau:
        row = counters[SAMPLED]
        x = min(max(sample_times[row] - t, 0.0), tau)
        state_after(table, config, index, coefficients, t, y, series, x, stages, out)
        call_generated(table[index, FIELD], coefficients, t + x, out, stages[0])
        for i in range(n):
            sample_states[row, i] = stages[0, i]
        for i in range(PER_CONTACT * contacts + N_ENERGIES):
            sample_outputs[row, i] = stages[0, first + i]
        for i in range(contacts):
            sample_codes[row, i] = code_of(kinds[i], parameters[first_sign + i])
        counters[SAMPLED] += 1


@njit(**INNER)
def take_measures(  # type: ignore[no-untyped-def]
    table,
    config,
    index,
    kinds,
    coefficients,
    clock,
    y,
    series,
    tau,
    stages,
    out,
    quadrature,
    reference,
    measures,
    extremes,
    shares,
):
    """Integrate the measures along the step of length tau by Gauss quadrature.

    Where the reference is NaN the coordinate does not count. extremes is (3, n): least and
    greatest value, integral of the square; shares is (contacts, 3): time in slip, stick,
    separation.
    """
    n, order, contacts = config[N_STATES], config[ORDER], config[N_CONTACTS]
    energies = contact_outputs(table, index, n) + PER_CONTACT * contacts
    t = clock[TIME]
    last_x = 0.0
    measures[M_TIME] += tau
    for i in range(contacts):
        shares[i, kinds[i]] += tau
    for i in range(n):  # an impact may have left a velocity at its extreme
        extremes[0, i] = min(extremes[0, i], y[i])
        extremes[1, i] = max(extremes[1, i], y[i])
    for node in range(quadrature.shape[0] + 1):
        at_end = node == quadrature.shape[0]
        x = tau if at_end else quadrature[node, 0] * tau
        weight = 0.0 if at_end else quadrature[node, 1] * tau
        state_after(table, config, index, coefficients, t, y, series, x, stages, out)
        for i in range(n):
            value = out[i]
            extremes[0, i] = min(extremes[0, i], value)
            extremes[1, i] = max(extremes[1, i], value)
            extremes[2, i] += weight * value * value
            if i < config[N_COORDINATES] and reference[i] == reference[i]:
                measures[M_SPREAD] += weight * (value - reference[i]) ** 2
            if config[METHOD] == METHOD_TAYLOR:
                offset = i * (order + 1)
                before = series_slope(series, offset, order, last_x)
                if before * series_slope(series, offset, order, x) < 0.0:
                    low, high = last_x, x
                    for _ in range(BISECTIONS):
                        middle = 0.5 * (low + high)
                        if before * series_slope(series, offset, order, middle) > 0.0:
                            low = middle
                        else:
                            high = middle
                    value = series_value(series, offset, order, 0.5 * (low + high))
                    extremes[0, i] = min(extremes[0, i], value)
                    extremes[1, i] = max(extremes[1, i], value)
        last_x = x
        if not at_end:
            call_generated(table[index, FIELD], coefficients, t + x, out, stages[0])
            measures[M_OTHER] += weight * stages[0, energies + OTHER_POWER]
            measures[M_FRICTION] += weight * stages[0, energies + FRICTION_POWER]
            measures[M_DRIVE] += weight * stages[0, energies + DRIVE_POWER]


@njit(**INNER)
def move_tangents(  # type: ignore[no-untyped-def]
    table, config, index, tolerances, coefficients, clock, y, tau, tangents, joined, series
):
    """Carry the tangent vectors (rows) over a step of length tau, in the parts that they need.

    The step was chosen for the motion. A tangent has modes that the motion may leave at rest, and
    where these are fast its series needs shorter steps.
    """
    n, order = config[N_STATES], config[ORDER]
    for row in range(tangents.shape[0]):
        for i in range(n):
            joined[i] = y[i]
            joined[n + i] = tangents[row, i]
        done = 0.0
        while done < tau:
            call_generated(table[index, TANGENT], coefficients, clock[TIME] + done, joined, series)
            part = min(step_size(series, 2 * n, order, tolerances[RTOL], tau - done), tau - done)
            if done + part == done:
                part = tau - done
            for i in range(2 * n):
                joined[i] = series_value(series, i * (order + 1), order, part)
            done = tau if part >= tau - done else done + part
        for i in range(n):
            tangents[row, i] = joined[n + i]


@njit(**INNER)
def switching_rates(  # type: ignore[no-untyped-def]
    table, config, index, entry, coefficients, clock, y, tangents, joined, series, rates, delays
):
    """At an event: the rates before it, and by how much each tangent delays it.

    A trajectory displaced by a tangent vector d meets the switching function g later by
    -dg(d) / g'; what the delay does to the state after the event is `saltate`'s.
    """
    n, order = config[N_STATES], config[ORDER]
    outputs = table[index, N_GUARDS] + table[index, HAS_ANGLE]
    for row in range(tangents.shape[0]):
        for i in range(n):
            joined[i] = y[i]
            joined[n + i] = tangents[row, i]
        call_generated(table[index, TANGENT], coefficients, clock[TIME], joined, series)
        for i in range(n):
            rates[i] = series[i * (order + 1) + 1]
        speed = series[(2 * n + entry) * (order + 1) + 1]
        change = series[(2 * n + outputs + entry) * (order + 1)]
        delays[row] = -change / speed if speed != 0.0 else 0.0


@njit(**INNER)
def strike(  # type: ignore[no-untyped-def]
    config, impact, coefficients, clock, y, tangents, joined, series, rates
):
    """Tangents through an impact y -> R(y, t): D R d; `rates` becomes dR/dt along the flow.

    With it `saltate` adds (dR/dt - f_after) delay, as it does at events without an impact.
    """
    n = config[N_STATES]
    for row in range(tangents.shape[0]):
        for i in range(n):
            joined[i] = y[i]
            joined[n + i] = tangents[row, i]
        call_generated(impact, coefficients, clock[TIME], joined, series)
        for i in range(n):  # rows of value and rate: y, tangent, R, tangent of R
            rates[i] = series[2 * (2 * n + i) + 1]
            tangents[row, i] = series[2 * (3 * n + i)]


@njit(**INNER)
def saltate(config, series, rates, tangents, delays):  # type: ignore[no-untyped-def]
    """Tangents after an event: d + (f_before - f_after) delay; `series` is the new state's."""
    order = config[ORDER]
    for row in range(tangents.shape[0]):
        for i in range(config[N_STATES]):
            after = series[i * (order + 1) + 1]
            tangents[row, i] += (rates[i] - after) * delays[row]


@njit(**INNER)
def enter_zone(config, clock, parameters, angle):  # type: ignore[no-untyped-def]
    """Set the sector that `angle` lies in and its borders."""
    clock[ZONE_LOW], clock[ZONE_HIGH] = -np.inf, np.inf
    zone_slot = config[N_PARAMETERS] - 1
    parameters[zone_slot] = 0.0
    if config[ZONE_START] < 0:
        return
    width = parameters[config[ZONE_WIDTH]]
    if width <= 0.0:
        return
    turn = 2.0 * np.pi
    if width >= turn:
        parameters[zone_slot] = 1.0
        return
    start = parameters[config[ZONE_START]]
    base = start + turn * np.floor((angle - start) / turn)
    if angle - base < width:
        parameters[zone_slot] = 1.0
        clock[ZONE_LOW], clock[ZONE_HIGH] = base, base + width
    else:
        clock[ZONE_LOW], clock[ZONE_HIGH] = base + width, base + turn


@njit(**INNER)
def starts_open(table, guards, config, clock, coefficients, y, series, contact):  # type: ignore[no-untyped-def]
    """Whether a contact begins open: a gap, or none but one that is about to be."""
    n, order, contacts = config[N_STATES], config[ORDER], config[N_CONTACTS]
    apart = 3**contacts - 1  # the state in which every contact is open
    if table[apart, TAYLOR] == 0:
        return False
    call_generated(table[apart, TAYLOR], coefficients, clock[TIME], y, series)
    for g in range(table[apart, N_GUARDS]):
        if guards[apart, g, 0] == GAP and guards[apart, g, 1] == contact:
            offset = (n + g) * (order + 1)
            gap, rate = series[offset], series[offset + 1]
            return gap > 0.0 or (gap == 0.0 and rate > 0.0)
    return False


@njit(**INNER)
def set_out(  # type: ignore[no-untyped-def]
    table, guards, config, clock, kinds, parameters, coefficients, y, series, stages, options
):
    """Slip signs, contacts at rest and open ones, and the sector, of the initial state.

    A contact whose kind is STICK takes on the drive's velocity.
    """
    n, contacts = config[N_STATES], config[N_CONTACTS]
    first_sign = config[N_PARAMETERS] - 1 - contacts
    field, rest, velocities = stages[0], stages[4], stages[5]
    for i in range(contacts):
        if kinds[i] == STICK:
            index = state_index(kinds, contacts)
            call_generated(table[index, FIELD], coefficients, clock[TIME], y, field)
            for k in range(n):
                y[k] = field[k]
            break
    for i in range(contacts):
        is_open = starts_open(table, guards, config, clock, coefficients, y, series, i)
        kinds[i] = SEPARATION if is_open else SLIP
    index = state_index(kinds, contacts)
    call_generated(table[index, FIELD], coefficients, clock[TIME], y, field)
    for k in range(n):
        y[k] = field[k]  # a rigid contact takes up its gap
        rest[k] = 0.0
    for i in range(contacts):
        velocities[i] = slip_velocity(table, config, clock, kinds, coefficients, y, field, i)
    for i in range(contacts):
        if kinds[i] == SLIP:
            smooth, direction = options[i, ONE_WAY] == 1, velocities[i]
            if smooth:  # the way it slides when the system is at rest
                direction = slip_velocity(table, config, clock, kinds, coefficients, rest, field, i)
            parameters[first_sign + i] = -1.0 if direction < 0.0 else 1.0
            if velocities[i] == 0.0 and not smooth:
                kinds[i] = STICK
    angle = 0.0
    if table[0, HAS_ANGLE] == 1:
        call_generated(table[0, FIELD], coefficients, clock[TIME], y, field)
        angle = field[2 * n + table[0, N_GUARDS]]
    enter_zone(config, clock, parameters, angle)


@njit(**INNER)
def away_from_border(series, offset, order, step, factor, shift):  # type: ignore[no-untyped-def]
    """Known zeros of ``factor * series + shift`` that begins at zero and rises; 0 otherwise."""
    value = factor * series[offset] + shift
    if abs(value) > ZERO * (abs(series[offset]) + abs(shift)):
        return 0
    scale = series_scale(series, offset + 1, order - 1, step) * step
    power = step
    for k in range(1, order):
        term = factor * series[offset + k] * power
        if abs(term) > VANISHING * scale:
            return k if term > 0.0 else 0
        power *= step
    return 0


@njit(**INNER)
def cross_border(config, clock, parameters, upwards):  # type: ignore[no-untyped-def]
    """Enter the neighbouring sector."""
    zone_slot = config[N_PARAMETERS] - 1
    width = parameters[config[ZONE_WIDTH]]
    parameters[zone_slot] = 1.0 - parameters[zone_slot]
    span = width if parameters[zone_slot] == 1.0 else 2.0 * np.pi - width
    if upwards:
        clock[ZONE_LOW] = clock[ZONE_HIGH]
        clock[ZONE_HIGH] = clock[ZONE_LOW] + span
    else:
        clock[ZONE_HIGH] = clock[ZONE_LOW]
        clock[ZONE_LOW] = clock[ZONE_HIGH] - span


@njit(**INNER)
def keep_section(counters, clock, y, section_times, section_states):  # type: ignore[no-untyped-def]
    """Put the present state into the section buffer."""
    row = counters[SECTIONS]
    section_times[row] = clock[TIME]
    for i in range(len(y)):
        section_states[row, i] = y[i]
    counters[SECTIONS] += 1


@njit(
    "int64(int64[:, ::1], int64[:, ::1], int64[:, :, ::1], int64[::1], float64[::1], int64[::1],"
    "float64[::1], float64[::1], float64[::1], float64[::1], int64[::1], int64[::1], int64[::1],"
    "float64, int64[::1], float64, int64[::1], float64[::1], float64[:, ::1], float64[::1],"
    "float64[:, ::1], float64[:, ::1], int64[:, ::1], float64[:, ::1], boolean, float64[:, ::1],"
    "float64[::1], float64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1],"
    "float64[::1], float64[::1], float64[:, ::1], float64[::1], int64[:, ::1])",
    **CACHE,
)
def advance(  # type: ignore[no-untyped-def]
    table,
    impacts,
    guards,
    config,
    clock,
    kinds,
    parameters,
    coefficients,
    y,
    tolerances,
    strips,
    counters,
    limits,
    t_stop,
    section,
    phase_interval,
    ends,
    section_times,
    section_states,
    sample_times,
    sample_states,
    sample_outputs,
    sample_codes,
    ledger,
    measuring,
    quadrature,
    reference,
    measures,
    extremes,
    shares,
    tangents,
    series,
    work,
    stages,
    roots,
    options,
):
    """Run until t_stop, a full section buffer, a budget or an end; returns why it stopped."""
    n, order, contacts = config[N_STATES], config[ORDER], config[N_CONTACTS]
    first_sign = config[N_PARAMETERS] - 1 - contacts
    taylor = config[METHOD] == METHOD_TAYLOR
    field = stages[0]
    out, joined, rates, delays = stages[3], stages[4], stages[5], stages[6]
    angle_up, angle_down, section_strip = (
        strips.shape[0] - 3,
        strips.shape[0] - 2,
        strips.shape[0] - 1,
    )
    with_tangents = tangents.shape[0] > 0
    fill(config, clock, parameters, coefficients)
    while True:
        t, tau, residual, grazing, section_sign = clock[TIME], 0.0, 0.0, True, 0.0
        index, n_guards, hit = 0, 0, -1
        begins = clock[TASK] != GO_ON
        if clock[TASK] == ENTER:
            set_out(
                table,
                guards,
                config,
                clock,
                kinds,
                parameters,
                coefficients,
                y,
                series,
                stages,
                options,
            )
        if not begins:
            if t >= t_stop:
                return REACHED
            if counters[STEPS] >= limits[MAX_STEPS]:
                return STEP_BUDGET
            if counters[EVENTS] >= limits[MAX_EVENTS]:
                return EVENT_BUDGET
            if section[SECTION_KIND] == SECTION_PHASE and clock[NEXT_PHASE] <= t:  # on an event
                keep_section(counters, clock, y, section_times, section_states)
                clock[NEXT_PHASE] += phase_interval
                if counters[SECTIONS] >= limits[MAX_SECTIONS]:
                    return SECTION_FULL
            counters[STEPS] += 1
            index = state_index(kinds, contacts)
            n_guards, has_angle = table[index, N_GUARDS], table[index, HAS_ANGLE]
            # --- the step -----------------------------------------------------------------------
            if taylor:
                step = clock[FIRST_STEP]
                clock[FIRST_STEP] = 0.0
                if step == 0.0:
                    call_generated(table[index, TAYLOR], coefficients, t, y, series)
                    rows = n + n_guards + has_angle
                    step = step_size(series, rows, order, tolerances[RTOL], clock[LAST_STEP])
                    for i in range(table[index, N_ARGUMENTS]):
                        step = within_plateau(series, (rows + i) * (order + 1), order, step)
                    for i in range(n):
                        y[i] = series[i * (order + 1)]
                if step < ENDLESS:
                    clock[LAST_STEP] = step
                else:
                    step = polynomial_step(series, n, n_guards, order, clock[LAST_STEP])
            else:
                step = tolerances[FIXED_STEP]
                clock[LAST_STEP] = step
            goal = t + step
            reaches_phase = False
            if section[SECTION_KIND] == SECTION_PHASE and clock[NEXT_PHASE] <= min(goal, t_stop):
                goal, reaches_phase = clock[NEXT_PHASE], True
            elif t_stop <= goal:
                goal = t_stop
            step = goal - t
            # --- the first switching function to fall to zero -----------------------------------
            # In order: the contact state's own, the two borders of the sector, the section.
            fraction, hit, crossing, section_sign = 1.0, -1, 0, 0.0
            for check in range(n_guards + 3):
                factor, shift, strip = 1.0, 0.0, 0
                if check < n_guards:
                    row, entry, strip = n + check, 2 * n + check, strips[check]
                    if strip > order:
                        continue
                elif check < n_guards + 2:
                    if has_angle == 0 or clock[ZONE_HIGH] == np.inf:
                        continue
                    row, entry = n + n_guards, 2 * n + n_guards
                    upper = check == n_guards
                    factor = -1.0 if upper else 1.0
                    shift = clock[ZONE_HIGH] if upper else -clock[ZONE_LOW]
                    strip = strips[angle_up] if upper else strips[angle_down]
                    if taylor:
                        leaving = away_from_border(
                            series, row * (order + 1), order, step, factor, shift
                        )
                        strip = max(strip, leaving)
                else:
                    if section[SECTION_KIND] != SECTION_ZERO:
                        continue
                    row, entry, strip = (
                        section[SECTION_STATE],
                        section[SECTION_STATE],
                        strips[section_strip],
                    )
                    if strip == 0:
                        value = y[entry]
                    elif taylor:
                        value = series[entry * (order + 1) + 1]
                    else:
                        call_generated(table[index, FIELD], coefficients, t, y, field)
                        value = field[n + entry]
                    factor = 1.0 if value > 0.0 else -1.0
                    section_sign = factor if value != 0.0 else 0.0
                if taylor:
                    root = located(
                        series, row * (order + 1), order, step, strip, factor, shift, roots
                    )
                else:
                    root = bisected(
                        table,
                        config,
                        index,
                        coefficients,
                        t,
                        y,
                        series,
                        step,
                        stages,
                        out,
                        entry,
                        factor,
                        shift,
                    )
                if check < n_guards + 2:
                    if root < fraction or (root == 1.0 and hit < 0):
                        fraction, hit = root, check
                elif 0.0 < root < fraction:
                    fraction, hit, crossing = root, check, -int(factor)
            tau = step if hit < 0 else fraction * step
            residual, grazing = 0.0, True
            if taylor:
                call_generated(config[STATE], coefficients, tau, series, out)
            else:
                state_after(table, config, index, coefficients, t, y, series, tau, stages, out)
            if taylor and 0 <= hit < n_guards:
                # The root is that of the switching function's series; Newton steps on the function
                # itself, along the state's series, take it to rounding.
                offset = (n + hit) * (order + 1)
                scale, fall = scale_and_slope(series, offset, order, step, tau)
                grazing = scale == 0.0 or fall * step > -GRAZING * scale
                for polish in range(POLISHES):
                    call_generated(table[index, FIELD], coefficients, t + tau, out, field)
                    value = field[2 * n + hit]
                    residual = abs(value) / scale if scale > 0.0 else 0.0
                    if grazing or residual <= ROUNDING or polish == POLISHES - 1:
                        break
                    tau += max(-value / fall, -tau)
                    call_generated(config[STATE], coefficients, tau, series, out)
                for i in range(n):
                    out[i] = field[i]  # entries that the contact determines: exactly
            # --- along the step ----------------------------------------------------------------
            if counters[SAMPLED] < len(sample_times):
                take_samples(
                    table,
                    config,
                    index,
                    kinds,
                    parameters,
                    coefficients,
                    clock,
                    y,
                    series,
                    tau,
                    stages,
                    joined,
                    counters,
                    sample_times,
                    sample_states,
                    sample_outputs,
                    sample_codes,
                )
            if measuring:
                take_measures(
                    table,
                    config,
                    index,
                    kinds,
                    coefficients,
                    clock,
                    y,
                    series,
                    tau,
                    stages,
                    joined,
                    quadrature,
                    reference,
                    measures,
                    extremes,
                    shares,
                )
            if with_tangents:
                move_tangents(
                    table,
                    config,
                    index,
                    tolerances,
                    coefficients,
                    clock,
                    y,
                    tau,
                    tangents,
                    joined,
                    work,
                )
            for i in range(n):
                y[i] = out[i]
                if not abs(out[i]) < tolerances[BOUND]:
                    return DIVERGED
            for g in range(strips.shape[0]):
                strips[g] = 0
            if hit < 0:
                clock[TIME] = goal
                counters[CHAINED] = 0
                if reaches_phase:
                    keep_section(counters, clock, y, section_times, section_states)
                    clock[NEXT_PHASE] += phase_interval
                    if counters[SECTIONS] >= limits[MAX_SECTIONS]:
                        return SECTION_FULL
                continue
            clock[TIME] = t + tau
            if hit == n_guards + 2:  # only a section: the contact state stays
                counters[CHAINED] = 0
                strips[section_strip] = 1
                wanted = section[SECTION_DIRECTION]
                if wanted == 0 or wanted == crossing:
                    y[section[SECTION_STATE]] = 0.0
                    keep_section(counters, clock, y, section_times, section_states)
                    if counters[SECTIONS] >= limits[MAX_SECTIONS]:
                        return SECTION_FULL
                continue
        # --- an event ---------------------------------------------------------------------------
        counters[CHAINED] = counters[CHAINED] + 1 if not begins and t + tau <= t else 0
        if counters[CHAINED] > CHAIN_CAP:
            return CHATTERING
        trigger_kind, trigger_contact = -1, -1
        if hit >= n_guards:
            trigger_contact = config[ZONE_CONTACT]
        elif not begins:
            trigger_kind, trigger_contact = guards[index, hit, 0], guards[index, hit, 1]
        if with_tangents and not begins:
            entry = hit if hit < n_guards else n_guards
            switching_rates(
                table,
                config,
                index,
                entry,
                coefficients,
                clock,
                y,
                tangents,
                joined,
                work,
                rates,
                delays,
            )
        for i in range(contacts):
            options[i, BEFORE] = code_of(kinds[i], parameters[first_sign + i])
        impacted = False
        if trigger_kind == JAMMING:
            return JAMMED
        if trigger_kind == NORMAL and ends[trigger_contact] == 1:
            return CONTACT_LOST
        if trigger_kind == GAP and impacts[index, trigger_contact] != 0:
            energies = contact_outputs(table, index, n) + PER_CONTACT * contacts
            call_generated(table[index, FIELD], coefficients, clock[TIME], y, field)
            kinetic = field[energies + KINETIC]
            if with_tangents:
                strike(
                    config,
                    impacts[index, contacts + trigger_contact],
                    coefficients,
                    clock,
                    y,
                    tangents,
                    joined,
                    work,
                    rates,
                )
            call_generated(impacts[index, trigger_contact], coefficients, clock[TIME], y, out)
            for i in range(n):
                y[i] = out[i]
            call_generated(table[index, FIELD], coefficients, clock[TIME], y, field)
            measures[M_IMPACT] += kinetic - field[energies + KINETIC]
            counters[IMPACTS] += 1
            impacted = True
        if hit >= n_guards:
            cross_border(config, clock, parameters, hit == n_guards)
            fill(config, clock, parameters, coefficients)
            call_generated(table[index, TAYLOR], coefficients, clock[TIME], y, series)
            clock[FIRST_STEP] = 0.0
            strips[angle_down if hit == n_guards else angle_up] = 1
        elif not decide(
            table,
            guards,
            config,
            clock,
            kinds,
            parameters,
            coefficients,
            y,
            series,
            field,
            tolerances,
            strips,
            trigger_kind,
            trigger_contact,
            grazing,
            options,
        ):
            return NO_STATE
        for i in range(n):
            y[i] = series[i * (order + 1)]
        if begins:
            clock[TASK] = GO_ON
            continue
        if with_tangents:
            saltate(config, series, rates, tangents, delays)
        if section[SECTION_KIND] == SECTION_ZERO:  # does the section lie on the event?
            entry = section[SECTION_STATE]
            offset = entry * (order + 1)
            slope = series[offset + 1]
            if abs(y[entry]) <= ZERO * series_scale(series, offset, order, clock[LAST_STEP]):
                strips[section_strip] = 1
                crossing = 1 if slope > 0.0 else -1
                wanted = section[SECTION_DIRECTION]
                if section_sign * slope < 0.0 and (wanted == 0 or wanted == crossing):
                    keep_section(counters, clock, y, section_times, section_states)
                    section_states[counters[SECTIONS] - 1, entry] = 0.0
        events = counters[EVENTS]
        for i in range(contacts):
            before, after = options[i, BEFORE], code_of(kinds[i], parameters[first_sign + i])
            itself = i == trigger_contact and (impacted or hit >= n_guards)
            if before == after and not itself:
                continue
            counters[EVENTS] += 1
            if counters[LEDGER] < ledger.shape[0]:
                row = counters[LEDGER]
                ledger[row, 0], ledger[row, 1], ledger[row, 2] = clock[TIME], before, after
                ledger[row, 3], ledger[row, 4] = i, residual
                counters[LEDGER] += 1
            if (
                section[SECTION_KIND] == SECTION_EVENT
                and i == section[SECTION_CONTACT]
                and kind_of(before) == section[SECTION_FROM]
                and kinds[i] == section[SECTION_TO]
            ):
                keep_section(counters, clock, y, section_times, section_states)
        if counters[EVENTS] == events:
            counters[GRAZINGS] += 1
        else:
            measures[M_RESIDUAL] = max(measures[M_RESIDUAL], residual)
        if counters[SECTIONS] >= limits[MAX_SECTIONS]:
            return SECTION_FULL


@njit("void(int64, float64[::1], float64, float64[::1], float64[::1])", **CACHE)
def call_once(address, coefficients, time, state, out):  # type: ignore[no-untyped-def]
    """Call one generated function (from Python)."""
    call_generated(address, coefficients, time, state, out)
