// SPDX-License-Identifier: Apache-2.0
// asip_aux_sva: the write port of bank C has one result at a time. The folded divider, whose outputs are zero
// while it has no result, is checked by those.
module asip_aux_sva #(
    parameter bit FoldedDivider = 1'b0
) (
    input logic clk_i,
    input logic rst_ni,
    input logic div_valid,
    input logic cmp_valid,
    input logic i2f_valid,
    input logic f2i_valid,
    input logic sin_valid,
    input logic load_valid,
    input logic [31:0] div_result
);

  OneResult : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $onehot0({div_valid && (!FoldedDivider || div_result != '0), cmp_valid, i2f_valid, f2i_valid,
                sin_valid, load_valid}))
  else $error("two units deliver in one cycle, their results are mixed");

endmodule

bind asip_aux asip_aux_sva #(
    .FoldedDivider(FoldedDivider)
) u_sva (.*);
