// SPDX-License-Identifier: Apache-2.0
// fp_fine_left: stage e5 of fp_fma, left shift of a sum by 0..15 places. Combinational.
// Contract: the shift count_o is the number of leading bits that equal negative_i, but at most 15. A one in room_i limits
// it to the place of that bit, where bit 15 is place 0. sig_o has the upper 26 bits of the shifted window; sticky_o is
// set if a bit below them is.
// A module of its own, as it has more levels of logic than other stages: a technology mapper saves area, and adds
// levels, up to the slowest path of a module.
module fp_fine_left (
    input  logic [47:0] window_i,
    input  logic        negative_i,
    input  logic [15:0] room_i,
    output logic [3:0]  count_o,
    output logic [25:0] sig_o,
    output logic        sticky_o
);

  logic [15:0] stop, sticky;
  logic [40:0] shifted;  // the lowest bits count for sticky only
  logic unused_empty, unused_low;

  always_comb begin
    stop = (window_i[47:32] ^ {16{negative_i}}) | room_i;
    // What a shift by i leaves below, next to the shift.
    for (int i = 0; i < 16; i++) sticky[i] = |(window_i[21:0] & (22'h3f_ffff >> i));
  end

  fp_lzc #(
      .CountWidth(4)
  ) u_lzc (
      .value_i(stop),
      .count_o(count_o),
      .zero_o (unused_empty)
  );

  // Widest shift first: the upper bits of the count are known first.
  always_comb begin
    shifted = window_i[47:7];
    for (int k = 3; k >= 0; k--) if (count_o[k]) shifted = shifted << (1 << k);
  end

  assign sig_o      = shifted[40:15];
  assign sticky_o   = sticky[count_o];
  assign unused_low = ^shifted[14:0];

endmodule
