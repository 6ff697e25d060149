// SPDX-License-Identifier: Apache-2.0
// profile_memory: rings of phase records, one an axis.
// The host writes records and then moves the heads: those of several axes together, and velocity_control
// looks at all of them in one clock, so what was released together starts together. Contract: the word
// requested of an axis' oldest record is there a clock later; take_i uses the record up. A full ring is
// the host's to avoid (head - tail <= 8).
module profile_memory #(
    parameter int unsigned Axes = 5  // 1..8
) (
    input  logic              clk_i,
    input  logic              rst_ni,
    input  logic [Axes-1:0]   abort_i,    // drop what waits for the axis
    // host: word address {axis, record, word}, and heads, 4 bits an axis
    input  logic              write_i,
    input  logic [8:0]        address_i,
    input  logic [31:0]       data_i,
    input  logic              head_write_i,
    input  logic [4*Axes-1:0] head_i,
    output logic [4*Axes-1:0] head_o,
    output logic [4*Axes-1:0] tail_o,
    // velocity_control
    output logic [Axes-1:0]   waiting_o,  // a record is there
    input  logic [2:0]        axis_i,
    input  logic [2:0]        word_i,
    output logic [31:0]       record_o,
    input  logic [Axes-1:0]   take_i
);

  logic [31:0] memory[0:511];
  logic [31:0] record_q;
  logic [4*Axes-1:0] head_q, tail_q;
  logic [2:0] record;

  always_comb begin
    record = 3'd0;
    for (int unsigned i = 0; i < Axes; i++) begin
      waiting_o[i] = head_q[4*i+:4] != tail_q[4*i+:4];
      if (axis_i == 3'(i)) record = record | tail_q[4*i+:3];
    end
  end

  always_ff @(posedge clk_i) begin
    if (write_i) memory[address_i] <= data_i;
    record_q <= memory[{axis_i, record, word_i}];
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      head_q <= '0;
      tail_q <= '0;
    end else begin
      if (head_write_i) head_q <= head_i;
      for (int unsigned i = 0; i < Axes; i++) begin
        if (abort_i[i]) tail_q[4*i+:4] <= head_q[4*i+:4];
        else if (take_i[i]) tail_q[4*i+:4] <= tail_q[4*i+:4] + 4'd1;
      end
    end
  end

  assign head_o   = head_q;
  assign tail_o   = tail_q;
  assign record_o = record_q;

endmodule
