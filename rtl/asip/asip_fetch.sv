// SPDX-License-Identifier: Apache-2.0
// asip_fetch: program memory and the fetch stages (F1 memory read, F2 word register, P decoded bundle
// whose hazards are looked up, D bundle ready to issue).
// Contract: after redirect_i the bundle at redirect_pc_i is in stage D five cycles later; then one
// bundle per cycle as long as advance_i is high. pc_bad_o marks an address outside program memory.
// Each 32-bit lane of a bundle is a memory of its own, written by the host. The word register keeps
// the memory's clock-to-output time out of the decoder's path.
module asip_fetch #(
    parameter int unsigned Bundles     = 1024,
    parameter int unsigned BundleWidth = 128,
    parameter int unsigned DecodedWidth = 256
) (
    input  logic                       clk_i,
    input  logic                       rst_ni,
    // from control and branches
    input  logic                       redirect_i,
    input  logic [15:0]                redirect_pc_i,
    // from issue
    input  logic                       advance_i,
    // to and from the decoder, between F2 and P
    output logic [BundleWidth-1:0]     bundle_f2_o,
    input  logic [DecodedWidth-1:0]    decoded_f2_i,
    // to issue
    output logic [DecodedWidth-1:0]    decoded_p_o,
    output logic                       take_d_o,
    output logic                       valid_o,
    output logic [15:0]                pc_o,
    output logic                       pc_bad_o,
    output logic [DecodedWidth-1:0]    decoded_o,
    // from the host
    input  logic                       write_i,
    input  logic [$clog2(Bundles)-1:0] write_bundle_i,
    input  logic [1:0]                 write_lane_i,
    input  logic [31:0]                write_data_i
);

  localparam int unsigned Lanes = (BundleWidth + 31) / 32;
  localparam int unsigned AddressWidth = $clog2(Bundles);

  logic [15:0]             pc_q, pc_f1_q, pc_f2_q, pc_p_q, pc_d_q;
  logic                    valid_f1_q, valid_f2_q, valid_p_q, valid_d_q;
  logic                    take_f1, take_f2, take_p, take_d;
  logic [32*Lanes-1:0]     lanes_f2_q;
  logic [DecodedWidth-1:0] decoded_p_q, decoded_d_q;

  assign take_d  = !valid_d_q || advance_i;
  assign take_p  = !valid_p_q || take_d;
  assign take_f2 = !valid_f2_q || take_p;
  assign take_f1 = !valid_f1_q || take_f2;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      pc_q       <= 16'd0;
      valid_f1_q <= 1'b0;
      valid_f2_q <= 1'b0;
      valid_p_q  <= 1'b0;
      valid_d_q  <= 1'b0;
    end else if (redirect_i) begin
      pc_q       <= redirect_pc_i;
      valid_f1_q <= 1'b0;
      valid_f2_q <= 1'b0;
      valid_p_q  <= 1'b0;
      valid_d_q  <= 1'b0;
    end else begin
      if (take_f1) begin
        pc_q       <= pc_q + 16'd1;
        valid_f1_q <= 1'b1;
      end
      if (take_f2) valid_f2_q <= valid_f1_q;
      if (take_p) valid_p_q <= valid_f2_q;
      if (take_d) valid_d_q <= valid_p_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (take_f1) pc_f1_q <= pc_q;
    if (take_f2) pc_f2_q <= pc_f1_q;
    if (take_p) begin
      pc_p_q      <= pc_f2_q;
      decoded_p_q <= decoded_f2_i;
    end
    if (take_d) begin
      pc_d_q      <= pc_p_q;
      decoded_d_q <= decoded_p_q;
    end
  end

  for (genvar l = 0; l < Lanes; l++) begin : gen_lane
    logic [31:0] memory[0:Bundles-1];
    logic [31:0] read_f1_q, word_f2_q;

    always_ff @(posedge clk_i) begin
      if (write_i && write_lane_i == l[1:0]) memory[write_bundle_i] <= write_data_i;
      if (take_f1) read_f1_q <= memory[pc_q[AddressWidth-1:0]];
      if (take_f2) word_f2_q <= read_f1_q;
    end

    assign lanes_f2_q[32*l+:32] = word_f2_q;
  end

  assign bundle_f2_o = lanes_f2_q[BundleWidth-1:0];
  assign decoded_p_o = decoded_p_q;
  assign take_d_o    = take_d;
  assign valid_o     = valid_d_q;
  assign pc_o        = pc_d_q;
  assign pc_bad_o    = |pc_d_q[15:AddressWidth];
  assign decoded_o   = decoded_d_q;

  if (BundleWidth % 32 != 0) begin : gen_unused
    logic unused_lane_bits;
    assign unused_lane_bits = ^lanes_f2_q[32*Lanes-1:BundleWidth];
  end

endmodule
