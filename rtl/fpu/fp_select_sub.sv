// SPDX-License-Identifier: Apache-2.0
// fp_select_sub: one of two numbers minus a third. Combinational.
// Contract: difference_o = (select_i ? one_i : zero_i) - subtrahend_i, modulo 2^28. A module of its own,
// so that a technology map can select in the cells of the carry chain (scripts/ecp5_map.v).
module fp_select_sub (
    input  logic        select_i,
    input  logic [27:0] one_i,
    input  logic [27:0] zero_i,
    input  logic [27:0] subtrahend_i,
    output logic [27:0] difference_o
);
  assign difference_o = (select_i ? one_i : zero_i) - subtrahend_i;
endmodule
