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

from fiv_cli.codegen.memory import (
    Floats,
    Floats2,
    Frame,
    Ints,
    Ints2,
    Ints3,
    OwnFloats,
    OwnInts,
    bits_of,
    call_generated,
    float_of,
    inlined,
    native,
)
from fiv_cli.dynamics.roots import NO_ROOT, chord, first_root

# Contact kinds and kinds of switching function: as in codegen/derive.py (a test compares them).
SLIP, STICK, SEPARATION = 0, 1, 2
VELOCITY, CAPACITY_UP, CAPACITY_DOWN, NORMAL, GAP, JAMMING = 0, 1, 2, 3, 4, 5

# Codes of a contact's state in ledgers and samples.
CODE_SLIP_PLUS, CODE_SLIP_MINUS, CODE_STICK, CODE_SEPARATION = 0, 1, 2, 3

# table[state, ...]
TAYLOR, FIELD, TANGENT, N_GUARDS, HAS_ANGLE, N_ARGUMENTS, SWITCHING, MOVED = range(8)
TABLE_WIDTH = 8

# config[...]
N_STATES, N_CONTACTS, ORDER, N_PARAMETERS, N_COORDINATES, COEFFICIENTS, STATE, METHOD = range(8)
VALUE_AND_SLOPE, BERNSTEIN = 8, 9
ZONE_START, ZONE_WIDTH, ZONE_CONTACT = 10, 11, 12  # parameter slots of the sector; -1: none
TANGENT_ORDER = 13
CONFIG_WIDTH = 14
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
TOLERANCES_WIDTH = 3

# counters[...]
STEPS, EVENTS, CHAINED, SECTIONS, SAMPLED, LEDGER, GRAZINGS, IMPACTS = range(8)
COUNTERS_WIDTH = 8

# limits[...]
MAX_STEPS, MAX_EVENTS, MAX_SECTIONS = 0, 1, 2
LIMITS_WIDTH = 3

# section[...]: what ends up in the section buffer
SECTION_KIND, SECTION_FROM, SECTION_TO, SECTION_CONTACT, SECTION_STATE, SECTION_DIRECTION = range(6)
SECTION_WIDTH = 6
SECTION_NONE, SECTION_EVENT, SECTION_ZERO, SECTION_PHASE = 0, 1, 2, 3

# measures[...]
M_TIME, M_SPREAD, M_OTHER, M_FRICTION, M_DRIVE, M_IMPACT, M_RESIDUAL = range(7)
MEASURES_WIDTH = 7

LEDGER_WIDTH = 5  # time, code before, code after, contact, residual

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
SHORT_FLIGHTS = 25  # impacts at one instant after which flights are below rounding: contact stays
PLATEAU = 1.0 / 6.0  # share by which the argument of tanh or exp may change over a step
LAYER = 2.0  # ... and the change that is always allowed
GRAZING = 1e-5  # a switching function that falls slower than this share of its scale may graze
ZERO = 1e-12  # a switching function this small against its scale over a step is at zero
VANISHING = 1e-10  # ... and so is a derivative
LAST_DIGITS = 1e-10  # a gap this small against what states make it up is none at a start
SAME_INSTANT = 1e-9  # two events within this share of a step may be one
BISECTIONS = 80
TURNED = 1e-10  # what is left to a turn, as a share of what a value changes by between two nodes
FEWEST_NODES = 3  # of a quadrature
MANTISSA, BIAS = 2**52, 1023  # of a float's bits: the exponent counts these, from there
NEGLIGIBLE = 1e-200  # a scale this small is none: quotients by it overflow
POLISHES = 4  # looks at a switching function at an event, Newton steps between them
ROUNDING = 1e-16  # a residual, relative to the scale, that no further step improves
EXACT = 1e-6  # ... and that a motion of this share of the tolerance does not notice

# field output: state, rates, switching, the sector's angle if any, then per contact
# (F_N, F_T, v_rel), then energies
PER_CONTACT = 3
KINETIC, POTENTIAL, OTHER_POWER, FRICTION_POWER, DRIVE_POWER = range(5)
N_ENERGIES = 5


class Run(Frame):
    """The arrays of a run.

    Of the system: addresses of generated functions and switching functions per contact state
    (table, impacts, guards), config, which contacts cannot open (ends). Of the run: where and how
    it is (clock, kinds, parameters, coefficients, y, strips: known zeros of switching functions at
    the start of a step, counters), tolerances and limits. What is asked for: section points,
    samples, a ledger of events (time, code before, after, contact, residual), measures, tangent
    vectors. The rest is written before it is read.
    """

    clock: OwnFloats
    parameters: OwnFloats
    coefficients: OwnFloats
    y: OwnFloats
    measures: OwnFloats
    tolerances: OwnFloats
    kinds: OwnInts
    strips: OwnInts
    counters: OwnInts
    limits: OwnInts
    table: Ints2
    impacts: Ints2
    guards: Ints3
    config: Ints
    ends: Ints
    quadrature: Floats2
    series: Floats
    work: Floats
    stages: Floats2
    polynomial: Floats
    pieces: Floats
    options: Ints2
    reference: Floats
    extremes: Floats2
    shares: Floats2
    section: Ints
    section_times: Floats
    section_states: Floats2
    sample_times: Floats
    sample_states: Floats2
    sample_outputs: Floats2
    sample_codes: Ints2
    ledger: Floats2
    tangents: Floats2


@native
def state_index(kinds: Ints, contacts: int) -> int:
    """Index of a combination of kinds: base 3, contact 0 first."""
    index = 0
    for i in range(contacts - 1, -1, -1):
        index = 3 * index + kinds[i]
    return index


@native
def code_of(kind: int, sign: float) -> int:
    """Code of a contact's state in ledgers."""
    if kind == SLIP:
        return CODE_SLIP_PLUS if sign > 0.0 else CODE_SLIP_MINUS
    return CODE_STICK if kind == STICK else CODE_SEPARATION


@native
def kind_of(code: int) -> int:
    """Kind of a contact's state from its code."""
    return SLIP if code <= CODE_SLIP_MINUS else code - 1


@native
def series_value(series: Floats, offset: int, order: int, x: float) -> float:
    """Value of the series that begins at `offset`.

    Even and odd powers are summed apart: two short chains of operations instead of a long one.
    """
    square = x * x
    even = series[offset + order - order % 2]
    for k in range(order - order % 2 - 2, -1, -2):
        even = even * square + series[offset + k]
    odd = series[offset + order - 1 + order % 2]
    for k in range(order - 3 + order % 2, 0, -2):
        odd = odd * square + series[offset + k]
    return even + x * odd


@native
def scale_and_slope(
    series: Floats, offset: int, order: int, step: float, x: float
) -> tuple[float, float]:
    """`series_scale` over a step and the derivative a time x into it."""
    scale, slope = abs(series[offset]), 0.0
    reach, power, number = 1.0, 1.0, 0.0
    for k in range(1, order + 1):
        number += 1.0
        reach *= step
        scale += abs(series[offset + k]) * reach
        slope += number * series[offset + k] * power
        power *= x
    return scale, slope


