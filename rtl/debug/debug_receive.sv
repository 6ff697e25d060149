// SPDX-License-Identifier: Apache-2.0
// debug_receive: request packets out of the bytes of a line (COBS, CRC).
// Contract: request_o with length_o stays until done_i; data_o is the byte of it at index_i, a clock
// after. Bytes that come meanwhile are lost with their frame. dropped_o is a pulse for each frame that is
// not handed on: bad CRC, too short or long, not COBS, a broken byte, or one that found a request waiting.
module debug_receive (
    input  logic       clk_i,
    input  logic       rst_ni,
    // from the line
    input  logic       received_i,
    input  logic       broken_i,
    input  logic [7:0] data_i,
    // request
    output logic       request_o,
    output logic [5:0] length_o,   // with its CRC
    input  logic [5:0] index_i,
    output logic [7:0] data_o,
    input  logic       done_i,
    output logic       dropped_o
);

  localparam int unsigned Largest = 4 + 2 + 4 * debug_pkg::WRITE_WORDS;

  logic request_q, bad_q, any_q, gap_q, dropped_q;
  logic [7:0] left_q;  // bytes until the next code; 0: this one is a code
  logic [5:0] length_q;
  logic [15:0] crc_q;
  logic put, code, ended, whole;
  logic [7:0] data;
  logic [7:0] memory[0:63];
  logic [7:0] data_q;

  // A code represents the zero after the bytes before it, except for the first one and that after 254.
  assign code = left_q == 8'd0;
  assign put  = received_i && !ended && (!code || gap_q);
  assign data = code ? 8'd0 : data_i;

  assign ended = received_i && data_i == 8'd0;
  assign whole = any_q && !bad_q && code && length_q >= 6'd4 && crc_q == 16'd0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      request_q <= 1'b0;
      bad_q     <= 1'b0;
      any_q     <= 1'b0;
      gap_q     <= 1'b0;
      dropped_q <= 1'b0;
      left_q    <= '0;
      length_q  <= '0;
      crc_q     <= debug_pkg::CRC_START;
    end else begin
      dropped_q <= 1'b0;
      if (done_i) request_q <= 1'b0;
      if (broken_i) bad_q <= 1'b1;
      if (received_i && !ended) begin
        any_q <= 1'b1;
        if (request_q) bad_q <= 1'b1;
        left_q <= code ? data_i - 8'd1 : left_q - 8'd1;
        if (code) gap_q <= data_i != 8'hff;
      end
      if (put && !request_q) begin
        if (length_q == 6'(Largest)) bad_q <= 1'b1;
        else length_q <= length_q + 6'd1;
        crc_q <= debug_pkg::crc(crc_q, data);
      end
      if (ended) begin
        request_q <= request_q || whole;
        dropped_q <= any_q && (request_q || !whole);
        any_q     <= 1'b0;
        bad_q     <= 1'b0;
        gap_q     <= 1'b0;
        left_q    <= '0;
      end
      // The length holds as long as the request.
      if (done_i || (ended && !request_q && !whole)) begin
        length_q <= '0;
        crc_q    <= debug_pkg::CRC_START;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (put && !request_q && length_q < 6'(Largest)) memory[length_q] <= data;
    data_q <= memory[index_i];
  end

  assign request_o = request_q;
  assign length_o  = length_q;
  assign data_o    = data_q;
  assign dropped_o = dropped_q;

endmodule
