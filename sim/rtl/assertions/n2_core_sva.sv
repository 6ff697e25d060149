// SPDX-License-Identifier: Apache-2.0
// n2_core_sva: the Avalon-MM data master, and multicycle custom instructions: one start for each.
module n2_core_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        ci_multi_clk_en_o,
    input logic        ci_multi_start_o,
    input logic        ci_multi_done_i,
    input logic [31:0] ci_multi_dataa_o,
    input logic [31:0] ci_multi_datab_o,
    input logic [7:0]  ci_multi_n_o,
    input logic        ci_a_q
);

  StartInStageA : assert property (@(posedge clk_i) disable iff (!rst_ni) ci_multi_start_o |-> ci_a_q)
  else $error("a custom instruction was started that is not there");

  OperandsHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      ci_a_q && !ci_multi_done_i |=> ci_a_q && $stable(ci_multi_dataa_o) && $stable(ci_multi_datab_o) &&
      $stable(ci_multi_n_o))
  else $error("a custom instruction was dropped or changed before it was done");

  OneStart : assert property (@(posedge clk_i) disable iff (!rst_ni)
      ci_multi_start_o && ci_multi_clk_en_o && !ci_multi_done_i |=> !ci_multi_start_o)
  else $error("a custom instruction was started twice");

endmodule

bind n2_core n2_core_sva u_sva (.*);

bind n2_core avalon_rules #(
    .AddressWidth(36)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    ({avm_byteenable_o, avm_address_o}),
    .read       (avm_read_o),
    .write      (avm_write_o),
    .writedata  (avm_writedata_o),
    .waitrequest(avm_waitrequest_i)
);
