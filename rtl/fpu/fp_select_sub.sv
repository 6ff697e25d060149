// SPDX-License-Identifier: Apache-2.0
// fp_select_sub: a subtraction of fp_divsqrt whose minuend is selected. Combinational.
// Contract: difference_o = (select_i ? one_i : zero_i) - subtrahend, modulo 2^28. The subtrahend is subtrahend_i; for a
// root its bit at place_i, which is one-hot and a constant, is the digit just found, !select_i.
// A module of its own, so that a technology map can select and enter the digit in the cells of the carry chain
// (scripts/ecp5_map.v). The map finds a module by its name, which a parameter would change; so the place is a port.
module fp_select_sub (
    input  logic        root_i,
    input  logic        select_i,
    input  logic [27:0] place_i,
    input  logic [27:0] one_i,
    input  logic [27:0] zero_i,
    input  logic [27:0] subtrahend_i,
    output logic [27:0] difference_o
);

  logic [27:0] subtrahend;

  always_comb begin
    subtrahend = subtrahend_i;
    if (root_i) subtrahend = (subtrahend_i & ~place_i) | (place_i & {28{!select_i}});
  end

  assign difference_o = (select_i ? one_i : zero_i) - subtrahend;

endmodule
