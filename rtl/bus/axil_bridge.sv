// SPDX-License-Identifier: Apache-2.0
// axil_bridge: AXI4-Lite subordinate port (AMBA AXI IHI 0022, issue E, part B) to an Avalon-MM agent.
// Contract: byte address = 4 * word address; bits 1:0 and *prot are ignored. Each channel holds one
// transfer until its response is taken: AW and W in any order, no READY depends on a VALID. Accesses
// reach the agent one at a time; one that it holds waits, and others after it. A write without all
// four strobes is answered SLVERR and changes nothing; every other access is answered OKAY. Cycles
// from the last handshake to the response valid, uncontended: 2 and those of the agent's access.
module axil_bridge #(
    parameter int unsigned AddressWidth = 10  // of words
) (
    input  logic                          clk_i,
    input  logic                          rst_ni,
    // write address, write data, write response
    input  logic [AddressWidth+1:0]       awaddr_i,
    input  logic [2:0]                    awprot_i,
    input  logic                          awvalid_i,
    output logic                          awready_o,
    input  logic [31:0]                   wdata_i,
    input  logic [3:0]                    wstrb_i,
    input  logic                          wvalid_i,
    output logic                          wready_o,
    output logic [1:0]                    bresp_o,
    output logic                          bvalid_o,
    input  logic                          bready_i,
    // read address, read data
    input  logic [AddressWidth+1:0]       araddr_i,
    input  logic [2:0]                    arprot_i,
    input  logic                          arvalid_i,
    output logic                          arready_o,
    output logic [31:0]                   rdata_o,
    output logic [1:0]                    rresp_o,
    output logic                          rvalid_o,
    input  logic                          rready_i,
    // Avalon-MM
    output logic [AddressWidth-1:0]       address_o,
    output logic                          read_o,
    output logic                          write_o,
    output logic [31:0]                   writedata_o,
    input  logic [31:0]                   readdata_i,
    input  logic                          waitrequest_i
);

  localparam logic [1:0] Okay = 2'b00;
  localparam logic [1:0] SlvErr = 2'b10;

  // A channel register is full (*_q) from its handshake to the handshake of the response.
  logic aw_q, w_q, ar_q, full_word_q, bvalid_q, rvalid_q, berror_q;
  logic [AddressWidth-1:0] awaddr_q, araddr_q;
  logic [31:0] wdata_q, rdata_q;
  // Access to the agent in progress.
  logic write_q, read_q;
  logic write_pending, read_pending, idle;

  assign write_pending = aw_q && w_q && !bvalid_q;
  assign read_pending  = ar_q && !rvalid_q;
  assign idle          = !write_q && !read_q;

  // Writes go first; the turn after a write is a read's, as the next write is not there yet.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      aw_q     <= 1'b0;
      w_q      <= 1'b0;
      ar_q     <= 1'b0;
      write_q  <= 1'b0;
      read_q   <= 1'b0;
      bvalid_q <= 1'b0;
      rvalid_q <= 1'b0;
    end else begin
      if (awvalid_i && !aw_q) aw_q <= 1'b1;
      if (wvalid_i && !w_q) w_q <= 1'b1;
      if (arvalid_i && !ar_q) ar_q <= 1'b1;

      if (idle && write_pending && full_word_q) write_q <= 1'b1;
      else if (idle && read_pending) read_q <= 1'b1;
      if (idle && write_pending && !full_word_q) bvalid_q <= 1'b1;

      if (write_q && !waitrequest_i) begin
        write_q  <= 1'b0;
        bvalid_q <= 1'b1;
      end
      if (read_q && !waitrequest_i) begin
        read_q   <= 1'b0;
        rvalid_q <= 1'b1;
      end
      if (bvalid_q && bready_i) begin
        bvalid_q <= 1'b0;
        aw_q     <= 1'b0;
        w_q      <= 1'b0;
      end
      if (rvalid_q && rready_i) begin
        rvalid_q <= 1'b0;
        ar_q     <= 1'b0;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (!aw_q) awaddr_q <= awaddr_i[AddressWidth+1:2];
    if (!ar_q) araddr_q <= araddr_i[AddressWidth+1:2];
    if (!w_q) begin
      wdata_q     <= wdata_i;
      full_word_q <= &wstrb_i;
    end
    if (write_pending) berror_q <= !full_word_q;
    if (read_q && !waitrequest_i) rdata_q <= readdata_i;
  end

  assign awready_o = !aw_q;
  assign wready_o  = !w_q;
  assign arready_o = !ar_q;
  assign bvalid_o  = bvalid_q;
  assign bresp_o   = berror_q ? SlvErr : Okay;
  assign rvalid_o  = rvalid_q;
  assign rresp_o   = Okay;
  assign rdata_o   = rdata_q;

  assign address_o   = write_q ? awaddr_q : araddr_q;
  assign read_o      = read_q;
  assign write_o     = write_q;
  assign writedata_o = wdata_q;

  logic unused;
  assign unused = ^{awaddr_i[1:0], araddr_i[1:0], awprot_i, arprot_i};

endmodule
