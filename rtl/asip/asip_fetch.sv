// SPDX-License-Identifier: Apache-2.0
// asip_fetch: program memory and the stages before issue (F1 memory read, F2 word register, P and Q
// decoded bundle whose hazards are looked up, D bundle ready to issue).
// Contract: after redirect_i the bundle at redirect_pc_i is in stage D six cycles later; then one bundle
// per cycle. All stages move together, in the cycles in which advance_i is high: the stream of bundles
// has no gaps, so none could be closed. pc_bad_d_o marks an address outside program memory.
// Each 32-bit lane of a bundle is a memory of its own, written by the host between runs; what was read
// before that, or at the same time, is flushed. The word register keeps the memory's clock-to-output time
// out of the decoder's path.
module asip_fetch #(
    parameter int unsigned Bundles     = 1024,
    parameter int unsigned BundleWidth = 128,
    parameter int unsigned DecodedWidth = 256,
    parameter int unsigned Resilience  = 0   // 1: parity of program memory
) (
    input  logic                       clk_i,
    input  logic                       rst_ni,
    // from control and branches
    input  logic                       redirect_i,
    input  logic [15:0]                redirect_pc_i,
    // from issue
    input  logic                       advance_i,
    // from loops: the bundle after the one at pc_q is this one, not the next
    input  logic                       turn_i,
    input  logic [15:0]                turn_pc_i,
    output logic                       valid_f2_o,
    output logic [15:0]                pc_f2_o,
    output logic                       valid_p_o,
    // to and from the decoder, between F2 and P; illegal bundles are found between P and Q
    output logic [BundleWidth-1:0]     bundle_f2_o,
    input  logic [DecodedWidth-1:0]    decoded_f2_i,
    output logic [DecodedWidth-1:0]    decoded_p_o,
    input  logic                       illegal_p_i,
    // to issue
    output logic                       valid_q_o,
    output logic                       bad_q_o,      // never issues
    output logic [DecodedWidth-1:0]    decoded_q_o,
    output logic                       valid_d_o,
    output logic                       bad_d_o,
    output logic                       pc_bad_d_o,   // of the bad ones
    output logic [15:0]                pc_d_o,
    output logic [15:0]                pc_p_o,       // to a debug block
    output logic [15:0]                pc_q_o,
    output logic [DecodedWidth-1:0]    decoded_d_o,
    output logic                       bad_word_p_o, // a word of the bundle in P is wrong
    // from the host
    input  logic                       write_i,
    input  logic [$clog2(Bundles)-1:0] write_bundle_i,
    input  logic [1:0]                 write_lane_i,
    input  logic [31:0]                write_data_i
);

  localparam int unsigned Lanes = (BundleWidth + 31) / 32;
  localparam int unsigned AddressWidth = $clog2(Bundles);
  localparam int unsigned WordWidth = Resilience != 0 ? 33 : 32;

  logic [15:0] pc_q, pc_f1_q, pc_f2_q, pc_p_q, pc_q_q, pc_d_q;
  logic valid_f1_q, valid_f2_q, valid_p_q, valid_q_q, valid_d_q;
  logic pc_bad_p, pc_bad_q_q, pc_bad_d_q, bad_q_q, bad_d_q;
  logic [32*Lanes-1:0] lanes_f2_q;
  logic [DecodedWidth-1:0] decoded_p_q, decoded_q_q, decoded_d_q;
  logic [Lanes-1:0] bad_word_f2;
  logic bad_word_p;

  assign pc_bad_p = |pc_p_q[15:AddressWidth];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_f1_q <= 1'b0;
      valid_f2_q <= 1'b0;
      valid_p_q  <= 1'b0;
      valid_q_q  <= 1'b0;
      valid_d_q  <= 1'b0;
    end else if (redirect_i) begin
      valid_f1_q <= 1'b0;
      valid_f2_q <= 1'b0;
      valid_p_q  <= 1'b0;
      valid_q_q  <= 1'b0;
      valid_d_q  <= 1'b0;
    end else if (advance_i) begin
      valid_f1_q <= 1'b1;
      valid_f2_q <= valid_f1_q;
      valid_p_q  <= valid_f2_q;
      valid_q_q  <= valid_p_q;
      valid_d_q  <= valid_q_q;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) pc_q <= 16'd0;
    else if (redirect_i) pc_q <= redirect_pc_i;
    else if (advance_i) pc_q <= turn_i ? turn_pc_i : pc_q + 16'd1;
  end

  always_ff @(posedge clk_i) begin
    if (advance_i) begin
      pc_f1_q     <= pc_q;
      pc_f2_q     <= pc_f1_q;
      pc_p_q      <= pc_f2_q;
      pc_q_q      <= pc_p_q;
      pc_d_q      <= pc_q_q;
      decoded_p_q <= decoded_f2_i;
      decoded_q_q <= decoded_p_q;
      decoded_d_q <= decoded_q_q;
      pc_bad_q_q  <= pc_bad_p;
      pc_bad_d_q  <= pc_bad_q_q;
      bad_q_q     <= illegal_p_i || pc_bad_p || bad_word_p;
      bad_d_q     <= bad_q_q;
    end
  end

  genvar l;
  generate
    for (l = 0; l < Lanes; l++) begin : gen_lane
      logic [WordWidth-1:0] word_f1, word_f2_q;

      ram_block #(
          .Words(Bundles),
          .Width(WordWidth)
      ) u_ram (
          .clk_i,
          .write_i        (write_i && write_lane_i == l[1:0]),
          .write_address_i(write_bundle_i),
          .write_data_i   (WordWidth'({^write_data_i, write_data_i})),
          .read_i         (advance_i),
          .read_address_i (pc_q[AddressWidth-1:0]),
          .read_data_o    (word_f1)
      );

      always_ff @(posedge clk_i) if (advance_i) word_f2_q <= word_f1;

      assign lanes_f2_q[32*l+:32] = word_f2_q[31:0];
      assign bad_word_f2[l]       = Resilience != 0 && (^word_f2_q);
    end

    if (Resilience != 0) begin : gen_parity
      logic bad_word_p_q;
      always_ff @(posedge clk_i) if (advance_i) bad_word_p_q <= |bad_word_f2;
      assign bad_word_p = bad_word_p_q;
    end else begin : gen_no_parity
      assign bad_word_p = |bad_word_f2;
    end
  endgenerate
  assign bad_word_p_o = bad_word_p && valid_p_q;

  assign valid_f2_o  = valid_f2_q;
  assign pc_f2_o     = pc_f2_q;
  assign valid_p_o   = valid_p_q;
  assign bundle_f2_o = lanes_f2_q[BundleWidth-1:0];
  assign decoded_p_o = decoded_p_q;
  assign valid_q_o   = valid_q_q;
  assign bad_q_o     = bad_q_q;
  assign decoded_q_o = decoded_q_q;
  assign valid_d_o   = valid_d_q;
  assign bad_d_o     = bad_d_q;
  assign pc_bad_d_o  = pc_bad_d_q;
  assign pc_d_o      = pc_d_q;
  assign pc_p_o      = pc_p_q;
  assign pc_q_o      = pc_q_q;
  assign decoded_d_o = decoded_d_q;

  generate
    if (BundleWidth % 32 != 0) begin : gen_unused
      logic unused_lane_bits;
      assign unused_lane_bits = ^lanes_f2_q[32*Lanes-1:BundleWidth];
    end
  endgenerate

endmodule
