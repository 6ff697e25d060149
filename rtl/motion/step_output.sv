// SPDX-License-Identifier: Apache-2.0
// step_output: step and direction lines of a drive from requested steps, with the drive's timing.
// Contract, in clocks: step_o is high for `length` and then low for at least `space`; direction_o is
// stable from `setup` before a rising edge of step_o until `hold` after its falling edge. Times are
// 1..2^TimeBits-1 (0 acts as 1) and may change only while idle_o. Requests that come faster
// wait; opposite ones cancel. More than 2^(BacklogBits-1)-1 waiting sets overrun_o until reset or
// clear_i, and drops the request.
module step_output #(
    parameter int unsigned TimeBits    = 10,
    parameter int unsigned BacklogBits = 8
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    input  logic                clear_i,      // forget waiting steps and the overrun; a step under way ends

    // timing, from the registers
    input  logic [TimeBits-1:0] length_i,
    input  logic [TimeBits-1:0] space_i,
    input  logic [TimeBits-1:0] setup_i,
    input  logic [TimeBits-1:0] hold_i,

    // requests
    input  logic                request_i,
    input  logic                negative_i,

    // drive
    output logic                step_o,
    output logic                direction_o,  // 1: negative
    output logic signed [31:0]  position_o,   // steps sent since reset, modulo 2^32
    output logic                idle_o,
    output logic                overrun_o
);

  localparam logic signed [BacklogBits-1:0] MOST = {1'b0, {(BacklogBits - 1) {1'b1}}};

  logic signed [BacklogBits-1:0] backlog_q;
  logic signed [31:0] position_q;
  logic [TimeBits-1:0] level_q;  // clocks that step_o stays as it is; 0, 1: this is the last
  logic [TimeBits-1:0] keep_q;  // the same of hold after a step, of setup after a turn
  logic step_q, direction_q, turned_q, overrun_q;
  logic signed [2:0] change;
  logic wanted, negative, turn, rise, fall, full, keep_over, level_over;

  assign wanted     = backlog_q != '0;
  assign negative   = backlog_q[BacklogBits-1];
  assign keep_over  = keep_q[TimeBits-1:1] == '0;
  assign level_over = level_q[TimeBits-1:1] == '0;
  assign turn = wanted && !step_q && negative != direction_q && keep_over;
  assign rise = wanted && !step_q && negative == direction_q && level_over
                && (keep_over || !turned_q);
  assign fall = step_q && level_over;
  assign full = backlog_q == (negative_i ? -MOST : MOST);

  // Change of the backlog: a request goes its way, a step towards 0.
  always_comb begin
    case ({
      request_i && !full, negative_i, rise, direction_q
    })
      4'b1000, 4'b1001, 4'b0011, 4'b0111: change = 3'sd1;
      4'b1100, 4'b1101, 4'b0010, 4'b0110: change = -3'sd1;
      4'b1011: change = 3'sd2;
      4'b1110: change = -3'sd2;
      default: change = 3'sd0;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      backlog_q   <= '0;
      position_q  <= '0;
      step_q      <= 1'b0;
      direction_q <= 1'b0;
      turned_q    <= 1'b0;
      overrun_q   <= 1'b0;
      level_q     <= '0;
      keep_q      <= '0;
    end else begin
      backlog_q <= clear_i ? '0 : backlog_q + {{(BacklogBits - 3) {change[2]}}, change};
      overrun_q <= !clear_i && (overrun_q || (request_i && full));
      if (rise) begin
        step_q     <= 1'b1;
        position_q <= position_q + {{31{direction_q}}, 1'b1};
      end
      if (fall) step_q <= 1'b0;
      if (turn) direction_q <= negative;

      if (rise || fall) level_q <= rise ? length_i : space_i;
      else if (!level_over) level_q <= level_q - 1'b1;

      if (fall || turn) begin
        keep_q   <= fall ? hold_i : setup_i;
        turned_q <= turn;
      end else if (!keep_over) keep_q <= keep_q - 1'b1;
    end
  end

  assign step_o      = step_q;
  assign direction_o = direction_q;
  assign position_o  = position_q;
  assign idle_o      = !wanted && !step_q && level_over && keep_over;
  assign overrun_o   = overrun_q;

endmodule
