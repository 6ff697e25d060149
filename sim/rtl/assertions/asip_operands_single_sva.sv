// SPDX-License-Identifier: Apache-2.0
// asip_operands_single_sva: the word that the host writes to C or K comes as C's result.
module asip_operands_single_sva (
    input logic        clk_i,
    input logic        host_write_ck,
    input logic [31:0] word_c,
    input logic [31:0] host_data_i
);

  HostWordIsResultOfC : assert property (@(posedge clk_i)
      host_write_ck |-> word_c == host_data_i)
  else $error("the host writes another word than its own");

endmodule

bind asip_operands_single asip_operands_single_sva u_sva (
    .clk_i,
    .host_write_ck(host_write[1]),
    .word_c       (write_data_i[2]),
    .host_data_i
);
