// SPDX-License-Identifier: Apache-2.0
// ecat_unit: the processing unit's stream: takes frames nibble by nibble and gives them out changed.
// Contract: a nibble leaves Delay + 1 ticks after it arrives, and as many leave as arrive. Bytes go to the datagram
// processor and come back; the last four are the recomputed check sequence, inverted if the frame was bad. destroy_i
// ends the frame's output at once. While looped_i a frame shorter than 64 bytes (the rest of a destroyed one) loses its
// last Delay nibbles, so it is gone after some rounds. The end of a frame is reported after its last byte: by
// frame_end_o with frame_bad_o, or with frame_good_o if its writes may take effect (right check sequence, whole bytes,
// no RX_ER, not spoilt_i). byte_o with byte_valid_o is the datagram processor's input and result_i its answer, which
// leaves with the fifth tick, 19 clocks after byte_valid_o, and must be valid a clock before.
module ecat_unit (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic tick_i,
    input  ecat_pkg::nibble_t nibble_i,
    output ecat_pkg::nibble_t nibble_o,
    // datagram processor
    output logic       frame_start_o,  // before its first byte
    output logic       byte_valid_o,
    output logic [7:0] byte_o,
    input  logic [7:0] result_i,
    input  logic       destroy_i,
    input  logic       looped_i,
    input  logic       spoilt_i,       // with frame_end_o: the frame's datagrams are
    output logic       frame_end_o,
    output logic       frame_bad_o,
    output logic       frame_good_o,
    // counters
    output logic       received_o,     // a frame has ended
    output logic       bad_o,          // these two of the frame that has ended
    output logic       marked_o,
    output logic       error_o
);

  localparam int unsigned Delay = 8;  // so long that the end is known before the check sequence leaves

  logic [3:0] data_q[0:Delay-1];
  logic [Delay-1:0] valid_q, low_q;  // low_q: lower half of a byte
  logic [7:0] early_q, byte_q;
  logic [1:0] arrive_q;
  logic [2:0] end_q;
  logic strobe_q, start_q, body, odd, ends, bad, marked, error;
  logic end_bad_q, end_pulse_q, check_q, destroyed_q, started_q, fragment;
  logic [7:0] length_q;  // nibbles of the frame, up to those of the shortest
  logic [31:0] sequence_q;
  logic [3:0] upper_q, out_data, check_nibble;
  logic check, in_body_q, out_body;
  ecat_pkg::nibble_t out_q;

  ecat_check u_check (
      .clk_i,
      .rst_ni,
      .tick_i,
      .nibble_i,
      .body_o  (body),
      .odd_o   (odd),
      .end_o   (ends),
      .bad_o   (bad),
      .marked_o(marked),
      .error_o (error)
  );

  assign received_o = tick_i && ends;
  assign bad_o      = bad;
  assign marked_o   = marked;
  assign error_o    = error;

  // In: bytes for the processor, one byte's time after their coming.
  always_ff @(posedge clk_i) begin
    if (tick_i) begin
      for (int i = 0; i < Delay; i++) data_q[i] <= i == 0 ? nibble_i.data : data_q[i-1];
      if (body && odd) early_q <= {nibble_i.data, data_q[0]};
      if (arrive_q[1]) byte_q <= early_q;
      if (ends) end_bad_q <= bad;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      valid_q     <= '0;
      low_q       <= '0;
      arrive_q    <= '0;
      end_q       <= '0;
      strobe_q    <= 1'b0;
      start_q     <= 1'b0;
      started_q   <= 1'b0;
      end_pulse_q <= 1'b0;
    end else begin
      strobe_q    <= tick_i && arrive_q[1];
      end_pulse_q <= tick_i && end_q[2];
      start_q     <= tick_i && body && !started_q;
      if (tick_i) begin
        valid_q   <= {valid_q[Delay-2:0], nibble_i.valid};
        low_q     <= {low_q[Delay-2:0], body && !odd};
        arrive_q  <= {arrive_q[0], body && odd};
        end_q     <= {end_q[1:0], ends};
        started_q <= body;
      end
    end
  end

  assign frame_start_o = start_q;
  assign byte_valid_o  = strobe_q;
  assign byte_o        = byte_q;
  assign frame_end_o   = end_pulse_q;
  assign frame_bad_o   = end_bad_q;
  assign frame_good_o  = end_pulse_q && !end_bad_q && !spoilt_i;

  assign fragment = looped_i && valid_q[0] && !nibble_i.valid && !length_q[7];
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) length_q <= '0;
    else if (tick_i) length_q <= !body ? '0 : length_q[7] ? length_q : length_q + 1'b1;
  end

  // Out: at the lower half of a byte, that no more comes in says that this is the check sequence.
  assign check        = low_q[Delay-1] ? !nibble_i.valid : check_q;
  assign check_nibble = sequence_q[3:0] ^ {4{!bad}};
  assign out_body     = valid_q[Delay-1] && (low_q[Delay-1] || in_body_q);
  always_comb begin
    out_data = data_q[Delay-1];
    if (out_body && check) out_data = check_nibble;
    else if (low_q[Delay-1]) out_data = result_i[3:0];
    else if (out_body) out_data = upper_q;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      out_q       <= '0;
      in_body_q   <= 1'b0;
      check_q     <= 1'b0;
      destroyed_q <= 1'b0;
      sequence_q  <= '1;
      upper_q     <= '0;
    end else begin
      if (destroy_i || (tick_i && fragment)) destroyed_q <= 1'b1;
      else if (tick_i && valid_q == '0) destroyed_q <= 1'b0;
      if (tick_i) begin
        out_q     <= {valid_q[Delay-1] && !destroyed_q && !destroy_i && !fragment, 1'b0, out_data};
        in_body_q <= out_body;
        check_q   <= out_body && check;
        if (low_q[Delay-1]) upper_q <= result_i[7:4];
        if (!out_body) sequence_q <= '1;
        else if (check) sequence_q <= {4'd0, sequence_q[31:4]};
        else sequence_q <= ecat_pkg::check_sequence(sequence_q, out_data);
      end
    end
  end

  assign nibble_o = out_q;

endmodule
