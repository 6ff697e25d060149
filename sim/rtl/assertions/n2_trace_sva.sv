// SPDX-License-Identifier: Apache-2.0
// n2_trace_sva: one record for each instruction that leaves stage A, in the cycle after.
module n2_trace_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        en_i,
    input logic        valid_a_i,
    input logic        trace_valid_o,
    input logic [31:0] trace_pc_o
);

  OneRecord : assert property (@(posedge clk_i) disable iff (!rst_ni)
      1'b1 |=> trace_valid_o == $past(en_i && valid_a_i))
  else $error("a record without an instruction, or an instruction without one");

  PcOfAWord : assert property (@(posedge clk_i) disable iff (!rst_ni)
      trace_valid_o |-> trace_pc_o[1:0] == 2'b00)
  else $error("the record of an instruction that is at no word");

endmodule

bind n2_trace n2_trace_sva u_sva (.*);
