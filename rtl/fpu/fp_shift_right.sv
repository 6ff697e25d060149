// SPDX-License-Identifier: Apache-2.0
// fp_shift_right: logical right shift that collects the bits shifted out. Combinational.
// Contract: {value_o, sticky_o} keeps value_i / 2^amount_i exactly enough to round: sticky_o is the OR
// of every bit that left at the bottom. An amount of Width or more leaves zero and the OR of all.
module fp_shift_right #(
    parameter int unsigned Width = 48,
    parameter int unsigned AmountWidth = 6
) (
    input  logic [Width-1:0]       value_i,
    input  logic [AmountWidth-1:0] amount_i,
    output logic [Width-1:0]       value_o,
    output logic                   sticky_o
);

  // Level k shifts by 2^k; the widest first, so that the later ones are narrow.
  logic [AmountWidth:0][Width-1:0] level;
  logic [AmountWidth-1:0]          lost;

  assign level[AmountWidth] = value_i;

  for (genvar k = 0; k < AmountWidth; k++) begin : gen_level
    localparam int unsigned Dropped = ((1 << k) < Width) ? (1 << k) : Width;
    assign lost[k]  = amount_i[k] && (|level[k+1][Dropped-1:0]);
    assign level[k] = amount_i[k] ? (level[k+1] >> (1 << k)) : level[k+1];
  end

  assign value_o  = level[0];
  assign sticky_o = |lost;

endmodule
