"""The driver: contact state machine, event location, sections and measures, for every model.

It knows a model only by addresses of generated functions (`system.py` gives them). All that a run
is, is in its frame, so it can be stopped and taken up again.

One step: the generated code writes the series of the state and of every switching function; the
step is as long as the last coefficients allow; the earliest root of any switching function ends
it. What follows an event is decided by `decide`: of the candidate contact states, sticking ones
first, the first one is taken in which every switching function is positive in the sense of its
first non-vanishing derivative. That single rule covers stick against reversal, release in the
direction of the demanded force, several contacts at once, grazing, re-contact at zero
compression, and transitions that follow one another at one instant.

A law that is given by pieces adds a switching function for each way out of the piece that an
element of it is in. Where one falls the element goes on in the next piece; then, and wherever the
contact state is decided anew, elements whose switching functions fall go on likewise, until none
does.
"""

from __future__ import annotations

import numpy as np

from fiv_cli.codegen.codes import (
    CAPACITY_DOWN,
    CAPACITY_UP,
    CODE_PIECE,
    CODE_SEPARATION,
    CODE_SLIP_MINUS,
    CODE_SLIP_PLUS,
    CODE_STICK,
    GAP,
    JAMMING,
    KINETIC,
    LANES,
    NODES,
    NORMAL,
    OTHER_POWER,
    OWN_POWERS,
    PER_CONTACT,
    PIECE,
    SEPARATION,
    SINGULAR,
    SLIP,
    SLIP_VELOCITY,
    STICK,
    VELOCITY,
)
from fiv_cli.codegen.memory import (
    FixedFloat,
    FixedInt,
    Floats,
    Floats2,
    Ints,
    Ints2,
    OwnFloats,
    OwnInts,
    bits_of,
    call_generated,
    float_of,
    inlined,
    native,
)
from fiv_cli.dynamics.roots import NO_ROOT, Search, chord, first_root

# What `advance` begins with: going on, deciding the contact state anew, or entering it.
GO_ON, DECIDE, ENTER = 0, 1, 2

# What ends up in the section buffer.
SECTION_NONE, SECTION_EVENT, SECTION_ZERO, SECTION_PHASE = 0, 1, 2, 3

ANY = -1  # kind of contact state after the event of a section

# What ends a step, but for the number of a switching function of the contact state.
NOTHING, UPPER_BORDER, LOWER_BORDER, SECTION = -1, -2, -3, -4

# Why `advance` returned.
REACHED, SECTION_FULL, STEP_BUDGET, EVENT_BUDGET = 0, 1, 2, 3
DIVERGED, CONTACT_LOST, NO_STATE, JAMMED, CHATTERING = 4, 5, 6, 7, 8
DEPENDENT, NO_NUMBER = 9, 10
GOING = -1  # ... that it has not yet

ENDLESS = 1e300  # step over which every series is a polynomial
POLYNOMIAL_STEPS = 16.0  # length of a step in stick, in steps of the last slip
FAR_AHEAD = 1000.0  # of such steps to the next event: they are left for one that leads there
AT_LEAST = 1e-6  # of the time: length of a step towards no event
CHAIN_CAP = 50  # transitions at one instant
IN_TURNS = 10  # ... or nearly so, after which contacts that let go in turns do so together
NEARLY_ONE = 4e-15  # relative; times that differ by no more are nearly one instant
SHORT_FLIGHTS = 25  # impacts at one instant after which flights are below rounding: contact stays
PLATEAU = 1.0 / 6.0  # share by which the argument of tanh or exp may change over a step
LAYER = 2.0  # ... and the change that is always allowed
GRAZING = 1e-5  # a switching function that falls slower than this share of its scale may graze
ZERO = 1e-12  # a switching function this small against its scale over a step is at zero
VANISHING = 1e-10  # ... and so is a derivative
LAST_DIGITS = 1e-10  # a gap this small against what states make it up is none at a start
HOP = 1e-7  # a flight of this share of a step rises by less than a gap's rounding can tell
SAME_INSTANT = 1e-9  # two events within this share of a step may be one
BISECTIONS = 80
TURNED = 1e-10  # what is left to a turn, as a share of what a value changes by between two nodes
FEWEST_NODES = 3  # of a quadrature
MANTISSA, BIAS = 2**52, 1023  # of a float's bits: the exponent counts these, from there
SHORTER = 0.75  # a part of a step that does not suit tangents is cut to this share of it
NEGLIGIBLE = 1e-200  # a scale this small is none: quotients by it overflow
ASTRAY = 2.0  # of a step: a Newton step from an event to behind this follows rounding
POLISHES = 4  # looks at a switching function at an event, Newton steps between them
ROUNDING = 1e-16  # a residual, relative to the scale, that no further step improves
EXACT = 1e-6  # ... and that a motion of this share of the tolerance does not notice


class Run(Search):
    """All that a run is: where and how it is, what it is made of, what is asked for.

    A contact state is a combination of the kinds of all contacts, numbered by `state_index`.
    """

    # --- of the system ---
    n_states: FixedInt
    n_coordinates: FixedInt
    n_contacts: FixedInt
    all_sliding: FixedInt  # number of the contact state in which all slide
    most_open: FixedInt  # ... and of that in which all are open that can be
    tangent_order: FixedInt
    is_taylor: FixedInt  # 1; 0: rk4
    # Addresses of generated functions; of one per contact state 0 where there is no such state.
    fill_coefficients: FixedInt
    sum_series: FixedInt  # the state a time into a step
    sum_tangent: FixedInt
    taylor: Ints
    field: Ints
    guards: Ints  # of it, the state and the switching functions
    measured: Ints  # states, rates and powers at several times of a step
    powers: Ints  # ... and the last alone
    followed: Ints  # the same series as `taylor`, and what tangents need of the motion's
    tangent: Ints
    switching_with_tangent: Ints
    impact: Ints2  # by contact state and contact
    impact_with_tangent: Ints2
    # Per contact state: switching functions, whether the sector's angle is watched, arguments of
    # tanh and exp, and where the field output holds (F_N, F_T, v_rel) per contact, and energies.
    n_guards: Ints
    guard_kinds: Ints2
    guard_contacts: Ints2
    guard_places: Ints2  # of pieces: the element, times ways out, and the way out
    has_angle: Ints
    n_arguments: Ints
    contact_place: Ints
    energy_place: Ints
    # Per contact: whether it cannot open (its loss is the end), whether it slips in one sense only,
    # its kind where all slide (a stop is open), whether its impacts give something back.
    is_end: Ints
    is_one_way: Ints
    sliding_kinds: Ints
    bounces: Ints
    # Of the law: the contact of each element that is in a piece, and its first internal state; per
    # piece its numbers, the piece behind each way out (-1: none), whether the state of the element
    # begins anew there, and, by piece and way out, the known zeros behind it.
    element_contacts: Ints
    element_states: Ints
    piece_begins: Ints2
    piece_rows: Floats2
    piece_exits: Ints2
    piece_zeros: Ints2
    # Places of the sector's start and width among the parameters (-1: there is no sector), and of
    # whether the motion is inside; the contact whose angle it is.
    sector_start: FixedInt
    sector_width: FixedInt
    inside_sector: FixedInt
    sector_contact: FixedInt

    # --- tolerances and limits ---
    rtol: FixedFloat
    fixed_step: FixedFloat  # of rk4
    bound: FixedFloat
    max_steps: FixedInt
    max_events: FixedInt
    max_sections: int

    # --- where and how the motion is ---
    time: float
    y: OwnFloats
    parameters: OwnFloats
    slip_signs: OwnFloats  # the part of the parameters that holds them
    rows: OwnFloats  # ... and the part that holds the numbers of pieces
    kinds: OwnInts
    in_piece: OwnInts  # number of the piece of each element of all contacts
    coefficients: OwnFloats
    filled_for: float  # slip signs and sector that coefficients were computed for; 0: none
    task: int
    last_step: float
    first_step: float  # of the contact state just decided, whose series is at hand; 0: none
    sector_low: float
    sector_high: float
    next_phase: float
    # At the start of a step: derivatives, from the value on, that are known to be zero, of
    # switching functions, distances from the sector's borders, and the section.
    known_zeros: OwnInts
    zeros_at_upper: int
    zeros_at_lower: int
    zeros_on_section: int
    n_steps: int
    n_events: int
    n_chained: int  # transitions at this instant
    n_nearly_chained: int
    n_grazings: int
    n_impacts: int
    n_accumulations: int  # impacts that gave back too little to leave again
    # The element that has just left a piece and its row of `piece_zeros` (-1: none), or the
    # switching function that only touched zero (-1: none).
    left_element: int
    left_by: int
    touched_guard: int

    # --- section points, samples, a ledger of events, tangent vectors ---
    section_kind: FixedInt
    section_from: FixedInt
    section_to: FixedInt
    section_contact: FixedInt
    section_state: FixedInt
    section_direction: FixedInt
    n_sections: int
    section_times: Floats
    section_states: Floats2
    section_works: Floats2  # `Measures.all_works` by then; no rows: not asked for
    n_sampled: int
    sample_times: Floats
    sample_states: Floats2
    sample_outputs: Floats2
    sample_codes: Ints2
    n_ledger: int
    ledger_times: Floats
    ledger_before: Ints
    ledger_after: Ints
    ledger_contacts: Ints
    ledger_residuals: Floats
    tangents: Floats2

    # --- measures ---
    measured_time: float
    spread: float  # integral of the squared distance from the reference
    other_work: float
    friction_work: float
    drive_work: float
    impact_loss: float
    largest_residual: float
    # Where only energies are asked for, the next four are empty.
    reference: Floats  # NaN for a coordinate that does not count
    least: Floats
    greatest: Floats
    squares: Floats  # integrals
    shares: Floats2  # time of each contact in slip, stick, separation
    works: Floats  # of each excitation
    quadrature: Floats2
    work_rule: Floats2  # nodes and weights
    # Of a law by pieces that is known up to a slip speed (else empty): that, or the greatest beyond
    # it at the end of a step, of all motions of the system since it was set.
    greatest_slip: Floats

    # --- scratch, written before it is read ---
    series: Floats
    work: Floats
    lanes: Floats  # series of tangents, of several at once
    outputs: Floats  # of a field function
    reached: Floats  # the state at the end of a step
    inner: Floats
    begun: Floats
    nodes: Floats2
    between: Floats
    joined: Floats  # a state and a tangent vector
    rates_before: Floats
    delays: Floats
    at_rest: Floats
    slip_velocities: Floats
    # Candidates of `decide`, per contact.
    code_before: Ints
    is_at_rest: Ints
    n_offers: Ints
    offered_kinds: Ints2
    offered_signs: Ints2
    pieces_before: Ints
    pieces_begun: Ints  # whether the element has begun anew at this event
    pieces_offered: Ints


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
def power_of_two(exponent: float) -> float:
    """2 to this power, to 0.2 per cent: all that a step needs, in a third of the time."""
    whole = np.floor(exponent)
    part = exponent - whole
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
    if max(worst, worst_before) == 0.0:
        return ENDLESS
    # Logarithms to base 2, read off the bits: between powers of two they rise along the chord.
    allowed = bits_of(rtol)
    step = (allowed - bits_of(worst)) / MANTISSA * (1.0 / order)
    step_before = (allowed - bits_of(worst_before)) / MANTISSA * (1.0 / (order - 1))
    return power_of_two(min(step, step_before))


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
def stands_still(run: Run, index: int) -> bool:
    """Whether neither a state nor a switching function changes over a step."""
    for row in range(run.n_states + run.n_guards[index]):
        first = row * (run.order + 1)
        for k in range(1, run.order + 1):
            if run.series[first + k] != 0.0:
                return False
    return run.has_angle[index] == 0


