// SPDX-License-Identifier: Apache-2.0
// ecat_application: the application's Avalon-MM port: words of 32 bits, byte by byte into the controller.
// Contract: an access waits until all of its enabled bytes are done, the lowest first; readdata is valid in the
// clock in which waitrequest is low. Addresses from 0x8000 on are the SII image.
module ecat_application (
    input  logic        clk_i,
    input  logic        rst_ni,
    // Avalon-MM
    input  logic [13:0] avs_address_i,     // words
    input  logic        avs_read_i,
    input  logic        avs_write_i,
    input  logic [3:0]  avs_byteenable_i,
    input  logic [31:0] avs_writedata_i,
    output logic [31:0] avs_readdata_o,
    output logic        avs_waitrequest_o,
    // bytes of the controller
    output logic        valid_o,
    output logic        write_o,
    output logic [15:0] address_o,
    output logic [7:0]  data_o,
    input  logic        ready_i,
    input  logic        done_i,
    input  logic [7:0]  data_i,
    // bytes of the SII image
    output logic        sii_read_o,
    output logic        sii_write_o,
    input  logic [7:0]  sii_data_i,        // a clock behind sii_read_o
    input  logic        sii_ready_i
);

  localparam logic [1:0] StByte = 2'd0;    // the next enabled byte, if any
  localparam logic [1:0] StWait = 2'd1;    // for its answer
  localparam logic [1:0] StSii = 2'd2;
  localparam logic [1:0] StDone = 2'd3;

  logic [1:0]  state_q;
  logic [3:0]  done_q;       // bytes that are through
  logic [3:0]  open;
  logic [1:0]  byte_now;
  logic [31:0] data_q;
  logic        asked, is_sii, sii_taken;

  assign asked  = avs_read_i || avs_write_i;
  assign is_sii = avs_address_i[13];
  assign open   = avs_byteenable_i & ~done_q;
  always_comb begin
    byte_now = 2'd3;
    if (open[0]) byte_now = 2'd0;
    else if (open[1]) byte_now = 2'd1;
    else if (open[2]) byte_now = 2'd2;
  end

  assign valid_o     = state_q == StByte && asked && open != '0 && !is_sii;
  assign sii_taken   = state_q == StByte && asked && open != '0 && is_sii && sii_ready_i;
  assign sii_read_o  = sii_taken && avs_read_i;
  assign sii_write_o = sii_taken && avs_write_i;
  assign write_o     = avs_write_i;
  assign address_o   = {avs_address_i, byte_now};
  assign data_o      = avs_writedata_i[8*byte_now+:8];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= StByte;
      done_q  <= '0;
      data_q  <= '0;
    end else begin
      case (state_q)
        StByte: if (asked) begin
          if (open == '0) state_q <= StDone;
          else if (valid_o && ready_i) state_q <= StWait;
          else if (sii_taken) state_q <= StSii;
        end
        StWait: if (done_i) begin
          data_q[8*byte_now+:8] <= data_i;
          done_q[byte_now]      <= 1'b1;
          state_q               <= StByte;
        end
        StSii: begin
          data_q[8*byte_now+:8] <= sii_data_i;
          done_q[byte_now]      <= 1'b1;
          state_q               <= StByte;
        end
        default: begin
          state_q <= StByte;
          done_q  <= '0;
        end
      endcase
    end
  end

  assign avs_readdata_o    = data_q;
  assign avs_waitrequest_o = state_q != StDone;

endmodule
