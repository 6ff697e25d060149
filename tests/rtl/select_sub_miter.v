// SPDX-License-Identifier: Apache-2.0
// fp_select_sub twice, for tests/rtl/test_ecp5_map.py: in `mapped` the technology map replaces it.
module mapped (
    input select_i,
    input [27:0] one_i,
    input [27:0] zero_i,
    input [27:0] subtrahend_i,
    output [27:0] difference_o
);
  fp_select_sub u_sub (
      .select_i(select_i),
      .one_i(one_i),
      .zero_i(zero_i),
      .subtrahend_i(subtrahend_i),
      .difference_o(difference_o)
  );
endmodule

module miter (
    input select_i,
    input [27:0] one_i,
    input [27:0] zero_i,
    input [27:0] subtrahend_i,
    output same_o
);
  wire [27:0] cells, rtl;

  mapped u_cells (
      .select_i(select_i),
      .one_i(one_i),
      .zero_i(zero_i),
      .subtrahend_i(subtrahend_i),
      .difference_o(cells)
  );
  fp_select_sub u_rtl (
      .select_i(select_i),
      .one_i(one_i),
      .zero_i(zero_i),
      .subtrahend_i(subtrahend_i),
      .difference_o(rtl)
  );
  assign same_o = cells == rtl;
endmodule
