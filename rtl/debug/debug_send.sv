// SPDX-License-Identifier: Apache-2.0
// debug_send: packets to the bytes of a line (COBS, CRC), one built while another is sent.
// Contract: while ready_o, put_i adds a byte; end_i, in a clock without put_i, ends the packet, and
// ready_o is low until its CRC is in and a half of the buffer is free. At most 252 bytes before end_i.
// A zero of the packet leaves its place in the buffer to the distance from it to the next one, written when
// that one comes: COBS takes one write a byte.
module debug_send (
    input  logic       clk_i,
    input  logic       rst_ni,
    // packet
    output logic       ready_o,
    input  logic       put_i,
    input  logic [7:0] data_i,
    input  logic       end_i,
    // to the line
    output logic       send_o,
    output logic [7:0] data_o,
    input  logic       ready_i
);

  typedef enum logic [2:0] {
    StWait,   // for a free half
    StOpen,   // bytes come
    StHigh,   // CRC, high byte
    StLow,    // CRC, low byte
    StMark,   // the last distance
    StClose   // the zero after the frame
  } state_e;

  state_e state_q;
  logic half_q, out_half_q;  // built, sent
  logic [1:0] full_q;
  logic [7:0] at_q, mark_q, out_q;
  logic [15:0] crc_q;
  logic write, add, sent;
  logic [7:0] place, word, add_data;
  logic [7:0] read_data;

  assign ready_o = state_q == StOpen;
  assign sent    = send_o && ready_i && read_data == 8'd0;

  always_comb begin
    add      = 1'b0;
    add_data = data_i;
    case (state_q)
      StOpen: add = put_i;
      StHigh: begin
        add      = 1'b1;
        add_data = crc_q[15:8];
      end
      StLow: begin
        add      = 1'b1;
        add_data = crc_q[7:0];
      end
      default: add = 1'b0;
    endcase
    write = add || state_q == StMark || state_q == StClose;
    place = at_q;
    word  = add_data;
    if ((add && add_data == 8'd0) || state_q == StMark) begin
      place = mark_q;
      word  = at_q - mark_q;
    end else if (state_q == StClose) begin
      word = 8'd0;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q    <= StWait;
      half_q     <= 1'b0;
      out_half_q <= 1'b0;
      full_q     <= '0;
      at_q       <= '0;
      mark_q     <= '0;
      out_q      <= '0;
      crc_q      <= '0;
    end else begin
      case (state_q)
        StWait: begin
          at_q   <= 8'd1;
          mark_q <= 8'd0;
          crc_q  <= debug_pkg::CRC_START;
          if (!full_q[half_q]) state_q <= StOpen;
        end
        StOpen: begin
          if (put_i) crc_q <= debug_pkg::crc(crc_q, data_i);
          if (end_i) state_q <= StHigh;
        end
        StHigh: state_q <= StLow;
        StLow: state_q <= StMark;
        StMark: state_q <= StClose;
        default: begin
          full_q[half_q] <= 1'b1;
          half_q         <= !half_q;
          state_q        <= StWait;
        end
      endcase
      if (add) begin
        at_q <= at_q + 8'd1;
        if (add_data == 8'd0) mark_q <= at_q;
      end
      if (send_o && ready_i) out_q <= out_q + 8'd1;
      if (sent) begin
        full_q[out_half_q] <= 1'b0;
        out_half_q         <= !out_half_q;
        out_q              <= '0;
      end
    end
  end

  ram_lut #(
      .Words(512),
      .Width(8)
  ) u_ram (
      .clk_i,
      .write_i        (write),
      .write_address_i({half_q, place}),
      .write_data_i   (word),
      .read_address_i ({out_half_q, out_q}),
      .read_data_o    (read_data)
  );

  assign send_o    = full_q[out_half_q];
  assign data_o    = read_data;

endmodule
