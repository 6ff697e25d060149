// SPDX-License-Identifier: Apache-2.0
// fp_lzc: number of leading zeros. Combinational.
// Contract: Width = 2^CountWidth bits; count_o is meaningful only while zero_o is low.
// With SYNTHESIS defined it has no check of its parameter, which some synthesis tools refuse.
module fp_lzc #(
    parameter int unsigned CountWidth = 5
) (
    input  logic [(1<<CountWidth)-1:0] value_i,
    output logic [CountWidth-1:0]      count_o,
    output logic                       zero_o
);

  localparam int unsigned Width = 1 << CountWidth;

  // Tournament of groups: level k holds Width / 2^k groups of 2^k bits, each with "all zero" and the
  // count inside the group (CountWidth bits each). Group g of level k + 1 is formed by the groups
  // 2g + 1 (upper half) and 2g of level k.
  logic [CountWidth:0][Width-1:0] empty;
  logic [CountWidth:0][Width*CountWidth-1:0] count;

  assign empty[0] = ~value_i;
  assign count[0] = '0;

  genvar k, g;
  generate
    for (k = 0; k < CountWidth; k++) begin : gen_level
      for (g = 0; g < Width; g++) begin : gen_group
        if (g < (Width >> (k + 1))) begin : gen_pair
          assign empty[k+1][g] = empty[k][2*g+1] && empty[k][2*g];
          assign count[k+1][g*CountWidth+:CountWidth] =
            empty[k][2*g+1] ? (count[k][2*g*CountWidth+:CountWidth] | (CountWidth'(1) << k))
                            : count[k][(2*g+1)*CountWidth+:CountWidth];
        end else begin : gen_none
          assign empty[k+1][g] = 1'b1;
          assign count[k+1][g*CountWidth+:CountWidth] = '0;
        end
      end
    end
  endgenerate

`ifndef SYNTHESIS
  generate
    if (CountWidth < 1) begin : gen_check
      $error("fp_lzc: CountWidth=%0d, must be at least 1", CountWidth);
    end
  endgenerate
`endif

  assign zero_o  = empty[CountWidth][0];
  assign count_o = count[CountWidth][CountWidth-1:0];

endmodule
