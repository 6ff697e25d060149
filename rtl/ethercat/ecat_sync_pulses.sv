// SPDX-License-Identifier: Apache-2.0
// ecat_sync_pulses: SYNC0 at START_TIME and every SYNC0_CYCLE; SYNC1 that SYNC1_CYCLE after the first, then after the next
// one that comes after it: with SYNC1_CYCLE of n to n + 1 times SYNC0_CYCLE, after every (n + 1)-th.
// Contract: a pulse begins two clocks after the system time's reaching it and lasts PULSE_LENGTH clocks (0: until its
// status is read by the application). begins_o: in the clock before its first. A start that has passed already begins at once
// and goes on from there cycle by cycle, two clocks each, until it is in the future. live_* as in ecat_control.
module ecat_sync_pulses (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic        done_i,        // a frame's writes are in force
    input  logic [11:0] live_address_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    input  logic [63:0] time_i,
    output logic [1:0]  begins_o,
    output logic [1:0]  sync_o
);

  logic [63:0] next_q, start_q, second_q;
  logic [31:0] cycle_q, shift_q;
  logic [15:0] length_q;
  logic [1:0] shown_q;  // SYNC0, SYNC1
  logic cyclic_q, on_q, waiting_q, new_q, first;
  logic [1:0] due_q, pulse_q, fire, status_read;
  logic [15:0] left_q[0:1];
  logic [11:0] place;

  assign place = register_i.address;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      start_q      <= '0;
      cycle_q      <= '0;
      shift_q      <= '0;
      length_q     <= esc_regmap_pkg::RESET_PULSE_LENGTH;
      cyclic_q     <= 1'b0;
      shown_q      <= '0;
      new_q        <= 1'b0;
    end else begin
      if (done_i) new_q <= 1'b0;
      if (register_i.write) begin
        if (place[11:3] == esc_regmap_pkg::REG_START_TIME[11:3]) start_q[8*place[2:0]+:8] <= register_i.data;
        if (place[11:2] == esc_regmap_pkg::REG_SYNC0_CYCLE[11:2]) cycle_q[8*place[1:0]+:8] <= register_i.data;
        if (place[11:2] == esc_regmap_pkg::REG_SYNC1_CYCLE[11:2]) shift_q[8*place[1:0]+:8] <= register_i.data;
        if (place == esc_regmap_pkg::REG_PULSE_LENGTH) length_q[7:0] <= register_i.data;
        if (place == esc_regmap_pkg::REG_PULSE_LENGTH + 12'd1) length_q[15:8] <= register_i.data;
        if (place == esc_regmap_pkg::REG_SYNC_ACTIVATION) begin
          cyclic_q   <= register_i.data[esc_regmap_pkg::SYNC_ACTIVATION_CYCLIC_LSB];
          shown_q[0] <= register_i.data[esc_regmap_pkg::SYNC_ACTIVATION_SYNC0_LSB];
          shown_q[1] <= register_i.data[esc_regmap_pkg::SYNC_ACTIVATION_SYNC1_LSB];
          new_q      <= 1'b1;
        end
      end
    end
  end

  // Times that have come.
  logic [63:0] to_next, to_second;
  logic [33:0] ahead;
  assign to_next   = time_i - next_q;   // its sign counts
  assign to_second = time_i - second_q;
  assign ahead     = second_q[33:0] - next_q[33:0];  // how far SYNC1 is behind the next SYNC0
  assign first     = !on_q || ahead[33] || (ahead == '0 && fire[0]);
  assign fire[0]   = on_q && !to_next[63] && !due_q[0];
  assign fire[1]   = waiting_q && !to_second[63] && first && !due_q[1];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      next_q    <= '0;
      second_q  <= '0;
      on_q      <= 1'b0;
      waiting_q <= 1'b0;
      due_q     <= '0;
    end else begin
      due_q <= fire;
      if (done_i && new_q) begin
        on_q      <= cyclic_q;
        waiting_q <= 1'b0;
        next_q    <= start_q;
      end else begin
        if (fire[0]) begin
          next_q    <= next_q + 64'(cycle_q);
          on_q      <= cycle_q != '0;
          if (!waiting_q) second_q <= next_q + 64'(shift_q);
        end
        waiting_q <= waiting_q ? !fire[1] : fire[0];
      end
    end
  end

  genvar n;
  generate
    for (n = 0; n < 2; n++) begin : gen_pulse
      localparam logic [11:0] Status = n == 0 ? esc_regmap_pkg::REG_SYNC_STATUS_0 : esc_regmap_pkg::REG_SYNC_STATUS_1;
      assign status_read[n] = register_i.read && register_i.application && place == Status;
      assign begins_o[n]    = due_q[n] && shown_q[n];
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          pulse_q[n] <= 1'b0;
          left_q[n]  <= '0;
        end else if (begins_o[n]) begin
          pulse_q[n] <= 1'b1;
          left_q[n]  <= length_q;
        end else if (length_q == '0 ? status_read[n] : left_q[n] <= 16'd1) begin
          pulse_q[n] <= 1'b0;
        end else begin
          left_q[n] <= left_q[n] - 1'b1;
        end
      end
    end
  endgenerate

  always_comb begin
    live_hit_o  = 1'b1;
    live_data_o = next_q[8*live_address_i[2:0]+:8];
    if (live_address_i == esc_regmap_pkg::REG_SYNC_STATUS_0) begin
      live_data_o = 8'(pulse_q[0]) << esc_regmap_pkg::SYNC_STATUS_0_STATE_LSB;
    end else if (live_address_i == esc_regmap_pkg::REG_SYNC_STATUS_1) begin
      live_data_o = 8'(pulse_q[1]) << esc_regmap_pkg::SYNC_STATUS_1_STATE_LSB;
    end else if (live_address_i[11:3] != esc_regmap_pkg::REG_START_TIME[11:3] || !on_q) begin
      live_hit_o = 1'b0;
    end
  end

  assign sync_o = pulse_q;

  logic unused;
  assign unused = &{to_next[62:0], to_second[62:0]};

endmodule