@native
def series_scale(series: Floats, offset: int, order: int, step: float) -> float:
    """Sum of the absolute terms of a series over a step."""
    even, odd, power, square = 0.0, 0.0, 1.0, step * step
    for k in range(0, order, 2):
        even += abs(series[offset + k]) * power
        odd += abs(series[offset + k + 1]) * power
        power *= square
    if order % 2 == 0:
        even += abs(series[offset + order]) * power
    return even + odd * step


@native
def time_scale(series: Floats, n: int, order: int) -> float:
    """Shortest time in which a series' last terms catch up with its first ones."""
    shortest = ENDLESS
    for i in range(n):
        first = i * (order + 1)
        for top in range(order - 1, order + 1):
            high = abs(series[first + top])
            for k in range(3):
                low = abs(series[first + k])
                ratio = low / high if high > 0.0 else 0.0
                if ratio > 0.0:  # a value so small that its share is lost sets no scale
                    shortest = min(shortest, ratio ** (1.0 / (top - k)))
    return shortest


@native
def root_of(value: float, degree: int) -> float:
    """``value ** (1 / degree)`` to half a per cent, of a positive value.

    All that a step needs, in a third of the time of a power, and the same on every machine. The
    logarithm to base 2 is read off the bits: between powers of two they rise along the chord.
    """
    logarithm = (bits_of(value) / MANTISSA - BIAS) / degree
    whole = np.floor(logarithm)
    part = logarithm - whole
    return float_of((int(whole) + BIAS) * MANTISSA) * (1.0 + part * (0.6565 + 0.3435 * part))


@native
def step_size(series: Floats, n: int, order: int, rtol: float, last: float) -> float:
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
        scale = max(abs(series[first]), abs(series[first + 1]) * last)
        scale = max(scale, abs(series[first + 2]) * last * last)
        if scale > NEGLIGIBLE:
            share = 1.0 / scale
            worst = max(worst, abs(series[first + order]) * share)
            worst_before = max(worst_before, abs(series[first + order - 1]) * share)
    step = ENDLESS
    if worst > 0.0:
        step = root_of(rtol / worst, order)
    if worst_before > 0.0:
        step = min(step, root_of(rtol / worst_before, order - 1))
    return step


@native
def within_plateau(series: Floats, offset: int, order: int, step: float) -> float:
    """Step over which the argument of tanh or exp keeps within sight of where it is.

    Far from zero they are constant to rounding, and the known terms of their series tell nothing
    of the layer about zero: without a limit a step would jump over it.
    """
    allowed = max(LAYER, PLATEAU * abs(series[offset]))
    while series_scale(series, offset + 1, order - 1, step) * step > allowed:
        step *= 0.75
    return step


@native
def polynomial_step(series: Floats, n: int, n_guards: int, order: int, last: float) -> float:
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


@native
def leading(series: Floats, offset: int, order: int, step: float, known_zeros: int) -> int:
    """First non-vanishing derivative of a switching function: its order + 1, with its sign.

    0 when all vanish. `step` is the time over which derivatives are compared; without one (0)
    the first that is not exactly zero counts.
    """
    scale = series_scale(series, offset, order, step)
    if step == 0.0:
        step, scale = 1.0, 0.0
    power = 1.0
    for k in range(order):
        term = series[offset + k] * power
        tolerance = (ZERO if k == 0 else VANISHING) * scale
        if k >= known_zeros and abs(term) > tolerance:
            return k + 1 if term > 0.0 else -k - 1
        power *= step
    return 0


@native
def fill(run: Run) -> None:
    """Compute the coefficients, unless they are those of these slip signs and this sector."""
    contacts, end = run.config[N_CONTACTS], run.config[N_PARAMETERS] - 1
    wanted = 1.0 + run.parameters[end]
    for i in range(contacts):
        wanted = 2.0 * wanted + (1.0 if run.parameters[end - contacts + i] > 0.0 else 0.0)
    if run.clock[FILLED_FOR] != wanted:
        call_generated(
            run.config[COEFFICIENTS], run.coefficients, 0.0, run.parameters, run.coefficients
        )
        run.clock[FILLED_FOR] = wanted


@native
def zeros_at_start(run: Run, index: int, guard: int) -> int:
    """How many of a switching function's value and rate are zero to rounding: 0, 1 or 2.

    Rounding is a share of what the states, one after the other, add to it.
    """
    n, order = run.config[N_STATES], run.config[ORDER]
    taylor, t, zeros = run.table[index, TAYLOR], run.clock[TIME], 0
    while zeros < 2:
        place, scale = (n + guard) * (order + 1) + zeros, 0.0
        call_generated(taylor, run.coefficients, t, run.y, run.work)
        value = run.work[place]
        for i in range(n):
            state = run.y[i]
            if value != 0.0 and state != 0.0:
                run.y[i] = 0.0
                call_generated(taylor, run.coefficients, t, run.y, run.work)
                scale += abs(run.work[place] - value)
                run.y[i] = state
        if not abs(value) <= LAST_DIGITS * scale:
            return zeros
        zeros += 1
    return zeros


@native
def consistent(run: Run, trigger_kind: int, trigger_contact: int, lenient: bool) -> bool:
    """Whether a candidate contact state can follow: every switching function leads positive.

    `lenient` leaves out that another contact opens or closes at the same instant, or that this
    one loses its normal force together with its capacity: the next event, chained to this one.
    """
    n, order, contacts = run.config[N_STATES], run.config[ORDER], run.config[N_CONTACTS]
    index = state_index(run.kinds, contacts)
    if run.table[index, TAYLOR] == 0:
        return False
    fill(run)
    call_generated(run.table[index, TAYLOR], run.coefficients, run.clock[TIME], run.y, run.series)
    rows = n + run.table[index, N_GUARDS] + run.table[index, HAS_ANGLE]
    step = step_size(run.series, rows, order, run.tolerances[RTOL], run.clock[LAST_STEP])
    for i in range(run.table[index, N_ARGUMENTS]):
        step = within_plateau(run.series, (rows + i) * (order + 1), order, step)
    run.clock[FIRST_STEP] = step
    if step == ENDLESS:  # a motion that is a polynomial has no time scale of its own
        step = run.clock[LAST_STEP] if run.clock[LAST_STEP] > 0.0 else 0.0
    for g in range(run.table[index, N_GUARDS]):
        kind, contact = run.guards[index, g, 0], run.guards[index, g, 1]
        known_zeros = 0
        if kind == VELOCITY and run.options[contact, AT_REST] == 1:
            known_zeros = 1
        if kind == trigger_kind and contact == trigger_contact:
            known_zeros = 1
        if kind == GAP and trigger_kind == NORMAL and contact == trigger_contact:
            known_zeros = 1
        if run.clock[TASK] == ENTER and (kind == GAP or kind == NORMAL):
            known_zeros = zeros_at_start(run, index, g)
        if kind == VELOCITY and contact == trigger_contact:
            sign = run.parameters[run.config[N_PARAMETERS] - 1 - contacts + contact]
            released = trigger_kind == (CAPACITY_UP if sign > 0.0 else CAPACITY_DOWN)
            if released and run.series[(n + g) * (order + 1) + 1] < 0.0:
                known_zeros = 2  # slip friction does not exceed the capacity: this is rounding
        lead = leading(run.series, (n + g) * (order + 1), order, step, known_zeros)
        if lenient and kind == NORMAL and trigger_kind == GAP and contact == trigger_contact:
            # the last of ever shorter flights: the open contact finds no gap rate left, this one
            # a force, or a rate of it, that is negative by rounding
            offset = (n + g) * (order + 1)
            rounding = VANISHING * series_scale(run.series, offset, order, step)
            if lead == -2 or (lead == -1 and run.series[offset] >= -rounding):
                lead = leading(run.series, offset, order, step, 2)
        opens = kind == NORMAL or kind == GAP
        if contact == trigger_contact:
            opens = kind == NORMAL and trigger_kind < NORMAL
        at_zero = lead < -1
        if lead < 0 and not (lenient and opens and at_zero):
            return False
        # A function that is zero throughout (a capacity that stays just reached) has no root.
        run.strips[g] = max(lead - 1, 0) if lead != 0 else order + 1
    return True