@native
def polynomial_step(run: Run, index: int) -> float:
    """Step for a motion that is a polynomial, exact over any length.

    Roots are located as fractions of the step, so it must not dwarf the time to the next event.
    """
    if stands_still(run, index):
        return ENDLESS
    usual, step = POLYNOMIAL_STEPS * run.last_step, ENDLESS
    for g in range(run.n_guards[index]):
        offset = (run.n_states + g) * (run.order + 1)
        value = run.series[offset] if run.known_zeros[g] == 0 else 0.0
        if run.series[offset + 1] != 0.0:
            step = min(step, 2.0 * abs(value / run.series[offset + 1]))
    if step == ENDLESS and usual > 0.0:
        return max(usual, AT_LEAST * run.time)
    if usual > 0.0 and step <= FAR_AHEAD * usual:
        return usual
    return step if step > 0.0 else ENDLESS


@native
def leading(series: Floats, offset: int, order: int, step: float, known_zeros: int) -> int:
    """First non-vanishing derivative of a switching function: its order + 1, with its sign.

    0 when all vanish, -1 where the series is no finite number (0 / 0). `step` is the time over
    which derivatives are compared; without one (0) the first that is not exactly zero counts.
    """
    scale = series_scale(series, offset, order, step)
    is_finite = scale < np.inf
    if step == 0.0:
        step, scale = 1.0, 0.0
    power = 1.0
    for k in range(order):
        term = series[offset + k] * power
        tolerance = (ZERO if k == 0 else VANISHING) * scale
        if k >= known_zeros and abs(term) > tolerance:
            return k + 1 if term > 0.0 else -k - 1
        power *= step
    return 0 if is_finite else -1


@native
def fill(run: Run) -> None:
    """Compute the coefficients, unless they are those of these slip signs and this sector."""
    wanted = 1.0 + run.parameters[run.inside_sector]
    for i in range(run.n_contacts):
        wanted = 2.0 * wanted + (1.0 if run.slip_signs[i] > 0.0 else 0.0)
    if run.filled_for != wanted:
        call_generated(
            run.fill_coefficients, run.coefficients, 0.0, run.parameters, run.coefficients
        )
        run.filled_for = wanted


@native
def zeros_at_start(run: Run, index: int, guard: int) -> int:
    """How many of a switching function's value and rate are zero to rounding: 0, 1 or 2.

    Rounding is a share of what the states, one after the other, add to it.
    """
    n, order = run.n_states, run.order
    taylor, t, zeros = run.taylor[index], run.time, 0
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
def known_zeros_of(
    run: Run, index: int, guard: int, trigger_kind: int, trigger_contact: int
) -> int:
    """How many derivatives of a switching function, from its value on, are known to be zero.

    Each case names the test that fails without it.
    """
    kind, contact = run.guard_kinds[index, guard], run.guard_contacts[index, guard]
    if kind == PIECE:
        return known_zeros_of_piece(run, index, guard) if trigger_kind == PIECE else 0
    if kind == VELOCITY and contact == trigger_contact:
        released = trigger_kind == (CAPACITY_UP if run.slip_signs[contact] > 0.0 else CAPACITY_DOWN)
        if released and run.series[(run.n_states + guard) * (run.order + 1) + 1] < 0.0:
            # slip friction does not exceed the capacity: this is rounding
            return 2  # test_a_release_at_all_the_capacity_goes_on
    if run.task == ENTER and (kind == GAP or kind == NORMAL):
        return zeros_at_start(run, index, guard)  # test_what_is_lifted_separates_at_once
    if run.task == ENTER and (kind == CAPACITY_UP or kind == CAPACITY_DOWN):
        return zeros_at_start(run, index, guard)  # test_a_start_at_all_the_capacity_goes_on
    if kind == VELOCITY and run.is_at_rest[contact] == 1:
        return 1  # test_what_stuck_slides_the_way_it_is_left_behind
    if contact == trigger_contact and kind == trigger_kind:
        return 1  # test_both_release_at_once_where_mass_2_is_held_by_all_its_capacity
    if contact == trigger_contact and kind == GAP and trigger_kind == NORMAL:
        return 1  # test_a_contact_that_opens_has_no_gap
    return 0


@native
def known_zeros_of_piece(run: Run, index: int, guard: int) -> int:
    """The same of a way out of a piece where an element has just come into one."""
    if guard == run.touched_guard:
        return 1
    ways, place = run.piece_exits.shape[1], run.guard_places[index, guard]
    if run.left_by < 0 or place // ways != run.left_element:
        return 0
    return run.piece_zeros[run.left_by, place % ways]


@native
def put_in_piece(run: Run, element: int, piece: int) -> None:
    """Let an element be in a piece."""
    width = run.piece_rows.shape[1]
    run.in_piece[element] = piece
    for k in range(width):
        run.rows[element * width + k] = run.piece_rows[piece, k]
    run.filled_for = 0.0


