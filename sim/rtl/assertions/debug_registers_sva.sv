// SPDX-License-Identifier: Apache-2.0
// debug_registers_sva: reads take two cycles, writes one, and each run counts once.
module debug_registers_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        read_i,
    input logic        write_i,
    input logic        waitrequest_o,
    input logic        csr_write_o,
    input logic        stage_write_o,
    input logic        ended_i,
    input logic [31:0] runs_o
);

  ReadTakesTwo : assert property (@(posedge clk_i) disable iff (!rst_ni)
      read_i && waitrequest_o |=> !waitrequest_o)
  else $error("a read took a third cycle");

  WriteTakesOne : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_i && !read_i |-> !waitrequest_o)
  else $error("a write waits");

  OnePlace : assert property (@(posedge clk_i) disable iff (!rst_ni)
      csr_write_o || stage_write_o |-> write_i && !(csr_write_o && stage_write_o))
  else $error("a write of two places, or without a request");

  RunsCount : assert property (@(posedge clk_i) disable iff (!rst_ni)
      1'b1 |=> runs_o == $past(runs_o) + 32'($past(ended_i)))
  else $error("a run was not counted, or twice");

endmodule

bind debug_registers debug_registers_sva u_sva (.*);
