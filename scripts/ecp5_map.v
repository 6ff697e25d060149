// SPDX-License-Identifier: Apache-2.0
// Technology map of Yosys for ECP5. A cell of a carry chain has two tables of four inputs before its
// adder, so that the selection of fp_select_sub and the digit of a root need no level of logic.
(* techmap_celltype = "fp_select_sub" *)
module ecp5_select_sub (
    input         root_i,
    input         select_i,
    input  [27:0] place_i,
    input  [27:0] one_i,
    input  [27:0] zero_i,
    input  [27:0] subtrahend_i,
    output [27:0] difference_o
);
  // A table gives the propagate signal of its bit. Its lowest four entries, which A and B select, give the carry of a
  // bit that does not propagate.
  // Usual bit, propagate ~A ^ (D ? B : C), carry ~A: A subtrahend, B one, C zero, D select.
  localparam [15:0] TABLE = 16'h99a5;
  // Bit of the digit. The subtrahend of a root is !select there, so the propagate signal is select ? !C : D ^ B with
  // A select, B = !root && !subtrahend, C = root ? one : one ^ subtrahend, D zero; both are known before select.
  // The carry, A | B, is wrong only in a division that selects a zero and subtracts a one.
  localparam [15:0] DIGIT = 16'h1b4e;
  // Next cell, without a bit of the result: it ends the carry then. A select, B = !root && subtrahend && !one.
  localparam [15:0] MEND = 16'h0070;

  // 1 if the place is a constant.
  parameter [27:0] _TECHMAP_CONSTMSK_place_i_ = 0;
  parameter [27:0] _TECHMAP_CONSTVAL_place_i_ = 0;
  wire _TECHMAP_FAIL_ = !(&_TECHMAP_CONSTMSK_place_i_);

  function integer place_of(input [27:0] one_hot);
    integer i;
    begin
      place_of = 0;
      for (i = 0; i < 28; i = i + 1) if (one_hot[i]) place_of = i;
    end
  endfunction
  localparam integer PLACE = place_of(_TECHMAP_CONSTVAL_place_i_);

  wire [29:0] a, b, c, d, sum;
  wire [15:0] carry;
  assign carry[0] = 1'b1;
  genvar i;
  generate
    for (i = 0; i < 30; i = i + 1) begin : half
      localparam integer BIT = i > PLACE ? i - 1 : i;
      if (i == PLACE + 1 || i == 29) begin : mend
        assign a[i] = select_i;
        assign b[i] = !root_i && subtrahend_i[PLACE] && !one_i[PLACE];
        assign c[i] = 1'b1;
        assign d[i] = 1'b0;
      end else if (i == PLACE) begin : digit
        assign a[i] = select_i;
        assign b[i] = !root_i && !subtrahend_i[BIT];
        assign c[i] = one_i[BIT] ^ (!root_i && subtrahend_i[BIT]);
        assign d[i] = zero_i[BIT];
        assign difference_o[BIT] = sum[i];
      end else begin : usual
        assign a[i] = subtrahend_i[BIT];
        assign b[i] = one_i[BIT];
        assign c[i] = zero_i[BIT];
        assign d[i] = select_i;
        assign difference_o[BIT] = sum[i];
      end
    end
    for (i = 0; i < 15; i = i + 1) begin : pair
      CCU2C #(
          .INIT0(2 * i == PLACE ? DIGIT : 2 * i == PLACE + 1 ? MEND : TABLE),
          .INIT1(2 * i + 1 == PLACE ? DIGIT : 2 * i == PLACE ? MEND : TABLE),
          .INJECT1_0("NO"),
          .INJECT1_1("NO")
      ) bits (
          .CIN (carry[i]),
          .A0  (a[2*i]),
          .B0  (b[2*i]),
          .C0  (c[2*i]),
          .D0  (d[2*i]),
          .A1  (a[2*i+1]),
          .B1  (b[2*i+1]),
          .C1  (c[2*i+1]),
          .D1  (d[2*i+1]),
          .S0  (sum[2*i]),
          .S1  (sum[2*i+1]),
          .COUT(carry[i+1])
      );
    end
  endgenerate
endmodule
