# SPDX-License-Identifier: Apache-2.0
"""A move whose speed may be overridden or stopped at any instant.

Every change re-plans from the position, speed and acceleration of that instant, so the limits hold
throughout. A speed above the new limit falls as fast as acceleration and jerk allow.
"""

from __future__ import annotations

import bisect
import math
from dataclasses import replace

from sim.motion.planner.optimal import (
    SAME_LENGTH,
    SAME_SPEED,
    Limits,
    stopping_length,
    time_optimal,
    transition,
)
from sim.motion.planner.phases import Profile, State, Step, run
from sim.motion.planner.scurve import require

MAX_OVERRIDE = 2.0
# Lower ones stop, as 0 does: the move would take longer than a day for each second of it.
LEAST_OVERRIDE = 1e-5


class OverriddenMove:
    """One move of `length` from speed v0 to ve at `feed`, override 1; time and position from 0.

    length [unit]; feed, v0, ve [unit/s]; limits: those of the machine, never exceeded. The speed
    limit is override * feed, at most limits.speed. Raises SCurveError / TooShortError as
    `time_optimal` does.
    """

    def __init__(
        self, length: float, feed: float, limits: Limits, v0: float = 0.0, ve: float = 0.0
    ) -> None:
        require(feed > 0.0, "feed", feed, "feed > 0")
        require(ve <= feed, "ve", ve, f"ve <= feed = {feed!r}")
        self.length, self.feed, self.limits, self.ve = length, feed, limits, ve
        self.override = 1.0
        self.changes = [0.0]
        speed = min(feed, limits.speed)
        self.profiles = [time_optimal(length, v0, ve, replace(limits, speed=speed))]

    @property
    def end_time(self) -> float:
        """Time at which the present plan ends [s]; the move is over then unless it was stopped."""
        return self.changes[-1] + self.profiles[-1].total_time

    @property
    def finished_at_length(self) -> bool:
        """Whether the present plan ends at the end of the move, not at a stop before it."""
        return self.profiles[-1].end.position == self.length

    def at(self, t: float) -> State[float]:
        """State at time t [s] of all plans up to now."""
        if t >= self.end_time:
            return self.profiles[-1].end
        index = max(0, bisect.bisect_right(self.changes, t) - 1)
        return self.profiles[index].at(t - self.changes[index])

    def speed_limit(self, override: float) -> float:
        """Speed limit at an override [unit/s]."""
        return min(override * self.feed, self.limits.speed)

    def set_override(self, t: float, override: float) -> None:
        """Change the override (0..2) at time t [s], not before the last change; 0 stops, as do

        those below LEAST_OVERRIDE.

        The end speed falls with the speed limit. Where the way left does not suffice for the end
        speed or the stop wanted, the move ends at the nearest speed that is possible.
        """
        require(
            0.0 <= override <= MAX_OVERRIDE,
            "override",
            override,
            f"0 <= override <= {MAX_OVERRIDE}",
        )
        require(t >= self.changes[-1], "t", t, f"t >= last change = {self.changes[-1]!r}")
        if override < LEAST_OVERRIDE:
            override = 0.0
        self.override = override
        if self.finished_at_length and t >= self.end_time:
            return
        state = self.at(t)
        left = self.length - state.position
        speed = self.speed_limit(override)
        wanted = min(self.ve, speed)
        planned = self.profiles[-1].end.speed
        needed = stopping_length(state.speed, state.acceleration, wanted, self.limits)
        slack = left - needed
        noise = self._noise(state)
        if speed == 0.0 and slack >= -noise:
            profile = self._stop(state, snap=abs(slack) <= noise)
        elif slack > noise:
            plan = time_optimal(
                left, state.speed, wanted, replace(self.limits, speed=speed), state.acceleration
            )
            profile = Profile(state, plan.steps, State(self.length, wanted, 0.0))
        else:
            nearest = self._nearest(left, state, planned, wanted)
            if nearest is None:
                return
            profile = nearest
        self.changes.append(t)
        self.profiles.append(profile)

    def stop(self, t: float) -> None:
        """Stop as fast as the limits allow, on the path; `set_override` goes on."""
        self.set_override(t, 0.0)

    def _noise(self, state: State[float]) -> float:
        """Way [unit] that is rounding: a speed wrong by the rounding of the greatest one is

        corrected by a pulse of acceleration whose time is a root, and the way grows by that time.
        """
        rounding = SAME_SPEED * self.limits.speed
        pulse = 2 * math.sqrt(rounding / self.limits.jerk)
        return SAME_LENGTH * self.length + (state.speed + rounding) * pulse

    def _stop(self, state: State[float], snap: bool) -> Profile:
        steps = transition(state.speed, state.acceleration, 0.0, self.limits)
        place = self.length if snap else run(state, steps).position
        return Profile(state, steps, State(place, 0.0, 0.0))

    def _nearest(
        self, left: float, state: State[float], planned: float, wanted: float
    ) -> Profile | None:
        """Direct change to the reachable end speed nearest to `wanted`; None: the one planned.

        Sought along the pulse of acceleration, not along the end speed, whose rounding would be
        magnified: see _noise.
        """
        v, a = state.speed, state.acceleration
        good, bad = (
            self._pulse_of(transition(v, a, goal, self.limits)) for goal in (planned, wanted)
        )

        def end(pulse: float) -> State[float]:
            return run(State(0.0, v, a), self._pulse(a, pulse))

        if good == bad or end(good).position > left:
            return None
        for _ in range(100):
            middle = (good + bad) / 2
            if end(middle).position <= left:
                good = middle
            else:
                bad = middle
        steps = self._pulse(a, good)
        return Profile(state, steps, State(self.length, max(0.0, end(good).speed), 0.0))

    @staticmethod
    def _pulse_of(steps: list[Step]) -> float:
        """Signed size of a pulse [s]: time of its rise and its constant part."""
        rise = steps[0].duration if len(steps) > 1 else 0.0
        hold = steps[1].duration if len(steps) > 1 else 0.0
        return math.copysign(rise + hold, steps[0].jerk)

    def _pulse(self, a: float, size: float) -> list[Step]:
        """Steps of a pulse from acceleration a; the inverse of _pulse_of."""
        j, am = self.limits.jerk, self.limits.acceleration
        sign = math.copysign(1.0, size)
        # Against the present acceleration, the first part of the rise only brings that to 0.
        peak = min(am, sign * a + j * abs(size))
        rise = (peak - sign * a) / j
        return [
            Step(rise, sign * j),
            Step(max(0.0, abs(size) - rise), 0.0),
            Step(abs(peak) / j, -math.copysign(j, sign * peak)),
        ]
