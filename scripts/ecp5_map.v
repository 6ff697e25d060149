// SPDX-License-Identifier: Apache-2.0
// Technology map of Yosys for ECP5. A cell of a carry chain has a table of four inputs before its
// adder, so that the selection of fp_select_sub needs no level of logic.
(* techmap_celltype = "fp_select_sub" *)
module ecp5_select_sub (
    input         select_i,
    input  [27:0] one_i,
    input  [27:0] zero_i,
    input  [27:0] subtrahend_i,
    output [27:0] difference_o
);
  // Propagate ~A ^ (D ? B : C): A subtrahend, B one, C zero, D select. Without it the carry is ~A, as
  // the lowest four entries say.
  localparam [15:0] TABLE = 16'h99a5;
  wire [14:0] carry;
  assign carry[0] = 1'b1;
  genvar i;
  generate
    for (i = 0; i < 14; i = i + 1) begin : pair
      CCU2C #(
          .INIT0(TABLE),
          .INIT1(TABLE),
          .INJECT1_0("NO"),
          .INJECT1_1("NO")
      ) bits (
          .CIN (carry[i]),
          .A0  (subtrahend_i[2*i]),
          .B0  (one_i[2*i]),
          .C0  (zero_i[2*i]),
          .D0  (select_i),
          .A1  (subtrahend_i[2*i+1]),
          .B1  (one_i[2*i+1]),
          .C1  (zero_i[2*i+1]),
          .D1  (select_i),
          .S0  (difference_o[2*i]),
          .S1  (difference_o[2*i+1]),
          .COUT(carry[i+1])
      );
    end
  endgenerate
endmodule