@native
def contact_outputs(table: Ints2, index: int, n: int) -> int:
    """Where the contact outputs begin in the field output."""
    return 2 * n + table[index, N_GUARDS] + table[index, HAS_ANGLE]


@native
def slip_velocity(run: Run, y: Floats, contact: int) -> float:
    """v_rel of a contact; zero when it is zero to rounding."""
    n, contacts = run.config[N_STATES], run.config[N_CONTACTS]
    index, field = state_index(run.kinds, contacts), run.stages[0]
    call_generated(run.table[index, FIELD], run.coefficients, run.clock[TIME], y, field)
    v = field[contact_outputs(run.table, index, n) + PER_CONTACT * contact + 2]
    scale = 0.0
    for i in range(run.config[N_COORDINATES], n):
        scale += abs(y[i])
    return 0.0 if abs(v) <= ZERO * scale else v


@native
def offer(options: Ints2, contact: int, kind: int, sign: int) -> None:
    """Add a candidate state of a contact."""
    place = OFFERS + 2 * options[contact, COUNT]
    options[contact, place], options[contact, place + 1] = kind, sign
    options[contact, COUNT] += 1


@native
def decide(run: Run, trigger_kind: int, trigger_contact: int, grazing: bool) -> bool:
    """Choose the contact state that follows at (t, y); False when none is consistent.

    Selection rule where several are consistent (stiction is not unique at zero slip): sticking
    before slipping, staying closed before separating, and all contacts jointly; contacts that did
    not trigger stay as they are if they can. `grazing` says that the switching function that
    triggered may only touch zero, so staying is a candidate.
    """
    contacts = run.config[N_CONTACTS]
    first_sign = run.config[N_PARAMETERS] - 1 - contacts
    combinations = 1
    for i in range(contacts):
        sign = 1 if run.parameters[first_sign + i] > 0.0 else -1
        triggered = trigger_contact == i
        run.options[i, COUNT], run.options[i, AT_REST] = 0, 0
        if run.kinds[i] == SEPARATION and not (triggered and trigger_kind == GAP):
            offer(run.options, i, SEPARATION, sign)
            continue
        if run.kinds[i] == STICK or (triggered and trigger_kind == VELOCITY):
            run.options[i, AT_REST] = 1
        else:  # re-contact, or a slip that ends at the same instant
            v = slip_velocity(run, run.y, i)
            run.options[i, AT_REST] = 1 if v == 0.0 else 0
            if run.kinds[i] == SEPARATION and v != 0.0 and run.options[i, ONE_WAY] == 0:
                sign = 1 if v > 0.0 else -1
        released = triggered and (trigger_kind == CAPACITY_UP or trigger_kind == CAPACITY_DOWN)
        if released and not grazing:  # the demanded force passes the capacity: it slips its way
            offer(run.options, i, SLIP, 1 if trigger_kind == CAPACITY_UP else -1)
            combinations *= run.options[i, COUNT]
            continue
        # What triggers falls through zero, unless it grazes: it cannot stay as it was.
        passes = triggered and not grazing
        if not (passes and trigger_kind == NORMAL):
            if run.options[i, AT_REST] == 1:
                offer(run.options, i, STICK, sign)
            if not (passes and trigger_kind == VELOCITY):
                offer(run.options, i, SLIP, sign)
            if run.options[i, AT_REST] == 1:
                offer(run.options, i, SLIP, -sign)
        if trigger_kind < 0 or (triggered and (trigger_kind == GAP or trigger_kind == NORMAL)):
            offer(run.options, i, SEPARATION, sign)
        combinations *= run.options[i, COUNT]
    begin = 0
    if trigger_kind == GAP and run.counters[CHAINED] > SHORT_FLIGHTS:
        begin = combinations
    for attempt in range(begin, 2 * combinations):
        rest = attempt % combinations
        for place in range(contacts, -1, -1):  # the contact that triggered first: others stay
            i = trigger_contact if place == contacts else place
            if i < 0 or (i == trigger_contact and place < contacts):
                continue
            pick = rest % run.options[i, COUNT]
            rest //= run.options[i, COUNT]
            run.kinds[i] = run.options[i, OFFERS + 2 * pick]
            run.parameters[first_sign + i] = run.options[i, OFFERS + 2 * pick + 1]
        if consistent(run, trigger_kind, trigger_contact, attempt >= combinations):
            return True
    return False


@native
def state_after(run: Run, index: int, t: float, x: float, out: Floats) -> None:
    """State a time x into the step that begins at (t, y)."""
    n = run.config[N_STATES]
    if run.config[METHOD] == METHOD_TAYLOR:
        call_generated(run.config[STATE], run.coefficients, x, run.series, out)
        return
    field, inner = run.stages[0], run.stages[1]
    call_generated(run.table[index, FIELD], run.coefficients, t, run.y, field)
    for i in range(n):  # stage by stage: classical Runge-Kutta of order 4 (thesis 3.39, 3.40)
        out[i] = field[i] + x / 6.0 * field[n + i]
        inner[i] = field[i] + 0.5 * x * field[n + i]
    start = run.stages[2]
    for i in range(n):
        start[i] = field[i]
    call_generated(run.table[index, FIELD], run.coefficients, t + 0.5 * x, inner, field)
    for i in range(n):
        out[i] += x / 3.0 * field[n + i]
        inner[i] = start[i] + 0.5 * x * field[n + i]
    call_generated(run.table[index, FIELD], run.coefficients, t + 0.5 * x, inner, field)
    for i in range(n):
        out[i] += x / 3.0 * field[n + i]
        inner[i] = start[i] + x * field[n + i]
    call_generated(run.table[index, FIELD], run.coefficients, t + x, inner, field)
    for i in range(n):
        out[i] += x / 6.0 * field[n + i]
    call_generated(run.table[index, FIELD], run.coefficients, t + x, out, field)
    for i in range(n):
        out[i] = field[i]  # constrained entries exactly