@native
def leave_piece(run: Run, index: int, guard: int) -> None:
    """Let the element whose switching function falls go on in the next piece."""
    ways, place = run.piece_exits.shape[1], run.guard_places[index, guard]
    element, way = place // ways, place % ways
    piece = run.in_piece[element]
    run.left_element, run.left_by = element, piece * ways + way
    put_in_piece(run, element, run.piece_exits[piece, way])
    if run.piece_begins[piece, way] == 1:
        run.pieces_begun[element] = 1
        begin_anew(run, run.element_states[element])


@native
def begin_anew(run: Run, entry: int) -> None:
    """Let an internal state, and the tangents along it, begin anew at zero."""
    run.y[entry] = run.rates_before[entry] = 0.0
    for row in range(run.tangents.shape[0]):
        run.tangents[row, entry] = 0.0


@native
def first_out(run: Run, index: int, step: float, trigger_kind: int) -> int:
    """The first way out of a piece that is fallen through, or will be at once; -1: none."""
    for guard in range(run.n_guards[index]):
        if run.guard_kinds[index, guard] == PIECE:
            offset = (run.n_states + guard) * (run.order + 1)
            zeros = known_zeros_of(run, index, guard, trigger_kind, -1)
            if leading(run.series, offset, run.order, step, zeros) < 0:
                return guard
    return -1


@native
def comparing_step(run: Run) -> float:
    """Time over which derivatives are compared, where the series at hand allow a step."""
    if run.first_step < ENDLESS:
        return run.first_step
    return run.last_step if run.last_step > 0.0 else 0.0


@native
def settle_pieces(run: Run, index: int, trigger_kind: int) -> bool:
    """Let elements go on until each is in a piece that it stays in; False: they go in circles."""
    for _ in range(CHAIN_CAP + len(run.piece_exits)):
        guard = first_out(run, index, comparing_step(run), trigger_kind)
        if guard < 0:
            return True
        leave_piece(run, index, guard)
        run.left_by = -1  # nothing is known of one that lay elsewhere
        fill(run)
        run.first_step = series_at_hand(run, index)
    return False


@native
def holds(run: Run) -> bool:
    """Whether a contact sticks or a stop is closed."""
    for i in range(run.n_contacts):
        if run.kinds[i] == STICK or run.kinds[i] < run.sliding_kinds[i]:
            return True
    return False


@native
def consistent(run: Run, trigger_kind: int, trigger_contact: int, lenient: bool) -> bool:
    """Whether a candidate contact state can follow: every switching function leads positive.

    `lenient` leaves out that another contact opens or closes at the same instant, or that this
    one loses its normal force together with its capacity: the next event, chained to this one.
    """
    order, index = run.order, state_index(run.kinds, run.n_contacts)
    if run.taylor[index] == 0:
        return False
    fill(run)
    run.first_step = series_at_hand(run, index)
    if len(run.in_piece) > 0 and not settle_pieces(run, index, trigger_kind):
        return False
    step = comparing_step(run)
    for g in range(run.n_guards[index]):
        kind, contact = run.guard_kinds[index, g], run.guard_contacts[index, g]
        offset = (run.n_states + g) * (order + 1)
        known_zeros = known_zeros_of(run, index, g, trigger_kind, trigger_contact)
        lead = leading(run.series, offset, order, step, known_zeros)
        if kind == NORMAL and trigger_kind == GAP and contact == trigger_contact:
            flight = max(step, run.last_step)
            rounding = VANISHING * series_scale(run.series, offset, 2, flight)
            is_rounding = abs(run.series[offset]) <= rounding
            # the last of ever shorter flights: the open contact finds no gap rate left, this one
            # a force, or a rate of it, that is negative by the rounding of the step that led here
            # (test_bounces_that_pile_up_end_in_contact, test_contact_closes_on_stiff_bristles)
            if lenient and (lead == -2 or (lead == -1 and is_rounding)):
                lead = leading(run.series, offset, order, step, 2)
            elif lead == 1 and is_rounding:
                # test_a_compliant_contact_begins_at_zero_compression_and_zero_rate
                lead = leading(run.series, offset, order, step, 1)
        opens = kind == NORMAL or kind == GAP  # test_two_contacts_at_one_instant
        if contact == trigger_contact:
            # test_a_harmonic_lift_separates_where_the_normal_force_vanishes
            opens = kind == NORMAL and trigger_kind < NORMAL
        if lead < 0 and not (lenient and opens and lead < -1):
            return False
        if lead == 0 and kind == VELOCITY and holds(run):
            return False  # held by another contact: test_what_another_contact_holds_does_not_slip
        if lead != 1 and (kind == JAMMING or kind == SINGULAR):
            return False  # forces without bound: test_directions_that_meet_on_the_way
        # A function that is zero throughout (a capacity that stays just reached) has no root.
        run.known_zeros[g] = max(lead - 1, 0) if lead != 0 else order + 1
    return True


@native
def series_at_hand(run: Run, index: int) -> float:
    """Write the series of a contact state; the length of the step that they allow."""
    taylor = run.taylor[index] if len(run.tangents) == 0 else run.followed[index]
    call_generated(taylor, run.coefficients, run.time, run.y, run.series)
    order, rows = run.order, run.n_states + run.n_guards[index] + run.has_angle[index]
    step = step_size(run.series, rows, order, run.rtol, run.last_step)
    for i in range(run.n_arguments[index]):
        step = within_plateau(run.series, (rows + i) * (order + 1), order, step)
    return step


@native
def let_go(run: Run) -> int:
    """Number of the contact state in which what sticks is let go."""
    index = 0
    for i in range(run.n_contacts - 1, -1, -1):
        index = 3 * index + (run.sliding_kinds[i] if run.kinds[i] == STICK else run.kinds[i])
    return index


@native
def slip_velocity(run: Run, y: Floats, contact: int, is_struck: bool, zero: float) -> float:
    """v_rel of a contact; zero when it is within `zero` of all velocities, and of what they change
    by over a step: all of them may vanish (test_slips_of_two_contacts_reverse_together_at_rest)."""
    index, outputs = state_index(run.kinds, run.n_contacts), run.outputs
    # What is struck need not stick; one at rest that cannot stick slides, one way or the other.
    if is_struck or run.taylor[index] == 0:
        index = let_go(run)
    call_generated(run.field[index], run.coefficients, run.time, y, outputs)
    v = outputs[run.contact_place[index] + PER_CONTACT * contact + SLIP_VELOCITY]
    scale = 0.0
    for i in range(run.n_coordinates, run.n_states):
        scale += abs(y[i]) + abs(run.last_step * outputs[run.n_states + i])
    return 0.0 if abs(v) <= zero * scale else v


@native
def rebounds(run: Run, contact: int) -> bool:
    """Whether a contact that has just been struck opens again (run.y is the state thereafter)."""
    if run.bounces[contact] == 0 or run.n_chained > SHORT_FLIGHTS:
        return False
    index, order = let_go(run), run.order
    call_generated(run.taylor[index], run.coefficients, run.time, run.y, run.work)
    rows = run.n_states + run.n_guards[index]
    step = min(run.last_step, step_size(run.work, rows, order, run.rtol, run.last_step))
    for g in range(run.n_guards[index]):
        if run.guard_kinds[index, g] == GAP and run.guard_contacts[index, g] == contact:
            return leading(run.work, (run.n_states + g) * (order + 1), order, step, 1) > 0
    return False


@native
def offer(run: Run, contact: int, kind: int, sign: int) -> None:
    """Add a candidate state of a contact."""
    place = run.n_offers[contact]
    run.offered_kinds[contact, place], run.offered_signs[contact, place] = kind, sign
    run.n_offers[contact] = place + 1


