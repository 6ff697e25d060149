// SPDX-License-Identifier: Apache-2.0
// axil_bridge_sva: AXI4-Lite (AMBA AXI IHI 0022, issue E, A3.2): VALID holds, with its payload, until READY;
// a response follows its request, one request of a kind at a time, so responses come in order.
module axil_bridge_sva #(
    parameter int unsigned AddressWidth = 1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [AddressWidth+1:0] awaddr_i,
    input logic awvalid_i,
    input logic awready_o,
    input logic [31:0] wdata_i,
    input logic [3:0] wstrb_i,
    input logic wvalid_i,
    input logic wready_o,
    input logic [1:0] bresp_o,
    input logic bvalid_o,
    input logic bready_i,
    input logic [AddressWidth+1:0] araddr_i,
    input logic arvalid_i,
    input logic arready_o,
    input logic [31:0] rdata_o,
    input logic [1:0] rresp_o,
    input logic rvalid_o,
    input logic rready_i,
    input logic read_o,
    input logic write_o
);

  // Requests taken and not yet answered.
  logic addresses_q, words_q, reads_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      addresses_q <= 1'b0;
      words_q     <= 1'b0;
      reads_q     <= 1'b0;
    end else begin
      addresses_q <= (awvalid_i && awready_o) || (addresses_q && !(bvalid_o && bready_i));
      words_q     <= (wvalid_i && wready_o) || (words_q && !(bvalid_o && bready_i));
      reads_q     <= (arvalid_i && arready_o) || (reads_q && !(rvalid_o && rready_i));
    end
  end

  WriteAddressHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      awvalid_i && !awready_o |=> awvalid_i && $stable(awaddr_i))
  else $error("AWVALID or its address fell before AWREADY");

  WriteDataHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      wvalid_i && !wready_o |=> wvalid_i && $stable(wdata_i) && $stable(wstrb_i))
  else $error("WVALID or its data fell before WREADY");

  ReadAddressHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      arvalid_i && !arready_o |=> arvalid_i && $stable(araddr_i))
  else $error("ARVALID or its address fell before ARREADY");

  WriteResponseHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      bvalid_o && !bready_i |=> bvalid_o && $stable(bresp_o))
  else $error("BVALID or its response fell before BREADY");

  ReadDataHeld : assert property (@(posedge clk_i) disable iff (!rst_ni)
      rvalid_o && !rready_i |=> rvalid_o && $stable(rdata_o) && $stable(rresp_o))
  else $error("RVALID or its data fell before RREADY");

  OneWriteAtATime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      awvalid_i && awready_o |-> !addresses_q)
  else $error("a second write was taken before the response of the first");

  OneWordAtATime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      wvalid_i && wready_o |-> !words_q)
  else $error("a second word was taken before the response of the first");

  OneReadAtATime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      arvalid_i && arready_o |-> !reads_q)
  else $error("a second read was taken before the data of the first");

  WriteResponseOfAWrite : assert property (@(posedge clk_i) disable iff (!rst_ni)
      bvalid_o |-> addresses_q && words_q)
  else $error("a write response without a whole write");

  ReadDataOfARead : assert property (@(posedge clk_i) disable iff (!rst_ni)
      rvalid_o |-> reads_q)
  else $error("read data without a read");

  AccessOfARequest : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (!write_o || (addresses_q && words_q)) && (!read_o || reads_q))
  else $error("an access to the agent that nobody asked for");

endmodule

bind axil_bridge axil_bridge_sva #(
    .AddressWidth(AddressWidth)
) u_sva (.*);

bind axil_bridge avalon_rules #(
    .AddressWidth(AddressWidth)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_o),
    .read       (read_o),
    .write      (write_o),
    .writedata  (writedata_o),
    .waitrequest(waitrequest_i)
);
