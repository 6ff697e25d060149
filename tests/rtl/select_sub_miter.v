// SPDX-License-Identifier: Apache-2.0
// fp_select_sub twice, for tests/rtl/test_ecp5_map.py: in `mapped` the technology map replaces it. PLACE is a macro, as
// a parameter would not reach the cell as a constant.
module mapped (
    input root_i,
    input select_i,
    input [27:0] one_i,
    input [27:0] zero_i,
    input [27:0] subtrahend_i,
    output [27:0] difference_o
);
  fp_select_sub u_sub (
      .root_i(root_i),
      .select_i(select_i),
      .place_i(28'd1 << `PLACE),
      .one_i(one_i),
      .zero_i(zero_i),
      .subtrahend_i(subtrahend_i),
      .difference_o(difference_o)
  );
endmodule

module miter (
    input root_i,
    input select_i,
    input [27:0] one_i,
    input [27:0] zero_i,
    input [27:0] subtrahend_i,
    output same_o
);
  wire [27:0] cells, rtl;

  mapped u_cells (
      .root_i(root_i),
      .select_i(select_i),
      .one_i(one_i),
      .zero_i(zero_i),
      .subtrahend_i(subtrahend_i),
      .difference_o(cells)
  );
  fp_select_sub u_rtl (
      .root_i(root_i),
      .select_i(select_i),
      .place_i(28'd1 << `PLACE),
      .one_i(one_i),
      .zero_i(zero_i),
      .subtrahend_i(subtrahend_i),
      .difference_o(rtl)
  );
  assign same_o = cells == rtl;
endmodule
