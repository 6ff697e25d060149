// SPDX-License-Identifier: Apache-2.0
// asip_operands_multiple_sva: a page of the registers is copied while no result is written.
module asip_operands_multiple_sva (
    input logic       clk_i,
    input logic       copy,
    input logic [2:0] write_i
);

  CopyAlone : assert property (@(posedge clk_i) copy |-> write_i == 3'b000)
  else $error("a result is written while its page is copied, and is lost");

endmodule

bind asip_operands_multiple asip_operands_multiple_sva u_sva (
    .clk_i,
    .copy(guard_i.copy),
    .write_i
);