@native
def offer_states(
    run: Run, i: int, trigger_kind: int, triggered: bool, grazing: bool, zero: float
) -> None:
    """The candidate states of a contact; `triggered` says that it is the one that triggered."""
    sign = 1 if run.slip_signs[i] > 0.0 else -1
    run.n_offers[i], run.is_at_rest[i] = 0, 0
    closes = triggered and trigger_kind == GAP and not rebounds(run, i)
    if run.kinds[i] == SEPARATION and not closes:
        offer(run, i, SEPARATION, sign)
        return
    struck = trigger_kind == GAP and not triggered  # test_what_sticks_is_torn_off_by_an_impact
    if (run.kinds[i] == STICK and not struck) or (triggered and trigger_kind == VELOCITY):
        run.is_at_rest[i] = 1
    else:  # re-contact, an impact elsewhere, or a slip that ends at the same instant
        v = slip_velocity(run, run.y, i, struck, zero)
        run.is_at_rest[i] = 1 if v == 0.0 else 0
        if (run.kinds[i] == SEPARATION or struck) and v != 0.0 and run.is_one_way[i] == 0:
            sign = 1 if v > 0.0 else -1
    released = triggered and (trigger_kind == CAPACITY_UP or trigger_kind == CAPACITY_DOWN)
    if released and not grazing:  # the demanded force passes the capacity: it slips its way
        offer(run, i, SLIP, 1 if trigger_kind == CAPACITY_UP else -1)
        return
    # What triggers falls through zero, unless it grazes: it cannot stay as it was.
    passes = triggered and not grazing
    if not (passes and trigger_kind == NORMAL):
        if run.is_at_rest[i] == 1:
            offer(run, i, STICK, sign)
        if not (passes and trigger_kind == VELOCITY):
            offer(run, i, SLIP, sign)
        if run.is_at_rest[i] == 1:
            offer(run, i, SLIP, -sign)
    if trigger_kind < 0 or (triggered and (trigger_kind == GAP or trigger_kind == NORMAL)):
        offer(run, i, SEPARATION, sign)


@native
def pick(run: Run, contact: int, rest: int) -> int:
    """Give a contact the candidate that `rest` chooses; what is left to choose the others'."""
    chosen = rest % run.n_offers[contact]
    run.kinds[contact] = run.offered_kinds[contact, chosen]
    run.slip_signs[contact] = run.offered_signs[contact, chosen]
    return rest // run.n_offers[contact]


@native
def decide(run: Run, trigger_kind: int, trigger_contact: int, grazing: bool) -> bool:
    """Choose the contact state that follows at (t, y); False when none is consistent.

    Selection rule where several are consistent (stiction is not unique at zero slip): sticking
    before slipping, staying closed before separating, and all contacts jointly; contacts that did
    not trigger stay as they are if they can. `grazing` says that the switching function that
    triggered may only touch zero, so staying is a candidate. Where none is consistent, a slip that
    ends at nearly the same instant does so now: where that is, is known as closely as the tolerance
    asks for (test_slips_that_end_together_are_told_from_rounding).
    """
    found = choose(run, trigger_kind, trigger_contact, grazing, ZERO)
    return found or choose(run, trigger_kind, trigger_contact, grazing, SAME_INSTANT)


@native
def choose(run: Run, trigger_kind: int, trigger_contact: int, grazing: bool, zero: float) -> bool:
    """`decide`, where slip velocities within `zero` of all velocities are zero."""
    combinations = 1
    for i in range(run.n_contacts):
        offer_states(run, i, trigger_kind, trigger_contact == i, grazing, zero)
        combinations *= run.n_offers[i]
    begin = 0
    if trigger_kind == GAP and run.n_chained > SHORT_FLIGHTS:
        begin = combinations
    for i in range(len(run.in_piece)):
        run.pieces_offered[i] = run.in_piece[i]
    left_by = run.left_by
    is_release = trigger_kind == CAPACITY_UP or trigger_kind == CAPACITY_DOWN
    in_turns = is_release and run.n_nearly_chained > IN_TURNS
    for attempt in range(begin, 2 * combinations):
        rest, run.left_by = attempt % combinations, left_by
        if in_turns:  # test_contacts_that_let_go_together_do_not_take_turns
            rest = combinations - 1 - rest
        for i in range(len(run.in_piece)):
            if run.in_piece[i] != run.pieces_offered[i]:
                put_in_piece(run, i, run.pieces_offered[i])
        if trigger_contact >= 0:  # the contact that triggered changes first: others stay
            rest = pick(run, trigger_contact, rest)
        for i in range(run.n_contacts - 1, -1, -1):
            if i != trigger_contact:
                rest = pick(run, i, rest)
        if consistent(run, trigger_kind, trigger_contact, attempt >= combinations):
            return True
    return False


@inlined
def state_after(run: Run, index: int, t: float, x: float, out: Floats) -> None:
    """State a time x into the step that begins at (t, y)."""
    if run.is_taylor == 1:
        call_generated(run.sum_series, run.coefficients, x, run.series, out)
    else:
        runge_kutta(run, index, t, x, out)


@native
def runge_kutta(run: Run, index: int, t: float, x: float, out: Floats) -> None:
    """The same by classical Runge-Kutta of order 4 (thesis 3.39, 3.40), stage by stage."""
    n, field, inner = run.n_states, run.outputs, run.inner
    call_generated(run.field[index], run.coefficients, t, run.y, field)
    for i in range(n):
        out[i] = field[i] + x / 6.0 * field[n + i]
        inner[i] = field[i] + 0.5 * x * field[n + i]
    start = run.begun
    for i in range(n):
        start[i] = field[i]
    call_generated(run.field[index], run.coefficients, t + 0.5 * x, inner, field)
    for i in range(n):
        out[i] += x / 3.0 * field[n + i]
        inner[i] = start[i] + 0.5 * x * field[n + i]
    call_generated(run.field[index], run.coefficients, t + 0.5 * x, inner, field)
    for i in range(n):
        out[i] += x / 3.0 * field[n + i]
        inner[i] = start[i] + x * field[n + i]
    call_generated(run.field[index], run.coefficients, t + x, inner, field)
    for i in range(n):
        out[i] += x / 6.0 * field[n + i]
    call_generated(run.field[index], run.coefficients, t + x, out, field)
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
    call_generated(run.field[index], run.coefficients, t + step, out, run.outputs)
    if factor * run.outputs[entry] + shift > 0.0:
        return NO_ROOT
    low, high = 0.0, step
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high:
            break
        state_after(run, index, t, middle, out)
        call_generated(run.field[index], run.coefficients, t + middle, out, run.outputs)
        if factor * run.outputs[entry] + shift > 0.0:
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
    return first_root(run, last, total + odd_total, end + odd_end)


@native
def touched(
    run: Run, index: int, hit: int, tau: float, step: float, scale: float, out: Floats
) -> float:
    """Where a switching function that barely falls is least, if it only touches zero there.

    Its series may dip below zero by the error of the series, and pass zero a little before. What
    the function itself is where it turns decides. Otherwise `tau`, where it passes. `outputs`
    is left as it is at the time returned.
    """
    n, order, found = run.n_states, run.order, run.outputs
    offset = (n + hit) * (order + 1)
    slope, bend, power = run.series[offset + 1], 0.0, 1.0
    for k in range(2, order + 1):
        bend += k * (k - 1.0) * run.series[offset + k] * power
        power *= tau
        slope += k * run.series[offset + k] * power
    if slope >= 0.0 or bend <= 0.0 or tau - slope / bend > step:
        return tau
    least = tau - slope / bend
    t = run.time
    call_generated(run.sum_series, run.coefficients, least, run.series, out)
    call_generated(run.guards[index], run.coefficients, t + least, out, found)
    if found[n + hit] >= -ZERO * scale:
        return least
    call_generated(run.sum_series, run.coefficients, tau, run.series, out)
    call_generated(run.guards[index], run.coefficients, t + tau, out, found)
    return tau


@native
def take_samples(run: Run, index: int, tau: float) -> None:
    """Record the samples that fall into the step of length tau."""
    t, state, outputs, first = run.time, run.joined, run.outputs, run.contact_place[index]
    while run.n_sampled < len(run.sample_times) and run.sample_times[run.n_sampled] <= t + tau:
        row = run.n_sampled
        x = min(max(run.sample_times[row] - t, 0.0), tau)
        state_after(run, index, t, x, state)
        call_generated(run.field[index], run.coefficients, t + x, state, outputs)
        for i in range(run.n_states):
            run.sample_states[i, row] = outputs[i]
        for i in range(run.sample_outputs.shape[0]):
            run.sample_outputs[i, row] = outputs[first + i]
        for i in range(run.n_contacts):
            run.sample_codes[i, row] = code_of(run.kinds[i], run.slip_signs[i])
        run.n_sampled += 1


