; SPDX-License-Identifier: Apache-2.0
; The tracking law of tracking_optimised.s with speeds from the time between counts (docs/law.md): inputs
; stamp1 .. stamp5 are those of quadrature_time, age and direction of the last count of each encoder.

.program "tracking, speeds from time stamps"
.interface "tracking_stamps.interface.toml"
.const    observer = 0
.const    stamps = 1
.include  "tracking_law.inc"
