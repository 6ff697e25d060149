// SPDX-License-Identifier: Apache-2.0
// n2_regfile_sva: r0 stays 0, so nobody writes it.
module n2_regfile_sva (
    input logic       clk_i,
    input logic       write_i,
    input logic [4:0] dst_i
);

  ZeroIsZero : assert property (@(posedge clk_i) write_i |-> dst_i != 5'd0)
  else $error("r0 was written");

endmodule

bind n2_regfile n2_regfile_sva u_sva (.*);
