// SPDX-License-Identifier: Apache-2.0
// asip_lockstep_sva: a mismatch stays until it is cleared, and holds nobody up.
module asip_lockstep_sva (
    input logic        clk_i,
    input logic        rst_ni,
    input logic        write_i,
    input logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input logic [31:0] writedata_i,
    input logic        waitrequest_o,
    input logic        irq_o,
    input logic        mismatch_o,
    input logic [1:0]  core_rst_nq
);

  MismatchStays : assert property (@(posedge clk_i) disable iff (!rst_ni)
      mismatch_o && !(write_i && address_i == asip_regmap_pkg::ADDRESS_WIDTH'(asip_regmap_pkg::REG_CONTROL) &&
                      writedata_i[asip_regmap_pkg::CONTROL_CLEAR_LSB]) |=> mismatch_o)
  else $error("a mismatch fell without a clear");

  MismatchIsTold : assert property (@(posedge clk_i) disable iff (!rst_ni)
      mismatch_o |-> irq_o && !waitrequest_o)
  else $error("the host is not told of a mismatch, or waits");

  CoresHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      mismatch_o |=> core_rst_nq == '0)
  else $error("a core runs behind a mismatch");

endmodule

bind asip_lockstep asip_lockstep_sva u_sva (.*);