@native
def take_measures(run: Run, index: int, tau: float) -> None:
    """Integrate the measures along the step of length tau."""
    run.measured_time += tau
    for i in range(run.n_contacts):
        run.shares[i, run.kinds[i]] += tau
    if len(run.least) == 0 and run.is_taylor == 1:
        do_work(run, index, tau)
        return
    count = nodes_needed(run, tau)
    first, x = count * (count - 1) // 2, 0.0
    for node in range(count):
        here = run.nodes[node // LANES % 2]
        if node % LANES == 0:
            look_at_nodes(run, index, tau, here, first + node, first + count - 1)
        last_x, x = x, run.quadrature[first + node, 0] * tau
        add_up(run, here[node % LANES :], run.quadrature[first + node, 1] * tau)
        if node > 0 and run.is_taylor == 1 and len(run.least) > 0:
            before = run.nodes[(node - 1) // LANES % 2][(node - 1) % LANES :]
            look_for_turns(run, before, here[node % LANES :], last_x, x)


@native
def do_work(run: Run, index: int, tau: float) -> None:
    """Integrate the powers, and no more, along the step of length tau."""
    here, rule = run.nodes[0], run.work_rule
    for first in range(0, rule.shape[1], NODES):
        for node in range(NODES):
            here[node] = rule[0, first + node] * tau
        call_generated(run.powers[index], run.coefficients, run.time, run.series, here)
        other, friction, drive = 0.0, 0.0, 0.0
        for node in range(NODES):
            weight = rule[1, first + node] * tau
            other += weight * here[node]
            friction += weight * here[NODES + node]
            drive += weight * here[2 * NODES + node]
        run.other_work += other
        run.friction_work += friction
        run.drive_work += drive
        for i in range(len(run.works)):
            for node in range(NODES):
                power = here[(OWN_POWERS + i) * NODES + node]
                run.works[i] += rule[1, first + node] * tau * power


@native
def look_at_nodes(run: Run, index: int, tau: float, here: Floats, row: int, last: int) -> None:
    """What is measured at nodes, several at once: states, their rates, powers.

    `row` is that of the first of them in the rule, which ends with the row `last`.
    """
    n, t, outputs = run.n_states, run.time, run.outputs
    if run.is_taylor == 1:
        for lane in range(LANES):
            here[lane] = run.quadrature[min(row + lane, last), 0] * tau
        call_generated(run.measured[index], run.coefficients, t, run.series, here)
        return
    powers = run.energy_place[index] + OTHER_POWER
    for lane in range(min(LANES, last - row + 1)):
        x = run.quadrature[row + lane, 0] * tau
        state_after(run, index, t, x, run.between)
        call_generated(run.field[index], run.coefficients, t + x, run.between, outputs)
        for i in range(2 * n):
            here[i * LANES + lane] = outputs[i]
        for i in range(OWN_POWERS + len(run.works)):
            here[(2 * n + i) * LANES + lane] = outputs[powers + i]


@native
def add_up(run: Run, here: Floats, weight: float) -> None:
    """Add a node of the quadrature, at which this is measured."""
    for i in range(len(run.least)):
        value = here[i * LANES]
        run.least[i] = min(run.least[i], value)
        run.greatest[i] = max(run.greatest[i], value)
        run.squares[i] += weight * value * value
    for i in range(len(run.reference)):
        if run.reference[i] == run.reference[i]:
            off = here[i * LANES] - run.reference[i]
            run.spread += weight * (off * off)
    powers = here[2 * run.n_states * LANES :]
    run.other_work += weight * powers[0]
    run.friction_work += weight * powers[LANES]
    run.drive_work += weight * powers[2 * LANES]
    for i in range(len(run.works)):
        run.works[i] += weight * powers[(OWN_POWERS + i) * LANES]


@native
def nodes_needed(run: Run, tau: float) -> int:
    """Nodes of the quadrature that integrates over this part of a step to rounding."""
    count = FEWEST_NODES
    share = tau / run.last_step
    while run.quadrature[count * (count - 1) // 2, 2] < share:
        count += 1
    return count


@native
def look_for_turns(run: Run, before: Floats, after: Floats, low: float, high: float) -> None:
    """Extremes that lie between two nodes, at which these are measured.

    Only a turn that can pass the extreme known so far is located.
    """
    n, order = run.n_states, run.order
    for i in range(n):
        begun, ended = before[i * LANES], after[i * LANES]
        rise, fall = before[(n + i) * LANES], after[(n + i) * LANES]
        if rise * fall < 0.0:
            reach = (abs(rise) + abs(fall)) * (high - low)
            if rise > 0.0:
                if max(begun, ended) + reach > run.greatest[i]:
                    value = turning_value(run, i * (order + 1), low, high, rise, fall)
                    run.greatest[i] = max(run.greatest[i], value)
            elif min(begun, ended) - reach < run.least[i]:
                value = turning_value(run, i * (order + 1), low, high, rise, fall)
                run.least[i] = min(run.least[i], value)


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
        call_generated(run.value_slope_bend, series, x, series, found)
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
def move_tangents(run: Run, index: int, tau: float) -> None:
    """Carry the tangent vectors (rows) over a step of length tau, in the parts that they need.

    Several are carried at once, and all share the motion's series. The step was chosen for the
    motion. A tangent has modes that the motion may leave at rest, and where these are fast its
    series needs shorter steps.
    """
    n, width, count = run.n_states, (run.tangent_order + 1) * LANES, run.tangents.shape[0]
    if run.is_taylor == 0:
        call_generated(run.followed[index], run.coefficients, run.time, run.y, run.series)
    for first in range(0, count, LANES):
        taken = min(LANES, count - first)
        for i in range(n):
            for lane in range(LANES):
                value = run.tangents[first + lane, i] if lane < taken else 0.0
                run.lanes[i * width + lane] = value
        move_lanes(run, index, tau)
        for i in range(n):
            for lane in range(taken):
                run.tangents[first + lane, i] = run.lanes[i * width + lane]


@native
def move_lanes(run: Run, index: int, tau: float) -> None:
    """Carry the tangent vectors in `lanes` over a step; its series are at hand."""
    c, t, series, done = run.coefficients, run.time, run.series, 0.0
    while True:
        call_generated(run.tangent[index], c, t + done, series, run.lanes)
        rest = tau - done
        part = rest
        while not suits_tangents(run, part):
            part *= SHORTER
        if done + part == done:
            part = rest
        call_generated(run.sum_tangent, c, part, run.lanes, run.lanes)
        if part >= rest:
            return
        done += part
        call_generated(run.sum_series, c, done, run.series, run.between)
        call_generated(run.followed[index], c, t + done, run.between, run.work)
        series = run.work


@native
def suits_tangents(run: Run, step: float) -> bool:
    """Whether the last two terms of the series of tangents stay below rtol times their scales.

    As in `step_size`, of which this is the question alone.
    """
    lanes, order, suits = run.lanes, run.tangent_order, True
    square, before = step * step, 1.0
    for _ in range(order - 1):
        before *= step
    for i in range(run.n_states):
        first = i * (order + 1) * LANES
        for lane in range(first, first + LANES):
            scale = max(abs(lanes[lane]), abs(lanes[lane + LANES]) * step)
            scale = max(scale, abs(lanes[lane + 2 * LANES]) * square)
            high, low = lanes[lane + order * LANES], lanes[lane + (order - 1) * LANES]
            last = max(abs(high) * step, abs(low)) * before
            suits = suits and not (last > run.rtol * scale and scale > NEGLIGIBLE)
    return suits


@native
def switching_rates(run: Run, index: int, entry: int) -> None:
    """At an event: the rates before it, and by how much each tangent delays it.

    A trajectory displaced by a tangent vector d meets the switching function g later by
    -dg(d) / g'; what the delay does to the state after the event is `saltate`'s.
    """
    n, joined = run.n_states, run.joined
    outputs = run.n_guards[index] + run.has_angle[index]
    for row in range(run.tangents.shape[0]):
        for i in range(n):
            joined[i] = run.y[i]
            joined[n + i] = run.tangents[row, i]
        call_generated(
            run.switching_with_tangent[index], run.coefficients, run.time, joined, run.work
        )
        for i in range(n):  # rows of value and rate: y, tangent, switching, tangent of switching
            run.rates_before[i] = run.work[2 * i + 1]
        speed = run.work[2 * (2 * n + entry) + 1]
        change = run.work[2 * (2 * n + outputs + entry)]
        run.delays[row] = -change / speed if speed != 0.0 else 0.0


@native
def strike(run: Run, impact: int) -> None:
    """Tangents through an impact y -> R(y, t): D R d; the rates before become dR/dt along the flow.

    With it `saltate` adds (dR/dt - f_after) delay, as it does at events without an impact.
    """
    n, joined = run.n_states, run.joined
    for row in range(run.tangents.shape[0]):
        for i in range(n):
            joined[i] = run.y[i]
            joined[n + i] = run.tangents[row, i]
        call_generated(impact, run.coefficients, run.time, joined, run.work)
        for i in range(n):  # rows of value and rate: y, tangent, R, tangent of R
            run.rates_before[i] = run.work[2 * (2 * n + i) + 1]
            run.tangents[row, i] = run.work[2 * (3 * n + i)]


@native
def saltate(run: Run) -> None:
    """Tangents after an event: d + (f_before - f_after) delay; `series` is the new state's."""
    order = run.order
    for row in range(run.tangents.shape[0]):
        for i in range(run.n_states):
            after = run.series[i * (order + 1) + 1]
            run.tangents[row, i] += (run.rates_before[i] - after) * run.delays[row]


@native
def rounding_of_angle(border: float) -> float:
    """How close to a border of the sector an angle is on it."""
    return ZERO * (2.0 * np.pi + abs(border))


@native
def enter_sector(run: Run, angle: float) -> bool:
    """Set the sector that `angle` lies in and its borders; whether it lies on the lower one.

    On a border, to rounding, it is the sector above it; what moves down goes on below.
    """
    run.sector_low, run.sector_high = -np.inf, np.inf
    run.parameters[run.inside_sector] = 0.0
    if run.sector_start < 0:
        return False
    width = run.parameters[run.sector_width]
    if width <= 0.0:
        return False
    turn = 2.0 * np.pi
    if width >= turn:
        run.parameters[run.inside_sector] = 1.0
        return False
    start = run.parameters[run.sector_start]
    rounding = rounding_of_angle(angle)
    base = start + turn * np.floor((angle - start) / turn)
    if angle - base >= turn - rounding:
        base += turn
    if angle - base < width - rounding:
        run.parameters[run.inside_sector] = 1.0
        run.sector_low, run.sector_high = base, base + width
    else:
        run.sector_low, run.sector_high = base + width, base + turn
    return angle - run.sector_low <= rounding


@native
def starts_open(run: Run, contact: int) -> bool:
    """Whether a contact begins open: a gap, or none but one that is about to be."""
    n, order, apart = run.n_states, run.order, run.most_open
    for g in range(run.n_guards[apart]):
        if run.guard_kinds[apart, g] == GAP and run.guard_contacts[apart, g] == contact:
            zeros = zeros_at_start(run, apart, g)
            call_generated(run.taylor[apart], run.coefficients, run.time, run.y, run.series)
            return zeros < 2 and run.series[(n + g) * (order + 1) + zeros] > 0.0
    return False


@native
def take_on(run: Run) -> None:
    """The state as the contact state has it: a drive's velocity in stick, a rigid contact's gap."""
    index = state_index(run.kinds, run.n_contacts)
    call_generated(run.field[index], run.coefficients, run.time, run.y, run.outputs)
    for k in range(run.n_states):
        run.y[k] = run.outputs[k]


@native
def set_out(run: Run) -> bool:
    """Slip signs, contacts at rest and open ones, and the sector, of the initial state.

    A contact whose kind is STICK takes on the drive's velocity. Returns whether the angle lies on
    the lower border of its sector.
    """
    for i in range(run.n_contacts):
        if run.kinds[i] == STICK:
            take_on(run)
            break
    for i in range(run.n_contacts):
        is_open = starts_open(run, i)
        run.kinds[i] = SEPARATION if is_open else SLIP
    if run.taylor[state_index(run.kinds, run.n_contacts)] == 0:  # between stops without play
        for i in range(run.n_contacts):
            run.kinds[i] = run.sliding_kinds[i]
    take_on(run)
    for k in range(run.n_states):
        run.at_rest[k] = 0.0
    for i in range(run.n_contacts):
        run.slip_velocities[i] = slip_velocity(run, run.y, i, False, ZERO)
    for i in range(run.n_contacts):
        if run.kinds[i] == SLIP:
            smooth, direction = run.is_one_way[i] == 1, run.slip_velocities[i]
            if smooth:  # the way it slides when the system is at rest
                direction = slip_velocity(run, run.at_rest, i, False, ZERO)
            run.slip_signs[i] = -1.0 if direction < 0.0 else 1.0
            if run.slip_velocities[i] == 0.0 and not smooth:
                run.kinds[i] = STICK
    angle = 0.0
    index = run.all_sliding
    if run.has_angle[index] == 1:
        call_generated(run.field[index], run.coefficients, run.time, run.y, run.outputs)
        angle = run.outputs[2 * run.n_states + run.n_guards[index]]
    return enter_sector(run, angle)


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
    width, place = run.parameters[run.sector_width], run.inside_sector
    run.parameters[place] = 1.0 - run.parameters[place]
    span = width if run.parameters[place] == 1.0 else 2.0 * np.pi - width
    if upwards:
        run.sector_low = run.sector_high
        run.sector_high = run.sector_low + span
    else:
        run.sector_high = run.sector_low
        run.sector_low = run.sector_high - span


@native
def keep_section(run: Run) -> None:
    """Put the present state into the section buffer."""
    row = run.n_sections
    run.section_times[row] = run.time
    for i in range(len(run.y)):
        run.section_states[row, i] = run.y[i]
    if len(run.section_works) > 0:
        keep_works(run, row)
    run.n_sections += 1


@native
def keep_works(run: Run, row: int) -> None:
    """Put what has been measured of works into the section buffer."""
    run.section_works[row, 0], run.section_works[row, 1] = run.other_work, run.friction_work
    run.section_works[row, 2], run.section_works[row, 3] = run.drive_work, run.impact_loss
    for i in range(len(run.works)):
        run.section_works[row, 4 + i] = run.works[i]


@native
def begin_step(run: Run, index: int) -> float:
    """Length of the step from where the motion is; its series are at hand afterwards."""
    if run.is_taylor == 0:
        run.last_step = run.fixed_step
        return run.fixed_step
    step = run.first_step
    run.first_step = 0.0
    if step == 0.0:
        step = series_at_hand(run, index)
        take_up(run)
    if step < ENDLESS:
        run.last_step = step
        return step
    return polynomial_step(run, index)


@native
def on_section(run: Run, value: float, step: float) -> bool:
    """Whether the section's state is zero to rounding, where it has this value in a step."""
    if run.section_kind != SECTION_ZERO or run.is_taylor == 0:
        return False
    offset = run.section_state * (run.order + 1)
    return abs(value) <= ZERO * series_scale(run.series, offset, run.order, step)


@native
def coincides(run: Run, hit: int, step: float, root: float, fraction: float) -> bool:
    """Whether the section is met on an event: the slip velocity may be the section's state."""
    if hit == NOTHING or fraction - root > SAME_INSTANT:
        return False
    offset = run.section_state * (run.order + 1)
    return on_section(run, series_value(run.series, offset, run.order, fraction * step), step)


@inlined
def fall(
    run: Run, index: int, step: float, row: int, entry: int, zeros: int, factor: float, shift: float
) -> float:
    """First root of ``factor * function + shift`` over a step, as a fraction of it.

    Of the function the series is in `row`, the value in an `entry` of the field output.
    """
    if run.is_taylor == 1:
        return located(run, row * (run.order + 1), run.order, step, zeros, factor, shift)
    return bisected(run, index, run.time, step, run.reached, entry, factor, shift)


@native
def first_guard(run: Run, index: int, step: float) -> tuple[int, float]:
    """The first switching function of the contact state to fall, and when in the step."""
    n, hit, fraction = run.n_states, NOTHING, 1.0
    for guard in range(run.n_guards[index]):
        zeros = run.known_zeros[guard]
        if zeros <= run.order:
            root = fall(run, index, step, n + guard, 2 * n + guard, zeros, 1.0, 0.0)
            if root < fraction or (root == 1.0 and hit == NOTHING):
                hit, fraction = guard, root
    return hit, fraction


@native
def to_border(run: Run, index: int, step: float, upper: bool) -> float:
    """When in a step a border of the sector is reached."""
    n, order = run.n_states, run.order
    row, entry = n + run.n_guards[index], 2 * n + run.n_guards[index]
    zeros = run.zeros_at_upper if upper else run.zeros_at_lower
    factor = -1.0 if upper else 1.0
    shift = run.sector_high if upper else -run.sector_low
    if run.is_taylor == 1:
        leaving = away_from_border(run.series, row * (order + 1), order, step, factor, shift)
        zeros = max(zeros, leaving)
    return fall(run, index, step, row, entry, zeros, factor, shift)


@native
def off_section(run: Run, index: int, step: float) -> tuple[float, int]:
    """The section's state, or its first derivative that is not zero, and the number of zeros.

    A state of 0 stays at zero: a mass that sticks to a drive at rest. `step` is what is left of a
    step until an event. On the section a rate that is zero to rounding is none: it would lead back
    there at once, again and again (test_a_motion_that_begins_along_its_section_goes_on).
    """
    order, entry, value = run.order, run.section_state, 0.0
    zeros = min(run.zeros_on_section, order)
    if run.is_taylor == 1:
        offset = entry * (order + 1)
        while zeros < order and value == 0.0:
            value = run.series[offset + zeros]
            zeros += 1
        if zeros > 1 and value != 0.0:
            lead = abs(leading(run.series, offset, order, step, zeros - 1))
            zeros = max(zeros, lead)
            value = run.series[offset + zeros - 1] if lead != 0 else 0.0
        return value, zeros - 1
    if zeros == 0:
        value = run.y[entry]
    if value == 0.0:
        state_after(run, index, run.time, 0.5 * step, run.reached)
        value = run.reached[entry]
    return value, zeros


@native
def is_hop(run: Run, index: int, hit: int, flight: float) -> bool:
    """Whether a step is a flight off a stop, so short that where it turns lies in rounding.

    A step that ended there would begin another flight, as long as the rounding of a gap makes it.
    """
    if hit < 0 or run.guard_kinds[index, hit] != GAP:
        return False
    return run.bounces[run.guard_contacts[index, hit]] == 1 and flight < HOP * run.last_step


@native
def first_fall(run: Run, index: int, step: float) -> tuple[int, float, float, float]:
    """What ends a step: NOTHING, a switching function, a border of the sector, the section.

    With it, as a fraction of the step, when; and of the section its sign before and the sense in
    which it passes.
    """
    hit, fraction = first_guard(run, index, step)
    if run.has_angle[index] == 1 and run.sector_high != np.inf:
        for border in range(UPPER_BORDER, LOWER_BORDER - 1, -1):
            root = to_border(run, index, step, border == UPPER_BORDER)
            if root < fraction or (root == 1.0 and hit == NOTHING):
                hit, fraction = border, root
    if run.section_kind != SECTION_ZERO:
        return hit, fraction, 0.0, 0.0
    value, zeros = off_section(run, index, fraction * step)
    if value == 0.0:
        return hit, fraction, 0.0, 0.0
    sign, entry = 1.0 if value > 0.0 else -1.0, run.section_state
    root = fall(run, index, step, entry, entry, zeros, sign, 0.0)
    if is_hop(run, index, hit, fraction * step):
        return hit, fraction, sign, 0.0
    if 0.0 < root < fraction and not coincides(run, hit, step, root, fraction):
        return SECTION, root, sign, -sign
    return hit, fraction, sign, 0.0


@native
def polished(
    run: Run, index: int, hit: int, tau: float, step: float, out: Floats
) -> tuple[float, float, bool]:
    """When an event is (a time into the step), its residual, whether it may be a touch.

    The root that was found is that of the switching function's series; Newton steps on the
    function itself, along the state's series, take it to rounding. `out` becomes the state there.
    """
    n, order, found, t = run.n_states, run.order, run.outputs, run.time
    residual = 0.0
    scale, fall = scale_and_slope(run.series, (n + hit) * (order + 1), order, step, tau)
    grazing = scale == 0.0 or fall * step > -GRAZING * scale
    enough = max(ROUNDING, EXACT * run.rtol)
    for polish in range(POLISHES):
        call_generated(run.guards[index], run.coefficients, t + tau, out, found)
        value = found[n + hit]
        residual = abs(value) / scale if scale > 0.0 else 0.0
        if grazing or residual <= enough or polish == POLISHES - 1:
            break
        change = max(-value / fall, -tau)
        if tau + change > ASTRAY * step:  # by rounding alone: what is found is as good
            break
        tau += change
        call_generated(run.sum_series, run.coefficients, tau, run.series, out)
    if grazing and scale > 0.0:
        tau = touched(run, index, hit, tau, step, scale, out)
    for i in range(n):
        out[i] = found[i]  # entries that the contact determines: exactly
    return tau, residual, grazing


@native
def kinetic_energy(run: Run, index: int) -> float:
    """The kinetic energy as a contact state has it."""
    call_generated(run.field[index], run.coefficients, run.time, run.y, run.outputs)
    return run.outputs[run.energy_place[index] + KINETIC]


@native
def collide(run: Run, index: int, contact: int) -> None:
    """An impact, if the contact's state has one."""
    out, t = run.reached, run.time
    if len(run.tangents) > 0:
        strike(run, run.impact_with_tangent[index, contact])
    call_generated(run.impact[index, contact], run.coefficients, t, run.y, out)
    for i in range(run.n_states):
        run.y[i] = out[i]
    run.n_impacts += 1


@native
def section_at_event(run: Run, sign_before: float, is_met: bool) -> None:
    """Whether the section lies on the event, and is to be kept.

    It is where the state passes zero, and where it comes to stay at zero: when it goes on from
    there (`sign_before` is 0) it does not count again. What follows is judged over its own step:
    that before may be far longer, in stick (test_what_follows_a_long_stick_is_on_no_section).
    """
    order, entry = run.order, run.section_state
    offset, step = entry * (order + 1), comparing_step(run)
    if not is_met and abs(run.y[entry]) > ZERO * series_scale(run.series, offset, order, step):
        return
    lead = leading(run.series, offset, order, step, 1)
    run.zeros_on_section = abs(lead) - 1 if lead != 0 else order + 1
    wanted = run.section_direction
    passes = sign_before != 0.0 and sign_before * lead <= 0.0
    if passes and (wanted == 0 or wanted == -sign_before):
        keep_section(run)
        run.section_states[run.n_sections - 1, entry] = 0.0


@native
def book_event(run: Run, contact: int, itself: bool, residual: float) -> None:
    """Enter what changed into ledger and section; `itself`: `contact` counts in any case."""
    events = run.n_events
    for i in range(run.n_contacts):
        before, after = run.code_before[i], code_of(run.kinds[i], run.slip_signs[i])
        if before == after and not (itself and i == contact):
            continue
        run.n_events += 1
        if run.n_ledger < len(run.ledger_times):
            row = run.n_ledger
            run.ledger_times[row], run.ledger_residuals[row] = run.time, residual
            run.ledger_before[row], run.ledger_after[row] = before, after
            run.ledger_contacts[row] = i
            run.n_ledger += 1
        if (
            run.section_kind == SECTION_EVENT
            and i == run.section_contact
            and kind_of(before) == run.section_from
            and (run.kinds[i] == run.section_to or run.section_to == ANY)
        ):
            keep_section(run)
    book_pieces(run, residual)
    if run.n_events == events:
        run.n_grazings += 1
    else:
        run.largest_residual = max(run.largest_residual, residual)


@native
def book_pieces(run: Run, residual: float) -> None:
    """Enter the elements that have come into another piece."""
    for element in range(len(run.in_piece)):
        before, after = run.pieces_before[element], run.in_piece[element]
        if before != after or run.pieces_begun[element] == 1:
            run.n_events += 1
            if run.n_ledger < len(run.ledger_times):
                row = run.n_ledger
                run.ledger_times[row], run.ledger_residuals[row] = run.time, residual
                run.ledger_before[row] = CODE_PIECE + before
                run.ledger_after[row] = CODE_PIECE + after
                run.ledger_contacts[row] = run.element_contacts[element]
                run.n_ledger += 1


@native
def take_up(run: Run) -> None:
    """The state as the contact state just decided has it."""
    for i in range(run.n_states):
        run.y[i] = run.series[i * (run.order + 1)]


@native
def heading(run: Run) -> int:
    """The way the sector's angle goes on: the sign of its first non-vanishing derivative, or 0.

    Where the contact sticks, the way it would be released: that of the force demanded of it.
    """
    n, order, contact = run.n_states, run.order, run.sector_contact
    index = state_index(run.kinds, run.n_contacts)
    step = run.first_step if run.first_step < ENDLESS else 0.0
    if run.has_angle[index] == 1:
        offset = (n + run.n_guards[index]) * (order + 1)
        return leading(run.series, offset + 1, order - 1, step, run.is_at_rest[contact])
    for k in range(order + 1):
        run.polynomial[k] = 0.0
    for g in range(run.n_guards[index]):
        kind, offset = run.guard_kinds[index, g], (n + g) * (order + 1)
        if run.guard_contacts[index, g] == contact and (
            kind == CAPACITY_UP or kind == CAPACITY_DOWN
        ):
            sign = 1.0 if kind == CAPACITY_DOWN else -1.0
            for k in range(order + 1):
                run.polynomial[k] += sign * run.series[offset + k]
    return leading(run.polynomial, 0, order, step, 0)


@native
def note_codes(run: Run) -> None:
    """The contact state as it is before an event."""
    for i in range(run.n_contacts):
        run.code_before[i] = code_of(run.kinds[i], run.slip_signs[i])
    for i in range(len(run.in_piece)):
        run.pieces_before[i], run.pieces_begun[i] = run.in_piece[i], 0


@native
def decide_on_border(run: Run) -> bool:
    """Decide the contact state on the lower border of a sector; False: there is none.

    The motion begins in the sector that it goes on into, above if it stays for ever.
    """
    note_codes(run)
    if decide(run, -1, -1, True) and heading(run) >= 0:
        return True
    cross_border(run, False)
    for i in range(run.n_contacts):
        run.kinds[i] = kind_of(run.code_before[i])
        run.slip_signs[i] = -1.0 if run.code_before[i] == CODE_SLIP_MINUS else 1.0
    return decide(run, -1, -1, True)


@native
def enter(run: Run) -> bool:
    """Decide the contact state where the motion begins or a force jumps; False: there is none."""
    on_border = run.task == ENTER and set_out(run)
    if not (decide_on_border(run) if on_border else decide(run, -1, -1, True)):
        return False
    take_up(run)
    run.n_chained = 0
    run.task = GO_ON
    return True


@native
def clear_known_zeros(run: Run) -> None:
    """Behind a step nothing is known to be zero."""
    for g in range(len(run.known_zeros)):
        run.known_zeros[g] = 0
    run.zeros_at_upper, run.zeros_at_lower, run.zeros_on_section = 0, 0, 0


@native
def keep_phase(run: Run, phase_interval: float) -> None:
    """Put the present state into the section buffer, and look ahead for the next phase."""
    keep_section(run)
    run.next_phase += phase_interval


@native
def pass_section(run: Run, crossing: float) -> None:
    """The section alone ends a step: the contact state stays."""
    run.n_chained = 0
    run.zeros_on_section = 1
    if run.section_direction == 0 or run.section_direction == crossing:
        run.y[run.section_state] = 0.0
        keep_section(run)


@native
def pass_border(run: Run, index: int, upwards: bool) -> None:
    """Go on in the neighbouring sector."""
    cross_border(run, upwards)
    fill(run)
    call_generated(run.taylor[index], run.coefficients, run.time, run.y, run.series)
    run.first_step = 0.0
    if upwards:
        run.zeros_at_lower = 1
    else:
        run.zeros_at_upper = 1


@native
def pass_piece(run: Run, index: int, hit: int, grazing: bool) -> None:
    """Go on in the next piece, unless the switching function only touches zero."""
    run.left_by = run.touched_guard = -1
    if grazing:
        step, offset = series_at_hand(run, index), (run.n_states + hit) * (run.order + 1)
        if leading(run.series, offset, run.order, step, 1) >= 0:
            run.touched_guard = hit
            return
    leave_piece(run, index, hit)


@native
def pass_event(
    run: Run, index: int, hit: int, residual: float, grazing: bool, sign_before: float, is_met: bool
) -> int:
    """What follows where a step ends with an event; GOING, or why nothing does."""
    border, with_tangents = hit < 0, len(run.tangents) > 0
    trigger_kind, contact = -1, run.sector_contact
    if not border:
        trigger_kind, contact = run.guard_kinds[index, hit], run.guard_contacts[index, hit]
    if with_tangents:
        switching_rates(run, index, run.n_guards[index] if border else hit)
    note_codes(run)
    if trigger_kind == JAMMING:
        return JAMMED
    if trigger_kind == SINGULAR:
        return DEPENDENT
    if trigger_kind == NORMAL and run.is_end[contact] == 1:
        return CONTACT_LOST
    impacted = trigger_kind == GAP and run.impact[index, contact] != 0
    energy = 0.0
    if impacted:
        energy = kinetic_energy(run, index)
        collide(run, index, contact)
    if trigger_kind == PIECE:
        pass_piece(run, index, hit, grazing)
    if border:
        pass_border(run, index, hit == UPPER_BORDER)
    elif not decide(run, trigger_kind, contact, grazing):
        return NO_STATE
    take_up(run)
    if impacted:
        run.impact_loss += energy - kinetic_energy(run, state_index(run.kinds, run.n_contacts))
        if run.bounces[contact] == 1 and run.kinds[contact] != SEPARATION:
            run.n_accumulations += 1
    if with_tangents:
        saltate(run)
    if run.section_kind == SECTION_ZERO:
        section_at_event(run, sign_before, is_met)
    book_event(run, contact, impacted or border, residual)
    return GOING


@native
def look_at_slip(run: Run, index: int, tau: float) -> None:
    """How fast contacts slip at the end of a step."""
    end = run.time + tau
    call_generated(run.field[index], run.coefficients, end, run.reached, run.outputs)
    for element in range(len(run.in_piece)):
        contact = run.element_contacts[element]
        v = run.outputs[run.contact_place[index] + PER_CONTACT * contact + SLIP_VELOCITY]
        if run.kinds[contact] == SLIP:
            run.greatest_slip[0] = max(run.greatest_slip[0], abs(v))


@native
def watch(run: Run, index: int, tau: float, measuring: bool) -> None:
    """What is asked for along a step."""
    if run.n_sampled < len(run.sample_times):
        take_samples(run, index, tau)
    if measuring:
        take_measures(run, index, tau)
    if len(run.tangents) > 0:
        move_tangents(run, index, tau)
    if len(run.greatest_slip) > 0:
        look_at_slip(run, index, tau)


@native
def advance(run: Run, t_stop: float, phase_interval: float, measuring: bool) -> int:
    """Run until t_stop, a full section buffer, a budget or an end; returns why it stopped."""
    out, stroboscopic, stop = run.reached, run.section_kind == SECTION_PHASE, GOING
    fill(run)
    if run.task != GO_ON and not enter(run):
        return NO_STATE
    while stop == GOING:
        t = run.time
        if run.n_sections >= run.max_sections:
            return SECTION_FULL
        if t >= t_stop:
            return REACHED
        if run.n_steps >= run.max_steps:
            return STEP_BUDGET
        if run.n_events >= run.max_events:
            return EVENT_BUDGET
        if stroboscopic and run.next_phase <= t:  # on an event
            keep_phase(run, phase_interval)
            continue
        # --- the step ---------------------------------------------------------------------------
        run.n_steps += 1
        index = state_index(run.kinds, run.n_contacts)
        goal, reaches_phase = t + begin_step(run, index), False
        if stroboscopic and run.next_phase <= min(goal, t_stop):
            goal, reaches_phase = run.next_phase, True
        elif t_stop <= goal:
            goal = t_stop
        step = goal - t
        hit, fraction, sign_before, crossing = first_fall(run, index, step)
        tau = step if hit == NOTHING else fraction * step
        residual, grazing = 0.0, True
        state_after(run, index, t, tau, out)
        if run.is_taylor == 1 and hit >= 0:
            tau, residual, grazing = polished(run, index, hit, tau, step, out)
        watch(run, index, tau, measuring)
        for i in range(run.n_states):
            run.y[i] = out[i]
            if not abs(out[i]) < run.bound:
                return NO_NUMBER if np.isnan(out[i]) else DIVERGED
        was_on_section = run.zeros_on_section > 0
        clear_known_zeros(run)
        if hit == NOTHING:
            run.time = goal
            run.n_chained = 0
            if reaches_phase:
                keep_phase(run, phase_interval)
            continue
        run.time = t + tau
        if hit == SECTION:
            pass_section(run, crossing)
            continue
        run.n_chained = run.n_chained + 1 if t + tau <= t else 0
        run.n_nearly_chained = run.n_nearly_chained + 1 if tau <= NEARLY_ONE * t else 0
        if run.n_chained > CHAIN_CAP:
            return CHATTERING
        if was_on_section and fraction <= SAME_INSTANT:  # what led here is counted
            sign_before = 0.0
        is_met = on_section(run, out[run.section_state], step)
        stop = pass_event(run, index, hit, residual, grazing, sign_before, is_met)
    return stop