@native
def bisected(
    run: Run,
    index: int,
    t: float,
    step: float,
    out: Floats,
    entry: int,
    factor: float,
    shift: float,
) -> float:
    """Where ``factor * (output entry) + shift`` falls to zero in a step, by bisection (rk4).

    NO_ROOT when it is positive at the end of the step; entries count in the field output.
    """
    state_after(run, index, t, step, out)
    call_generated(run.table[index, FIELD], run.coefficients, t + step, out, run.stages[0])
    if factor * run.stages[0, entry] + shift > 0.0:
        return NO_ROOT
    low, high = 0.0, step
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        state_after(run, index, t, middle, out)
        call_generated(run.table[index, FIELD], run.coefficients, t + middle, out, run.stages[0])
        if factor * run.stages[0, entry] + shift > 0.0:
            low = middle
        else:
            high = middle
    return high / step


@inlined
def located(
    run: Run, offset: int, order: int, step: float, strip: int, factor: float, shift: float
) -> float:
    """First root of ``factor * series + shift`` over a step, as a fraction of it (Taylor)."""
    power = factor
    for _ in range(strip):  # the first coefficients are known zeros
        power *= step
    start = power * run.series[offset + strip] + (shift if strip == 0 else 0.0)
    run.polynomial[0] = start
    # Two chains of sums, half as long: the length of a chain is what a step waits for.
    total, end, odd_total, odd_end = abs(start), start, 0.0, 0.0
    first, last, square = offset + strip, order - strip, step * step
    odd_power = power * step
    for k in range(1, last, 2):
        power *= square
        odd, even = run.series[first + k] * odd_power, run.series[first + k + 1] * power
        odd_power *= square
        run.polynomial[k], run.polynomial[k + 1] = odd, even
        odd_total += abs(odd)
        odd_end += odd
        total += abs(even)
        end += even
    if last % 2 == 1:
        odd = run.series[first + last] * odd_power
        run.polynomial[last] = odd
        odd_total += abs(odd)
        odd_end += odd
    for k in range(last + 1, order + 1):
        run.polynomial[k] = 0.0
    return first_root(
        run.polynomial,
        last,
        total + odd_total,
        end + odd_end,
        run.config[VALUE_AND_SLOPE],
        run.config[BERNSTEIN],
        order,
        run.pieces,
    )


@native
def touched(
    run: Run, index: int, hit: int, tau: float, step: float, scale: float, out: Floats
) -> float:
    """Where a switching function that barely falls is least, if it only touches zero there.

    Its series may dip below zero by the error of the series, and pass zero a little before. What
    the function itself is where it turns decides. Otherwise `tau`, where it passes. The field
    output (stages[0]) is left as it is at the time returned.
    """
    n, order, field = run.config[N_STATES], run.config[ORDER], run.stages[0]
    offset = (n + hit) * (order + 1)
    slope, bend, power = run.series[offset + 1], 0.0, 1.0
    for k in range(2, order + 1):
        bend += k * (k - 1.0) * run.series[offset + k] * power
        power *= tau
        slope += k * run.series[offset + k] * power
    if slope >= 0.0 or bend <= 0.0 or tau - slope / bend > step:
        return tau
    least = tau - slope / bend
    t = run.clock[TIME]
    call_generated(run.config[STATE], run.coefficients, least, run.series, out)
    call_generated(run.table[index, FIELD], run.coefficients, t + least, out, field)
    if field[2 * n + hit] >= -ZERO * scale:
        return least
    call_generated(run.config[STATE], run.coefficients, tau, run.series, out)
    call_generated(run.table[index, FIELD], run.coefficients, t + tau, out, field)
    return tau


@native
def take_samples(run: Run, index: int, tau: float, out: Floats) -> None:
    """Record the samples that fall into the step of length tau."""
    n, contacts = run.config[N_STATES], run.config[N_CONTACTS]
    first_sign = run.config[N_PARAMETERS] - 1 - contacts
    first = contact_outputs(run.table, index, n)
    t = run.clock[TIME]
    while (
        run.counters[SAMPLED] < len(run.sample_times)
        and run.sample_times[run.counters[SAMPLED]] <= t + tau
    ):
        row = run.counters[SAMPLED]
        x = min(max(run.sample_times[row] - t, 0.0), tau)
        state_after(run, index, t, x, out)
        call_generated(run.table[index, FIELD], run.coefficients, t + x, out, run.stages[0])
        for i in range(n):
            run.sample_states[row, i] = run.stages[0, i]
        for i in range(PER_CONTACT * contacts + N_ENERGIES):
            run.sample_outputs[row, i] = run.stages[0, first + i]
        for i in range(contacts):
            run.sample_codes[row, i] = code_of(run.kinds[i], run.parameters[first_sign + i])
        run.counters[SAMPLED] += 1


@native
def take_measures(run: Run, index: int, tau: float, end: Floats) -> None:
    """Integrate the measures along the step of length tau, which ends at the state `end`.

    Where the reference is NaN the coordinate does not count. extremes is (3, n): least and
    greatest value, integral of the square; shares is (contacts, 3): time in slip, stick,
    separation.
    """
    n, contacts, t = run.config[N_STATES], run.config[N_CONTACTS], run.clock[TIME]
    energies = contact_outputs(run.table, index, n) + PER_CONTACT * contacts
    run.measures[M_TIME] += tau
    for i in range(contacts):
        run.shares[i, run.kinds[i]] += tau
    count = nodes_needed(run, tau)
    first, x = count * (count - 1) // 2, 0.0
    for node in range(count):
        last_x, x = x, run.quadrature[first + node, 0] * tau
        weight = run.quadrature[first + node, 1] * tau
        here = run.stages[5 + node % 2]
        if node == 0:
            call_generated(run.table[index, FIELD], run.coefficients, t, run.y, here)
        elif node == count - 1:
            call_generated(run.table[index, FIELD], run.coefficients, t + x, end, here)
        else:
            state_after(run, index, t, x, run.stages[4])
            call_generated(run.table[index, FIELD], run.coefficients, t + x, run.stages[4], here)
        for i in range(n):
            value = here[i]
            run.extremes[0, i] = min(run.extremes[0, i], value)
            run.extremes[1, i] = max(run.extremes[1, i], value)
            run.extremes[2, i] += weight * value * value
        for i in range(run.config[N_COORDINATES]):
            if run.reference[i] == run.reference[i]:
                off = here[i] - run.reference[i]
                run.measures[M_SPREAD] += weight * (off * off)
        run.measures[M_OTHER] += weight * here[energies + OTHER_POWER]
        run.measures[M_FRICTION] += weight * here[energies + FRICTION_POWER]
        run.measures[M_DRIVE] += weight * here[energies + DRIVE_POWER]
        if node > 0 and run.config[METHOD] == METHOD_TAYLOR:
            look_for_turns(run, run.stages[6 - node % 2], here, last_x, x)


