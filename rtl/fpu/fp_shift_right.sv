// SPDX-License-Identifier: Apache-2.0
// fp_shift_right: logical right shift that collects the bits shifted out. Combinational.
// Contract: {value_o, sticky_o} keeps value_i / 2^amount_i exactly enough to round: sticky_o is the OR
// of every bit that left at the bottom. An amount of Width or more leaves zero and the OR of all.
// WidestFirst sets the order of the binary levels, for area only: 1 where few output bits are used,
// 0 where value_i has few bits at the top and zeros below.
// With SYNTHESIS defined it has no check of its parameters, which some synthesis tools refuse.
module fp_shift_right #(
    parameter int unsigned Width = 48,
    parameter int unsigned AmountWidth = 6,
    parameter bit WidestFirst = 1'b1
) (
    input  logic [Width-1:0]       value_i,
    input  logic [AmountWidth-1:0] amount_i,
    output logic [Width-1:0]       value_o,
    output logic                   sticky_o
);

  logic [AmountWidth:0][Width-1:0] level;  // level 0 is the input
  logic [AmountWidth-1:0] lost;

  assign level[0] = value_i;

  genvar k;
  generate
    for (k = 0; k < AmountWidth; k++) begin : gen_level
      localparam int unsigned Bit = WidestFirst ? AmountWidth - 1 - k : k;
      localparam int unsigned Dropped = ((1 << Bit) < Width) ? (1 << Bit) : Width;
      assign lost[k]    = amount_i[Bit] && (|level[k][Dropped-1:0]);
      assign level[k+1] = amount_i[Bit] ? (level[k] >> (1 << Bit)) : level[k];
    end
  endgenerate

`ifndef SYNTHESIS
  generate
    if (Width < 1 || AmountWidth < 1 || AmountWidth > 31) begin : gen_check
      $error(
          "fp_shift_right: Width=%0d, AmountWidth=%0d, must be at least 1, the latter at most 31", Width, AmountWidth
      );
    end
  endgenerate
`endif

  assign value_o  = level[AmountWidth];
  assign sticky_o = |lost;

endmodule
