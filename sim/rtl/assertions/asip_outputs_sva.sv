// SPDX-License-Identifier: Apache-2.0
// asip_outputs_sva: a run that ends well shows its page, a fault the safe one; safe values are written idle.
module asip_outputs_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic commit_i,
    input logic fault_i,
    input logic write_i,
    input logic host_write_safe_i,
    input logic not_finite_o,
    input logic safe_q
);

  NoCommitOfAFault : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(commit_i && fault_i))
  else $error("a page is shown while a fault stands");

  SafeIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(write_i && host_write_safe_i))
  else $error("a safe value and an output in the same cycle, one of them lost");

  SafeAfterAFault : assert property (@(posedge clk_i) disable iff (!rst_ni)
      fault_i |=> safe_q)
  else $error("outputs of a run are shown after a fault");

  JudgedOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      not_finite_o |-> $past(write_i))
  else $error("an output was judged that nobody wrote");

endmodule

bind asip_outputs asip_outputs_sva u_sva (.*);
