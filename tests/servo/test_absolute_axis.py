# SPDX-License-Identifier: Apache-2.0
"""An encoder on BiSS-C without lines A and B on a drive axis: count, faults, trips, and the other
ports' words for it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sim.rtl.gen.absolute_regmap import REGMAP as ABSOLUTE
from sim.rtl.gen.drive_regmap import REGMAP as DRIVE
from tests.servo import clocked, test_endat, test_ssi
from tests.servo.clocked import Accesses, Clocked, signed
from tests.servo.test_absolute_position import EXACT
from tests.servo.test_biss import Encoder, with_encoder

HERE = Path(__file__).parent
PERIOD, WIDTH, FIRST = 1250, 26, 20
FRAMES = 30
SPEED = 0.125  # counts a clock


class Axis(Accesses):
    """The axis with its encoder: the front-end's registers."""

    def __init__(self) -> None:
        super().__init__(DRIVE, (FRAMES + 2) * PERIOD)
        self.columns["trigger"] = np.zeros((FRAMES + 2) * PERIOD, dtype=np.int64)
        self.columns["trigger"][5] = 1

    def run(self, encoder: Encoder) -> tuple[list[int], dict[str, np.ndarray]]:
        """Words read, and position, low gates by clock."""
        outputs = ("readdata", "waitrequest", "position", "low", "ma")
        folders = (*clocked.FOLDERS, HERE)
        block = Clocked("absolute_loop", (*self.columns, "slo"), outputs, None, folders)
        first = {name: values[: 2 * PERIOD - 1] for name, values in self.columns.items()}
        short = with_encoder(block, encoder, 1, 2 * PERIOD - 1, ("ma", "slo"), **first)["ma"]
        # All frames take as long as the first one.
        ma = np.concatenate([short, *[short[PERIOD - 1 :]] * (FRAMES + 1)])[: (FRAMES + 2) * PERIOD]
        found = block.run(len(ma), **self.columns, slo=encoder.line(ma))
        np.testing.assert_array_equal(found["ma"], ma)
        return self.words(found), found


def encoder(**changed: dict[int, object]) -> Encoder:
    """At a constant speed, its first position near the end of its range; by frame, what is
    otherwise."""
    instants = np.arange(FRAMES + 1) * PERIOD + PERIOD - 1 + 6
    words = ((1 << WIDTH) - 300 + np.floor(SPEED * (instants - instants[0])).astype(int)) % (
        1 << WIDTH
    )
    frames = [Encoder(int(word), delay=37) for word in words]
    for name, values in changed.items():
        for number, value in values.items():
            frames[number] = replace(frames[number], **{name: value})
    return replace(frames[0], later=tuple(frames[1:]))


def test_count__is_the_encoders_across_its_range_and_in_the_front_end():
    axis = Axis()
    axis.read(25 * PERIOD, "POSITION", "STATUS", "ILLEGAL")
    (position, status, bad), found = axis.run(encoder())
    true = SPEED * (np.arange(len(found["position"])) - (PERIOD - 1 + 6))
    seen = signed(found["position"], 32)
    later = slice(4 * PERIOD, FRAMES * PERIOD)
    # Two registers of the front-end.
    assert np.abs(seen - true + 2 * SPEED)[later].max() <= EXACT
    assert abs(position - true[25 * PERIOD]) <= EXACT + 1
    assert (status, bad) == (0, 0) and seen.max() > 1000


@pytest.mark.parametrize("guard", [0, 1])
def test_wrong_frames__are_bridged_and_a_lost_encoder_trips_the_guarded_axis(guard):
    """A wrong bit, an error bit and a silent frame each; later all frames are silent."""
    axis = Axis()
    axis.write(10, "GUARD", encoder=guard)
    axis.write(11, "MODE", axis0=1)  # brake: low gates on
    axis.read(20 * PERIOD, "STATUS", "ILLEGAL")
    axis.read(31 * PERIOD, "STATUS")
    lost = {number: 6 for number in range(22, FRAMES + 1)}
    flips = {6: 3, 14: 20} | lost
    words, found = axis.run(encoder(flip=flips, error={10: True}))
    fields = DRIVE.registers["STATUS"].fields
    assert (fields["illegal"].of(words[0]), words[1]) == (0, 3)
    assert (fields["illegal"].of(words[2]), fields["trip"].of(words[2])) == (1, guard)
    seen = signed(found["position"], 32)
    true = SPEED * (np.arange(len(seen)) - (PERIOD - 1 + 6) - 2)
    assert np.abs(seen - true)[4 * PERIOD : 22 * PERIOD].max() <= EXACT
    assert bool(found["low"][-1]) == (not guard)


def test_jump__trips_and_a_clear_of_the_axis_forgets_it():
    axis = Axis()
    axis.write(10, "GUARD", encoder=1)
    axis.write(11, "MODE", axis0=1)
    axis.read(12 * PERIOD, "STATUS", "ILLEGAL")
    for clock in (0, 2):  # the flag first, then the trip
        axis.write(20 * PERIOD + clock, "CONTROL", clear=1)
    axis.read(20 * PERIOD + 10, "STATUS", "ILLEGAL")
    frames = encoder()
    words = [frames, *frames.later]
    words[8] = replace(words[8], position=words[8].position + 1000)
    before, count, after, cleared = axis.run(replace(words[0], later=tuple(words[1:])))[0]
    fields = DRIVE.registers["STATUS"].fields
    assert (fields["illegal"].of(before), fields["trip"].of(before), count) == (1, 1, 1)
    assert (fields["illegal"].of(after), fields["trip"].of(after), cleared) == (0, 0, 0)


def test_ports_of_ssi_and_endat__end_frames_for_the_count():
    """A right frame, and one with the encoder's error bit."""
    endat = test_endat.Encoder(test_endat.Frame(), test_endat.at(0xABCDE))
    ssi = test_ssi.Encoder(test_ssi.Word(alarm=True), test_ssi.at(0xABC))
    for top, right, wrong, parameters, ports in (
        ("endat_port", endat, replace(endat, f1=True), endat.frame.parameters, test_endat.PORTS),
        ("ssi_port", ssi, replace(ssi, alarm=True), ssi.word.parameters, ("clock", "data")),
    ):
        *seen, line = ports
        outputs = ("busy", "done", "good", "position", *seen)
        host = Accesses(ABSOLUTE, 30_000)
        host.write(20, "CONTROL", start=1)
        block = Clocked(top, (*host.columns, line), outputs, parameters)
        for encoder_, good in ((right, 1), (wrong, 0)):
            found = with_encoder(block, encoder_, 1, 30_000, ports, **host.columns)
            (end,) = np.flatnonzero(found["done"])
            assert found["good"][end] == good and found["busy"][22:end].all()
            assert found["position"][end] == encoder_.position(0)
