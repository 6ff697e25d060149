// SPDX-License-Identifier: Apache-2.0
// asip_stream: constant memory of a multiply-add pipe, read word after word, with one of each further lane.
// Contract: word_r1_o are the next words of the bundle that was in stage D one cycle before, by lane. The bundle that
// issues steps the pointer if it takes a word; a seek in it sets the pointer for the bundle after it,
// whether or not the bundle itself takes a word. A run begins at word 0. The first word follows the
// last one. The host writes the memory while no bundle issues; one that issues three cycles after write_i gets the word.
// The memory is read while a bundle is in Q, and word_r1_o is held while the bundle waits in D. The blocks, which fill
// most of a device, have their addresses from registers, and a whole cycle to a register of R1. A second pointer is
// therefore that of the bundle in Q; a flush sets it to the pointer of D. After a write the word of D is read again.
module asip_stream #(
    parameter int unsigned Words = 1024,
    parameter int unsigned Lanes = 0      // besides the first
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // from control
    input  logic        clear_i,          // fetch begins at an entry: no bundle issues in this cycle
    input  logic        flush_i,          // the bundles in Q and D are void
    // from stage Q
    input  logic        advance_i,        // its bundle goes to D
    input  logic        take_q_i,
    input  logic        seek_q_i,
    input  logic [14:0] seek_address_q_i,
    // from stage D: of the bundle that issues
    input  logic        take_i,
    input  logic        seek_i,
    input  logic [14:0] seek_address_i,
    // to the operand stage, R1
    output logic [Lanes:0][31:0] word_r1_o,
    // from the host, while no bundle issues
    input  logic        write_i,
    input  logic [1:0]  write_lane_i,
    input  logic [14:0] write_address_i,
    input  logic [31:0] write_data_i
);

  localparam int unsigned AddressWidth = $clog2(Words);

  logic [AddressWidth-1:0] pointer_q;  // of the bundle in D
  logic [AddressWidth-1:0] ahead, ahead_q;  // of the bundle in Q
  logic [AddressWidth-1:0] read_q;  // ahead_q, or once after a write pointer_q
  logic [AddressWidth-1:0] address_q;
  logic [Lanes:0][31:0] word_d, word_q, held_q;
  logic [31:0] data_q;
  logic [Lanes:0] write_q;  // by lane
  logic fits, again_q;
  logic fresh_d_q, fresh_r1_q;  // word_d and word_q are those of a bundle that came to D, or of a read after a write

  // A write beyond the memory is lost.
  assign fits = 32'(write_address_i) < Words;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) pointer_q <= '0;
    else if (clear_i) pointer_q <= '0;
    else if (seek_i) pointer_q <= seek_address_i[AddressWidth-1:0];
    else if (take_i) pointer_q <= pointer_q + 1'b1;
  end

  always_comb begin
    ahead = ahead_q;
    if (clear_i) ahead = '0;
    else if (flush_i) ahead = pointer_q;
    else if (advance_i && seek_q_i) ahead = seek_address_q_i[AddressWidth-1:0];
    else if (advance_i && take_q_i) ahead = ahead_q + 1'b1;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ahead_q    <= '0;
      read_q     <= '0;
      again_q    <= 1'b0;
      fresh_d_q  <= 1'b0;
      fresh_r1_q <= 1'b0;
    end else begin
      ahead_q    <= ahead;
      read_q     <= (|write_q) ? pointer_q : ahead;
      again_q    <= |write_q;
      fresh_d_q  <= advance_i || again_q;
      fresh_r1_q <= fresh_d_q;
    end
  end

  // The memories of many lanes lie across the device, far from the host's port.
  always_ff @(posedge clk_i) begin
    address_q <= write_address_i[AddressWidth-1:0];
    data_q    <= write_data_i;
  end

  always_ff @(posedge clk_i) begin
    word_q <= word_d;
    held_q <= word_r1_o;
  end

  assign word_r1_o = fresh_r1_q ? word_q : held_q;

  genvar l;
  generate
    for (l = 0; l <= Lanes; l++) begin : gen_lane
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) write_q[l] <= 1'b0;
        else write_q[l] <= write_i && fits && write_lane_i == l[1:0];
      end

      ram_block #(
          .Words(Words),
          .Width(32)
      ) u_ram (
          .clk_i,
          .write_i        (write_q[l]),
          .write_address_i(address_q),
          .write_data_i   (data_q),
          .read_i         (1'b1),
          .read_address_i (read_q),
          .read_data_o    (word_d[l])
      );
    end

    if (AddressWidth < 15) begin : gen_unused
      logic unused_address;
      assign unused_address = ^{seek_address_i[14:AddressWidth], seek_address_q_i[14:AddressWidth]};
    end
  endgenerate

endmodule