@native
def nodes_needed(run: Run, tau: float) -> int:
    """Nodes of the quadrature that integrates over this part of a step to rounding."""
    count = FEWEST_NODES
    share = tau / run.clock[LAST_STEP]
    while run.quadrature[count * (count - 1) // 2, 2] < share:
        count += 1
    return count


@native
def look_for_turns(run: Run, before: Floats, after: Floats, low: float, high: float) -> None:
    """Extremes that lie between two nodes, whose field outputs are given.

    Only a turn that can pass the extreme known so far is located.
    """
    n, order = run.config[N_STATES], run.config[ORDER]
    for i in range(n):
        rise, fall = before[n + i], after[n + i]
        if rise * fall < 0.0:
            reach = (abs(rise) + abs(fall)) * (high - low)
            if rise > 0.0:
                if max(before[i], after[i]) + reach > run.extremes[1, i]:
                    value = turning_value(run, i * (order + 1), low, high, rise, fall)
                    run.extremes[1, i] = max(run.extremes[1, i], value)
            elif min(before[i], after[i]) - reach < run.extremes[0, i]:
                value = turning_value(run, i * (order + 1), low, high, rise, fall)
                run.extremes[0, i] = min(run.extremes[0, i], value)


@native
def turning_value(
    run: Run, offset: int, low: float, high: float, at_low: float, at_high: float
) -> float:
    """Value of a series where it turns, between two times at which its slope is known.

    Secant steps on the slope, kept inside the bracket. About the turn the value is a parabola: what
    the last step would still change of it is half of slope times step.
    """
    series, found = run.series[offset:], run.polynomial
    enough = TURNED * (abs(at_low) + abs(at_high)) * (high - low)
    x, before, at_before = chord(low, high, at_low, at_high), high, at_high
    change = 0.0
    for _ in range(BISECTIONS):
        call_generated(run.config[VALUE_AND_SLOPE], series, x, series, found)
        slope = found[1]
        if slope * at_low > 0.0:
            low = x
        else:
            high = x
        new = x - slope * (x - before) / (slope - at_before)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        change = 0.5 * slope * (new - x)
        if abs(change) <= enough:
            break
        x, before, at_before = new, x, slope
    return found[0] + change


@native
def move_tangents(run: Run, index: int, tau: float, joined: Floats) -> None:
    """Carry the tangent vectors (rows) over a step of length tau, in the parts that they need.

    The step was chosen for the motion. A tangent has modes that the motion may leave at rest, and
    where these are fast its series needs shorter steps.
    """
    n, order, t = run.config[N_STATES], run.config[TANGENT_ORDER], run.clock[TIME]
    c, moved, series = run.coefficients, run.table[index, MOVED], run.work
    tangent, series_of_tangent = joined[n:], run.work[n * (order + 1) :]
    for row in range(run.tangents.shape[0]):
        for i in range(n):
            joined[i] = run.y[i]
            tangent[i] = run.tangents[row, i]
        done = 0.0
        while done < tau:
            call_generated(run.table[index, TANGENT], c, t + done, joined, series)
            rest = tau - done
            part = step_size(series, 2 * n, order, run.tolerances[RTOL], rest)
            if part >= rest or done + part == done:
                part, done = rest, tau
            else:
                done += part
                call_generated(moved, c, part, series, joined)
            call_generated(moved, c, part, series_of_tangent, tangent)
        for i in range(n):
            run.tangents[row, i] = tangent[i]


@native
def switching_rates(
    run: Run, index: int, entry: int, joined: Floats, rates: Floats, delays: Floats
) -> None:
    """At an event: the rates before it, and by how much each tangent delays it.

    A trajectory displaced by a tangent vector d meets the switching function g later by
    -dg(d) / g'; what the delay does to the state after the event is `saltate`'s.
    """
    n = run.config[N_STATES]
    outputs = run.table[index, N_GUARDS] + run.table[index, HAS_ANGLE]
    for row in range(run.tangents.shape[0]):
        for i in range(n):
            joined[i] = run.y[i]
            joined[n + i] = run.tangents[row, i]
        call_generated(
            run.table[index, SWITCHING], run.coefficients, run.clock[TIME], joined, run.work
        )
        for i in range(n):  # rows of value and rate: y, tangent, switching, tangent of switching
            rates[i] = run.work[2 * i + 1]
        speed = run.work[2 * (2 * n + entry) + 1]
        change = run.work[2 * (2 * n + outputs + entry)]
        delays[row] = -change / speed if speed != 0.0 else 0.0


@native
def strike(run: Run, impact: int, joined: Floats, rates: Floats) -> None:
    """Tangents through an impact y -> R(y, t): D R d; `rates` becomes dR/dt along the flow.

    With it `saltate` adds (dR/dt - f_after) delay, as it does at events without an impact.
    """
    n = run.config[N_STATES]
    for row in range(run.tangents.shape[0]):
        for i in range(n):
            joined[i] = run.y[i]
            joined[n + i] = run.tangents[row, i]
        call_generated(impact, run.coefficients, run.clock[TIME], joined, run.work)
        for i in range(n):  # rows of value and rate: y, tangent, R, tangent of R
            rates[i] = run.work[2 * (2 * n + i) + 1]
            run.tangents[row, i] = run.work[2 * (3 * n + i)]


@native
def saltate(run: Run, rates: Floats, delays: Floats) -> None:
    """Tangents after an event: d + (f_before - f_after) delay; `series` is the new state's."""
    order = run.config[ORDER]
    for row in range(run.tangents.shape[0]):
        for i in range(run.config[N_STATES]):
            after = run.series[i * (order + 1) + 1]
            run.tangents[row, i] += (rates[i] - after) * delays[row]


@native
def rounding_of_angle(border: float) -> float:
    """How close to a border of the sector an angle is on it."""
    return ZERO * (2.0 * np.pi + abs(border))


@native
def enter_zone(run: Run, angle: float) -> bool:
    """Set the sector that `angle` lies in and its borders; whether it lies on the lower one.

    On a border, to rounding, it is the sector above it; what moves down goes on below.
    """
    run.clock[ZONE_LOW], run.clock[ZONE_HIGH] = -np.inf, np.inf
    zone_slot = run.config[N_PARAMETERS] - 1
    run.parameters[zone_slot] = 0.0
    if run.config[ZONE_START] < 0:
        return False
    width = run.parameters[run.config[ZONE_WIDTH]]
    if width <= 0.0:
        return False
    turn = 2.0 * np.pi
    if width >= turn:
        run.parameters[zone_slot] = 1.0
        return False
    start = run.parameters[run.config[ZONE_START]]
    rounding = rounding_of_angle(angle)
    base = start + turn * np.floor((angle - start) / turn)
    if angle - base >= turn - rounding:
        base += turn
    if angle - base < width - rounding:
        run.parameters[zone_slot] = 1.0
        run.clock[ZONE_LOW], run.clock[ZONE_HIGH] = base, base + width
    else:
        run.clock[ZONE_LOW], run.clock[ZONE_HIGH] = base + width, base + turn
    return angle - run.clock[ZONE_LOW] <= rounding


@native
def starts_open(run: Run, contact: int) -> bool:
    """Whether a contact begins open: a gap, or none but one that is about to be."""
    n, order = run.config[N_STATES], run.config[ORDER]
    apart = len(run.table) - 1  # the state in which every contact is open
    if run.table[apart, TAYLOR] == 0:
        return False
    for g in range(run.table[apart, N_GUARDS]):
        if run.guards[apart, g, 0] == GAP and run.guards[apart, g, 1] == contact:
            zeros = zeros_at_start(run, apart, g)
            call_generated(
                run.table[apart, TAYLOR], run.coefficients, run.clock[TIME], run.y, run.series
            )
            return zeros < 2 and run.series[(n + g) * (order + 1) + zeros] > 0.0
    return False


@native
def set_out(run: Run) -> bool:
    """Slip signs, contacts at rest and open ones, and the sector, of the initial state.

    A contact whose kind is STICK takes on the drive's velocity. Returns whether the angle lies on
    the lower border of its sector.
    """
    n, contacts = run.config[N_STATES], run.config[N_CONTACTS]
    first_sign = run.config[N_PARAMETERS] - 1 - contacts
    field, rest, velocities = run.stages[0], run.stages[4], run.stages[5]
    for i in range(contacts):
        if run.kinds[i] == STICK:
            index = state_index(run.kinds, contacts)
            call_generated(run.table[index, FIELD], run.coefficients, run.clock[TIME], run.y, field)
            for k in range(n):
                run.y[k] = field[k]
            break
    for i in range(contacts):
        is_open = starts_open(run, i)
        run.kinds[i] = SEPARATION if is_open else SLIP
    index = state_index(run.kinds, contacts)
    call_generated(run.table[index, FIELD], run.coefficients, run.clock[TIME], run.y, field)
    for k in range(n):
        run.y[k] = field[k]  # a rigid contact takes up its gap
        rest[k] = 0.0
    for i in range(contacts):
        velocities[i] = slip_velocity(run, run.y, i)
    for i in range(contacts):
        if run.kinds[i] == SLIP:
            smooth, direction = run.options[i, ONE_WAY] == 1, velocities[i]
            if smooth:  # the way it slides when the system is at rest
                direction = slip_velocity(run, rest, i)
            run.parameters[first_sign + i] = -1.0 if direction < 0.0 else 1.0
            if velocities[i] == 0.0 and not smooth:
                run.kinds[i] = STICK
    angle = 0.0
    if run.table[0, HAS_ANGLE] == 1:
        call_generated(run.table[0, FIELD], run.coefficients, run.clock[TIME], run.y, field)
        angle = field[2 * n + run.table[0, N_GUARDS]]
    return enter_zone(run, angle)


@native
def away_from_border(
    series: Floats, offset: int, order: int, step: float, factor: float, shift: float
) -> int:
    """Known zeros of ``factor * series + shift`` that begins at zero and rises; 0 otherwise."""
    value = factor * series[offset] + shift
    if abs(value) > rounding_of_angle(shift):
        return 0
    scale = series_scale(series, offset + 1, order - 1, step) * step
    power = step
    for k in range(1, order):
        term = factor * series[offset + k] * power
        if abs(term) > VANISHING * scale:
            return k if term > 0.0 else 0
        power *= step
    return 0


@native
def cross_border(run: Run, upwards: bool) -> None:
    """Enter the neighbouring sector."""
    zone_slot = run.config[N_PARAMETERS] - 1
    width = run.parameters[run.config[ZONE_WIDTH]]
    run.parameters[zone_slot] = 1.0 - run.parameters[zone_slot]
    span = width if run.parameters[zone_slot] == 1.0 else 2.0 * np.pi - width
    if upwards:
        run.clock[ZONE_LOW] = run.clock[ZONE_HIGH]
        run.clock[ZONE_HIGH] = run.clock[ZONE_LOW] + span
    else:
        run.clock[ZONE_HIGH] = run.clock[ZONE_LOW]
        run.clock[ZONE_LOW] = run.clock[ZONE_HIGH] - span


@native
def keep_section(run: Run) -> None:
    """Put the present state into the section buffer."""
    row = run.counters[SECTIONS]
    run.section_times[row] = run.clock[TIME]
    for i in range(len(run.y)):
        run.section_states[row, i] = run.y[i]
    run.counters[SECTIONS] += 1


@native
def begin_step(run: Run, index: int) -> float:
    """Length of the step from where the motion is; its series are at hand afterwards."""
    n, order, rows = run.config[N_STATES], run.config[ORDER], 0
    if run.config[METHOD] != METHOD_TAYLOR:
        run.clock[LAST_STEP] = run.tolerances[FIXED_STEP]
        return run.tolerances[FIXED_STEP]
    step = run.clock[FIRST_STEP]
    run.clock[FIRST_STEP] = 0.0
    if step == 0.0:
        call_generated(
            run.table[index, TAYLOR], run.coefficients, run.clock[TIME], run.y, run.series
        )
        rows = n + run.table[index, N_GUARDS] + run.table[index, HAS_ANGLE]
        step = step_size(run.series, rows, order, run.tolerances[RTOL], run.clock[LAST_STEP])
        for i in range(run.table[index, N_ARGUMENTS]):
            step = within_plateau(run.series, (rows + i) * (order + 1), order, step)
        for i in range(n):
            run.y[i] = run.series[i * (order + 1)]
    if step < ENDLESS:
        run.clock[LAST_STEP] = step
        return step
    return polynomial_step(run.series, n, run.table[index, N_GUARDS], order, run.clock[LAST_STEP])


@native
def on_section(run: Run, value: float, step: float) -> bool:
    """Whether the section's state is zero to rounding, where it has this value in a step."""
    if run.section[SECTION_KIND] != SECTION_ZERO or run.config[METHOD] != METHOD_TAYLOR:
        return False
    order = run.config[ORDER]
    offset = run.section[SECTION_STATE] * (order + 1)
    return abs(value) <= ZERO * series_scale(run.series, offset, order, step)


@native
def coincides(run: Run, hit: int, step: float, root: float, fraction: float) -> bool:
    """Whether the section is met on an event: the slip velocity may be the section's state."""
    if hit < 0 or fraction - root > SAME_INSTANT:
        return False
    order = run.config[ORDER]
    offset = run.section[SECTION_STATE] * (order + 1)
    return on_section(run, series_value(run.series, offset, order, fraction * step), step)


@native
def first_fall(run: Run, index: int, step: float) -> tuple[int, float, float, float]:
    """The first switching function to fall to zero in a step.

    Its number (-1: none), as a fraction of the step when, and of a section its sign before and
    the sense in which it passes. In order: the contact state's own, the two borders of the
    sector, the section.
    """
    n, order, taylor = run.config[N_STATES], run.config[ORDER], run.config[METHOD] == METHOD_TAYLOR
    n_guards, last, t = run.table[index, N_GUARDS], len(run.strips) - 1, run.clock[TIME]
    fraction, hit, crossing, sign_before = 1.0, -1, 0.0, 0.0
    for check in range(n_guards + 3):
        factor, shift, strip = 1.0, 0.0, 0
        if check < n_guards:
            row, entry, strip = n + check, 2 * n + check, run.strips[check]
            if strip > order:
                continue
        elif check < n_guards + 2:
            if run.table[index, HAS_ANGLE] == 0 or run.clock[ZONE_HIGH] == np.inf:
                continue
            row, entry = n + n_guards, 2 * n + n_guards
            upper = check == n_guards
            factor = -1.0 if upper else 1.0
            shift = run.clock[ZONE_HIGH] if upper else -run.clock[ZONE_LOW]
            strip = run.strips[last - 2] if upper else run.strips[last - 1]
            if taylor:
                leaving = away_from_border(
                    run.series, row * (order + 1), order, step, factor, shift
                )
                strip = max(strip, leaving)
        else:
            if run.section[SECTION_KIND] != SECTION_ZERO:
                continue
            entry = run.section[SECTION_STATE]
            row, strip = entry, min(run.strips[last], order)
            if taylor:
                while strip < order and run.series[row * (order + 1) + strip] == 0.0:
                    strip += 1
                value = run.series[row * (order + 1) + strip] if strip < order else 0.0
            else:
                value = run.y[entry] if strip == 0 else 0.0
                if value == 0.0:
                    state_after(run, index, t, 0.5 * fraction * step, run.stages[3])
                    value = run.stages[3, entry]
            if value == 0.0:  # it stays at zero: a mass that sticks to a drive at rest
                continue
            factor = 1.0 if value > 0.0 else -1.0
            sign_before = factor
        if taylor:
            root = located(run, row * (order + 1), order, step, strip, factor, shift)
        else:
            root = bisected(run, index, t, step, run.stages[3], entry, factor, shift)
        if check < n_guards + 2:
            if root < fraction or (root == 1.0 and hit < 0):
                fraction, hit = root, check
        elif 0.0 < root < fraction and not coincides(run, hit, step, root, fraction):
            fraction, hit, crossing = root, check, -factor
    return hit, fraction, sign_before, crossing


@native
def polished(
    run: Run, index: int, hit: int, tau: float, step: float, out: Floats
) -> tuple[float, float, bool]:
    """When an event is (a time into the step), its residual, whether it may be a touch.

    The root that was found is that of the switching function's series; Newton steps on the
    function itself, along the state's series, take it to rounding. `out` becomes the state there.
    """
    n, order, field, t = run.config[N_STATES], run.config[ORDER], run.stages[0], run.clock[TIME]
    residual = 0.0
    scale, fall = scale_and_slope(run.series, (n + hit) * (order + 1), order, step, tau)
    grazing = scale == 0.0 or fall * step > -GRAZING * scale
    enough = max(ROUNDING, EXACT * run.tolerances[RTOL])
    for polish in range(POLISHES):
        call_generated(run.table[index, FIELD], run.coefficients, t + tau, out, field)
        value = field[2 * n + hit]
        residual = abs(value) / scale if scale > 0.0 else 0.0
        if grazing or residual <= enough or polish == POLISHES - 1:
            break
        tau += max(-value / fall, -tau)
        call_generated(run.config[STATE], run.coefficients, tau, run.series, out)
    if grazing and scale > 0.0:
        tau = touched(run, index, hit, tau, step, scale, out)
    for i in range(n):
        out[i] = field[i]  # entries that the contact determines: exactly
    return tau, residual, grazing


@native
def collide(run: Run, index: int, contact: int, joined: Floats, rates: Floats) -> None:
    """An impact, if the contact's state has one; books the energy that it takes."""
    n, contacts = run.config[N_STATES], run.config[N_CONTACTS]
    field, out, t = run.stages[0], run.stages[3], run.clock[TIME]
    kinetic = contact_outputs(run.table, index, n) + PER_CONTACT * contacts + KINETIC
    call_generated(run.table[index, FIELD], run.coefficients, t, run.y, field)
    before = field[kinetic]
    if len(run.tangents) > 0:
        strike(run, run.impacts[index, contacts + contact], joined, rates)
    call_generated(run.impacts[index, contact], run.coefficients, t, run.y, out)
    for i in range(n):
        run.y[i] = out[i]
    call_generated(run.table[index, FIELD], run.coefficients, t, run.y, field)
    run.measures[M_IMPACT] += before - field[kinetic]
    run.counters[IMPACTS] += 1


@native
def section_at_event(run: Run, sign_before: float, is_met: bool) -> None:
    """Whether the section lies on the event, and is to be kept.

    It is where the state passes zero, and where it comes to stay at zero: when it goes on from
    there (`sign_before` is 0) it does not count again.
    """
    order, entry = run.config[ORDER], run.section[SECTION_STATE]
    offset, step = entry * (order + 1), run.clock[LAST_STEP]
    if not is_met and abs(run.y[entry]) > ZERO * series_scale(run.series, offset, order, step):
        return
    lead = leading(run.series, offset, order, step, 1)
    run.strips[len(run.strips) - 1] = abs(lead) - 1 if lead != 0 else order + 1
    wanted = run.section[SECTION_DIRECTION]
    passes = sign_before != 0.0 and sign_before * lead <= 0.0
    if passes and (wanted == 0 or wanted == -sign_before):
        keep_section(run)
        run.section_states[run.counters[SECTIONS] - 1, entry] = 0.0


@native
def book_event(run: Run, contact: int, itself: bool, residual: float) -> None:
    """Enter what changed into ledger and section; `itself`: `contact` counts in any case."""
    first_sign = run.config[N_PARAMETERS] - 1 - run.config[N_CONTACTS]
    events = run.counters[EVENTS]
    for i in range(run.config[N_CONTACTS]):
        before = run.options[i, BEFORE]
        after = code_of(run.kinds[i], run.parameters[first_sign + i])
        if before == after and not (itself and i == contact):
            continue
        run.counters[EVENTS] += 1
        if run.counters[LEDGER] < len(run.ledger):
            row = run.counters[LEDGER]
            run.ledger[row, 0], run.ledger[row, 1] = run.clock[TIME], before
            run.ledger[row, 2], run.ledger[row, 3], run.ledger[row, 4] = after, i, residual
            run.counters[LEDGER] += 1
        if (
            run.section[SECTION_KIND] == SECTION_EVENT
            and i == run.section[SECTION_CONTACT]
            and kind_of(before) == run.section[SECTION_FROM]
            and run.kinds[i] == run.section[SECTION_TO]
        ):
            keep_section(run)
    if run.counters[EVENTS] == events:
        run.counters[GRAZINGS] += 1
    else:
        run.measures[M_RESIDUAL] = max(run.measures[M_RESIDUAL], residual)


@native
def take_up(run: Run) -> None:
    """The state as the contact state just decided has it."""
    for i in range(run.config[N_STATES]):
        run.y[i] = run.series[i * (run.config[ORDER] + 1)]


@native
def heading(run: Run) -> int:
    """The way the sector's angle goes on: the sign of its first non-vanishing derivative, or 0.

    Where the contact sticks, the way it would be released: that of the force demanded of it.
    """
    n, order, contact = run.config[N_STATES], run.config[ORDER], run.config[ZONE_CONTACT]
    index = state_index(run.kinds, run.config[N_CONTACTS])
    step = run.clock[FIRST_STEP] if run.clock[FIRST_STEP] < ENDLESS else 0.0
    if run.table[index, HAS_ANGLE] == 1:
        offset = (n + run.table[index, N_GUARDS]) * (order + 1)
        return leading(run.series, offset + 1, order - 1, step, run.options[contact, AT_REST])
    for k in range(order + 1):
        run.polynomial[k] = 0.0
    for g in range(run.table[index, N_GUARDS]):
        kind, offset = run.guards[index, g, 0], (n + g) * (order + 1)
        if run.guards[index, g, 1] == contact and (kind == CAPACITY_UP or kind == CAPACITY_DOWN):
            sign = 1.0 if kind == CAPACITY_DOWN else -1.0
            for k in range(order + 1):
                run.polynomial[k] += sign * run.series[offset + k]
    return leading(run.polynomial, 0, order, step, 0)


@native
def decide_on_border(run: Run) -> bool:
    """Decide the contact state on the lower border of a sector; False: there is none.

    The motion begins in the sector that it goes on into, above if it stays for ever.
    """
    contacts = run.config[N_CONTACTS]
    first_sign = run.config[N_PARAMETERS] - 1 - contacts
    for i in range(contacts):
        run.options[i, BEFORE] = code_of(run.kinds[i], run.parameters[first_sign + i])
    if decide(run, -1, -1, True) and heading(run) >= 0:
        return True
    cross_border(run, False)
    for i in range(contacts):
        run.kinds[i] = kind_of(run.options[i, BEFORE])
        run.parameters[first_sign + i] = -1.0 if run.options[i, BEFORE] == CODE_SLIP_MINUS else 1.0
    return decide(run, -1, -1, True)


@native
def enter(run: Run) -> bool:
    """Decide the contact state where the motion begins or a force jumps; False: there is none."""
    on_border = run.clock[TASK] == ENTER and set_out(run)
    if not (decide_on_border(run) if on_border else decide(run, -1, -1, True)):
        return False
    take_up(run)
    run.counters[CHAINED] = 0
    run.clock[TASK] = GO_ON
    return True


@native
def advance(run: Run, t_stop: float, phase_interval: float, measuring: bool) -> int:
    """Run until t_stop, a full section buffer, a budget or an end; returns why it stopped."""
    n, contacts = run.config[N_STATES], run.config[N_CONTACTS]
    first_sign = run.config[N_PARAMETERS] - 1 - contacts
    out, joined, rates, delays = run.stages[3], run.stages[4], run.stages[5], run.stages[6]
    with_tangents, last = len(run.tangents) > 0, len(run.strips) - 1
    fill(run)
    if run.clock[TASK] != GO_ON and not enter(run):
        return NO_STATE
    while True:
        t = run.clock[TIME]
        if t >= t_stop:
            return REACHED
        if run.counters[STEPS] >= run.limits[MAX_STEPS]:
            return STEP_BUDGET
        if run.counters[EVENTS] >= run.limits[MAX_EVENTS]:
            return EVENT_BUDGET
        stroboscopic = run.section[SECTION_KIND] == SECTION_PHASE
        if stroboscopic and run.clock[NEXT_PHASE] <= t:  # on an event
            keep_section(run)
            run.clock[NEXT_PHASE] += phase_interval
            if run.counters[SECTIONS] >= run.limits[MAX_SECTIONS]:
                return SECTION_FULL
        # --- the step ---------------------------------------------------------------------------
        run.counters[STEPS] += 1
        index = state_index(run.kinds, contacts)
        n_guards = run.table[index, N_GUARDS]
        goal, reaches_phase = t + begin_step(run, index), False
        if stroboscopic and run.clock[NEXT_PHASE] <= min(goal, t_stop):
            goal, reaches_phase = run.clock[NEXT_PHASE], True
        elif t_stop <= goal:
            goal = t_stop
        step = goal - t
        hit, fraction, sign_before, crossing = first_fall(run, index, step)
        tau = step if hit < 0 else fraction * step
        residual, grazing = 0.0, True
        state_after(run, index, t, tau, out)
        if run.config[METHOD] == METHOD_TAYLOR and 0 <= hit < n_guards:
            tau, residual, grazing = polished(run, index, hit, tau, step, out)
        # --- along the step ---------------------------------------------------------------------
        if run.counters[SAMPLED] < len(run.sample_times):
            take_samples(run, index, tau, joined)
        if measuring:
            take_measures(run, index, tau, out)
        if with_tangents:
            move_tangents(run, index, tau, joined)
        for i in range(n):
            run.y[i] = out[i]
            if not abs(out[i]) < run.tolerances[BOUND]:
                return DIVERGED
        was_on_section = run.strips[last] > 0
        for g in range(last + 1):
            run.strips[g] = 0
        if hit < 0:
            run.clock[TIME] = goal
            run.counters[CHAINED] = 0
            if reaches_phase:
                keep_section(run)
                run.clock[NEXT_PHASE] += phase_interval
                if run.counters[SECTIONS] >= run.limits[MAX_SECTIONS]:
                    return SECTION_FULL
            continue
        run.clock[TIME] = t + tau
        if hit == n_guards + 2:  # only a section: the contact state stays
            run.counters[CHAINED] = 0
            run.strips[last] = 1
            wanted = run.section[SECTION_DIRECTION]
            if wanted == 0 or wanted == crossing:
                run.y[run.section[SECTION_STATE]] = 0.0
                keep_section(run)
                if run.counters[SECTIONS] >= run.limits[MAX_SECTIONS]:
                    return SECTION_FULL
            continue
        # --- an event ---------------------------------------------------------------------------
        run.counters[CHAINED] = run.counters[CHAINED] + 1 if t + tau <= t else 0
        if run.counters[CHAINED] > CHAIN_CAP:
            return CHATTERING
        if was_on_section and fraction <= SAME_INSTANT:  # what led here is counted
            sign_before = 0.0
        is_met = on_section(run, out[run.section[SECTION_STATE]], step)
        border = hit >= n_guards
        trigger_kind, trigger_contact = -1, run.config[ZONE_CONTACT]
        if not border:
            trigger_kind, trigger_contact = run.guards[index, hit, 0], run.guards[index, hit, 1]
        if with_tangents:
            switching_rates(run, index, n_guards if border else hit, joined, rates, delays)
        for i in range(contacts):
            run.options[i, BEFORE] = code_of(run.kinds[i], run.parameters[first_sign + i])
        if trigger_kind == JAMMING:
            return JAMMED
        if trigger_kind == NORMAL and run.ends[trigger_contact] == 1:
            return CONTACT_LOST
        impacted = trigger_kind == GAP and run.impacts[index, trigger_contact] != 0
        if impacted:
            collide(run, index, trigger_contact, joined, rates)
        if border:
            cross_border(run, hit == n_guards)
            fill(run)
            call_generated(
                run.table[index, TAYLOR], run.coefficients, run.clock[TIME], run.y, run.series
            )
            run.clock[FIRST_STEP] = 0.0
            run.strips[last - 1 if hit == n_guards else last - 2] = 1
        elif not decide(run, trigger_kind, trigger_contact, grazing):
            return NO_STATE
        take_up(run)
        if with_tangents:
            saltate(run, rates, delays)
        if run.section[SECTION_KIND] == SECTION_ZERO:
            section_at_event(run, sign_before, is_met)
        book_event(run, trigger_contact, impacted or border, residual)
        if run.counters[SECTIONS] >= run.limits[MAX_SECTIONS]:
            return SECTION_FULL
