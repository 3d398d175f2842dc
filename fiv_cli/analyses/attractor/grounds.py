"""The grounds on which a class is told, and every number in them.

A class is a proof, not patience: what is told here stays so, however long the motion is followed.
What grows, stalls or drifts runs on; when its time is up it is ``undecided``, with the reason that
names the test that was not met.

*Equilibrium.* Let A be the Jacobian of sliding at a stable equilibrium, its eigenvalues to the
left of zero by `HURWITZ`. The modal amplitudes a = W y of the distance y from it bound what a
switching function g (slip velocity, normal force, ...) can still lose: the level set
``V(y) = max_g sum_i |b_g v_i| |a_i| / g(0) <= c``, c = 1, touches no switching surface, and
linear sliding never leaves it, since every |a_i| falls. So:

- where sliding is linear on the level set through the motion (its nonlinear part is less than
  `LINEAR` of the slowest decay, looked at in `SAMPLES` of its points), V < 1 decides, exactly;
- where it is not, the level must be seen to fall as the linear system's does: over two successive
  stretches of at least a natural period each, the amplitude of every mode that matters
  (`LEADING`) changes at its own rate to `AGREEMENT`, and meanwhile the level falls to `FALLEN`
  of what it was, or of c where that is less. About an unstable cycle of a Hopf bifurcation the
  rate is that of the linear system times 1 - (a/a_cycle)^2: `AGREEMENT` is met at half the
  amplitude of the cycle, inside of which all motions fall.

Every stable equilibrium of the point is asked. Where the drive stands still and friction is a
spring until it yields, each state of the springs has a place of rest of its own: the one that the
linear slide from here leads to is asked, and its modes that neither grow nor decay count as kept.
A state in which all contacts stick and nothing
moves, without excitation, is one too. `decay_margin` is 1 - V/c when it was told.

*A neutral oscillation*, which has no attractor. Where the eigenvalues of sliding are on the
imaginary axis to `HURWITZ` nothing is told to first order: over `FEWEST` turning points V must be
the same to `KEPT`, or stationary as a section set is below. Otherwise the motion runs on and, when
its time is up, the point is nonhyperbolic.

*Periodic.* The section repeats to `NEARLY` and ever closer; then Newton's method on the return map
closes the motion within `CLOSED` of its extent (`cycle_residual`), over the same sequence of
contacts, no further away than `REACH` times what the contraction leaves of the gap, nor than
`NEIGHBOUR` of the extent; and every nontrivial multiplier is below 1 by more than its
rounding. A cycle that fails is none of the motion's own: it runs on, and the next attempt waits for
`CLOSER` (as close as SETTLED), or for twice the time. Where the section repeats to `EARLY` only,
the return map must be linear as far as the cycle besides: the first step of Newton's method leads
there, but for `STRAIGHT` of the way.
Under an excitation a slide, or what has met no section, is asked at the end of its time anyway:
of few periods, a repetition that is down to rounding comes no closer.

*Quasi-periodic, chaotic.* The set of section points is stationary: means and spreads of its halves
differ by no more than `WANDERING` times what their partial sums explain, or `NEGLIGIBLE` of the
spread of its kind (`section_drift`): of every state on a torus, of the observed one in chaos. And
the Lyapunov exponent and the 0-1 test of the section agree (where the exponent says chaos, that of
what is left within bands visited in turn). On a torus, moreover, neighbours
neither approach nor part: between the halves the logarithm of their distance changes by no more
than `WANDERING` times what its partial sums explain, and that is no more than `STEADY`: a spiral
that is taken for a torus would need fifty times the window to come in by a factor e. And from where
the section nearly returns Newton's method finds no cycle within `NEIGHBOUR` that attracts, as it
does beside one that is approached slower than all this can tell.
"""

from __future__ import annotations

# --- equilibrium
HURWITZ = 1e-9  # growth rate below this share of the frequency: neither grows nor decays
LINEAR = 1e-3  # nonlinear part of the rates over the slowest decay that counts as none
SAMPLES = 12  # points of a level set at which that is looked at
LEADING = 0.1  # modes with this share of the largest contribution to the level are looked at
AGREEMENT = 0.25  # of a measured rate of decay with that of the eigenvalue
FALLEN = 0.5  # share to which the level falls meanwhile
KEPT = 1e-6  # share of itself by which the level of a neutral oscillation may vary

# --- periodic
NEARLY = 1e-5  # repetition of the section, over its values, at which a cycle is first looked for
EARLY = (3e-3, 1e-3, 3e-4, 1e-4)  # ... or at which one is, where the way there is straight
STRAIGHT = 0.1  # share of the way to a cycle by which the first step of Newton's method misses it
CLOSER = 1e-2  # ... and, after an attempt that failed, this share of the last one
CLOSED = 1e-7  # what a cycle may miss itself by after a period, over its extent
REACH = 10.0  # distance to the cycle over what the contraction leaves of the gap
NEIGHBOUR = 1e-2  # ... and over the extent of the motion

# --- quasi-periodic, chaotic
WANDERING = 3.0  # between 2.3, which one random set in a thousand reaches, and the 4 of a creep
NEGLIGIBLE = 1e-3  # of the spread: a difference of halves that is none
STEADY = 0.01  # change of the logarithm of a distance between the halves that may be hidden
UNNOTICED = 1e-6  # ... that is rounding
REGULAR, CHAOTIC = 0.3, 0.7  # what the 0-1 test must say
SIGNIFICANT = 3.0  # standard errors of an exponent
RESTING = 1e-3  # an exponent smaller than this per section point counts as zero
GROWN = 5.0  # ... and so does one by which a distance changes by less than e^5 over the window
