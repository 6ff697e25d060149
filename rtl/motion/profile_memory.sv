// SPDX-License-Identifier: Apache-2.0
// profile_memory: rings of phase records, one an axis, and their delivery to the axes.
// The host writes records and then moves the heads; a few clocks after every tick the axes that want a
// record get it, word by word, one after another, so all that were released together start
// at the same tick. Contract: a round takes Axes*(Words+2) clocks after tick_i at most, which must be
// fewer than between ticks; heads are looked at in the clock after tick_i. A full ring is the
// host's to avoid (head - tail <= Records).
module profile_memory #(
    parameter int unsigned Axes = 5  // 1..8
) (
    input  logic              clk_i,
    input  logic              rst_ni,
    input  logic              tick_i,
    input  logic [Axes-1:0]   abort_i,    // drop what waits for the axis
    // host: word address {axis, record, word}, and heads, 4 bits an axis
    input  logic              write_i,
    input  logic [8:0]        address_i,
    input  logic [31:0]       data_i,
    input  logic              head_write_i,
    input  logic [4*Axes-1:0] head_i,
    output logic [4*Axes-1:0] head_o,
    output logic [4*Axes-1:0] tail_o,
    output logic [Axes-1:0]   waiting_o,  // records are there or on their way
    // axes
    input  logic [Axes-1:0]   request_i,
    output logic [Axes-1:0]   load_o,
    output logic [2:0]        load_word_o,
    output logic [31:0]       load_data_o
);

  localparam logic [2:0] LAST_WORD = 3'd7;
  localparam logic [2:0] LAST_AXIS = 3'(Axes - 1);

  logic [31:0] memory [0:511];
  logic [31:0] read_q;
  logic [4*Axes-1:0] head_q, tail_q;
  logic [Axes-1:0] serve_q;            // axes that get a record in this round
  logic [Axes-1:0] waiting;
  logic [2:0] axis_q, word_q;
  logic round_q, sample_q, served;
  logic [Axes-1:0] loading_q;
  logic [2:0] loading_word_q;
  logic [2:0] record;

  always_comb begin
    record = 3'd0;
    served = 1'b0;
    for (int unsigned i = 0; i < Axes; i++) begin
      waiting[i] = head_q[4*i+:4] != tail_q[4*i+:4];
      if (axis_q == 3'(i)) begin
        record = tail_q[4*i+:3];
        served = serve_q[i];
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (write_i) memory[address_i] <= data_i;
    read_q <= memory[{axis_q, record, word_q}];
    loading_word_q <= word_q;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      head_q    <= '0;
      tail_q    <= '0;
      serve_q   <= '0;
      axis_q    <= '0;
      word_q    <= '0;
      round_q   <= 1'b0;
      sample_q  <= 1'b0;
      loading_q <= '0;
    end else begin
      sample_q <= tick_i;
      if (head_write_i) head_q <= head_i;
      if (sample_q) begin
        serve_q <= request_i & waiting;
        round_q <= 1'b1;
        axis_q  <= '0;
        word_q  <= '0;
      end else if (round_q) begin
        if (served && word_q != LAST_WORD) word_q <= word_q + 3'd1;
        else begin
          word_q <= '0;
          axis_q <= axis_q + 3'd1;
          if (axis_q == LAST_AXIS) round_q <= 1'b0;
        end
      end
      for (int unsigned i = 0; i < Axes; i++) begin
        loading_q[i] <= round_q && serve_q[i] && axis_q == 3'(i) && !abort_i[i];
        if (abort_i[i]) begin
          tail_q[4*i+:4] <= head_q[4*i+:4];
          serve_q[i]     <= 1'b0;
        end else if (round_q && serve_q[i] && axis_q == 3'(i) && word_q == LAST_WORD) begin
          tail_q[4*i+:4] <= tail_q[4*i+:4] + 4'd1;
        end
      end
    end
  end

  assign head_o      = head_q;
  assign tail_o      = tail_q;
  assign waiting_o   = waiting | loading_q;
  assign load_o      = loading_q;
  assign load_word_o = loading_word_q;
  assign load_data_o = read_q;

endmodule
