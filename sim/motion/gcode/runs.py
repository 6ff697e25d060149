# SPDX-License-Identifier: Apache-2.0
"""Moves of the machine for one motion of a program: offsets, feed, pieces in table coordinates."""

from __future__ import annotations

import math
from dataclasses import replace

from sim.motion.gcode import table_frame
from sim.motion.gcode.arcs import Centre
from sim.motion.gcode.state import Modes, State
from sim.motion.geometry.curves import curve_of
from sim.motion.geometry.moves import Motion, Move, Plane, Pose


def program_moves(
    state: State, motion: Motion, end: Pose, centre: Centre | None = None, turns: int = 1
) -> list[Move]:
    """Moves to `end` in programmed coordinates, centre likewise; the position is then there."""
    finish = state.end_in_frame(end)
    if centre is not None:
        first, second = state.modes.plane.axes
        point = list(end)
        point[first], point[second] = centre
        placed = state.in_frame(point)
        if state.modes.plane is not Plane.XY:
            placed = state.rotation.turned_back(placed)
        centre = placed[first], placed[second]
    make = _table_moves if state.modes.in_table_frame else machine_moves
    return make(state, motion, finish, centre, turns)


def machine_moves(
    state: State, motion: Motion, end: Pose, centre: Centre | None = None, turns: int = 1
) -> list[Move]:
    """The move to `end` in machine coordinates; the position is then there."""
    start, state.position = state.position, end
    move = _move(state, motion, start, end, centre, turns)
    if motion is not Motion.RAPID and state.modes.inverse_time:
        move = replace(move, feed=_feed(state, move))
    return [move]


def _move(
    state: State,
    motion: Motion,
    start: Pose,
    end: Pose,
    centre: Centre | None = None,
    turns: int = 1,
) -> Move:
    """The move with the modes in force; without a feed under G93."""
    modes, feed = state.modes, None
    turned = motion.is_arc and bool(state.rotation) and modes.plane is not Plane.XY
    if motion is not Motion.RAPID and not modes.inverse_time:
        feed = _rate(modes, not motion.is_arc and start[:3] == end[:3])
    return Move(
        *state.block,
        motion,
        start,
        end,
        feed,
        modes.plane if motion.is_arc else None,
        centre,
        modes.tolerance,
        modes.merge,
        exact_stop=modes.exact_stop,
        override=modes.override,
        turns=turns,
        plane_turn=state.rotation.degrees if turned else 0.0,
    )


def _feed(state: State, move: Move) -> float:
    """Feed of a move as mm/min, of one that turns only the table degree/min."""
    modes = state.modes
    if modes.inverse_time:
        return modes.rate * _length(move)
    return _rate(modes, move.turns_only_the_table)


def _rate(modes: Modes, turns_only_the_table: bool) -> float:
    """The F number as mm/min, or degree/min."""
    return modes.rate if turns_only_the_table else modes.rate * modes.feed_mm_per_unit


def _table_moves(
    state: State, motion: Motion, finish: Pose, centre: Centre | None, turns: int
) -> list[Move]:
    """The move in pieces that are straight for the machine; finish in table coordinates."""
    whole = _move(state, motion, state.frame_position(), finish, centre, turns)
    straight = Motion.RAPID if motion is Motion.RAPID else Motion.LINEAR
    # Minutes of the whole move at its feed, as the tool sees it on the work piece.
    length = _length(whole)
    feed = 0.0 if motion is Motion.RAPID else _feed(state, whole)
    poses = table_frame.pieces(whole, state.pivot)
    moves: list[Move] = []
    for number, pose in enumerate(poses):
        move = replace(_move(state, straight, state.position, pose), inner=number > 0)
        if len(poses) > 1:
            move = replace(move, merge=0.0)
        if feed > 0.0 and length > 0.0:
            move = replace(move, feed=_length(move) * len(poses) * feed / length)
        state.position = pose
        if straight is Motion.RAPID or (move.feed or 0.0) > 0.0:  # else it stays where it is
            moves.append(move)
    return moves


def _length(move: Move) -> float:
    """Length of a move as its feed counts it: mm of tool path, or degree of the table alone."""
    curve = curve_of(move)
    if curve is None:
        return 0.0
    return math.degrees(curve.length) if move.turns_only_the_table else curve.length * 1e3
