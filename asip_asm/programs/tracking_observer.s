; SPDX-License-Identifier: Apache-2.0
; The tracking law of tracking_optimised.s with the speed of each axis from an observer instead of the
; difference of two counts, so a count is no jump of the force (docs/law.md). The observer knows the
; acceleration that the law asks for. What the machine does besides, friction above all, is its third
; state; the law takes `observer_share` of it off.

.program  "tracking, observer of speed"
.interface "tracking_observer.interface.toml"
.const    observer = 1
.const    stamps = 0
.include  "tracking_law.inc"
