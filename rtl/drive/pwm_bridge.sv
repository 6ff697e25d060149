// SPDX-License-Identifier: Apache-2.0
// pwm_bridge: three half bridges of one motor, with the values they compare, its modes and its trip.
// Contract: values are written one a clock in any order; commit_i hands all three over, and the next load_i
// of the carrier puts them into force. All gates are off after the second clock edge that sees fault_i or
// alarm_i, and stay off, with trip_o, until clear_i comes when both are gone.
module pwm_bridge #(
    parameter int unsigned Width         = 12,
    parameter int unsigned DeadBits      = 8,
    parameter int unsigned LeastDeadTime = 12
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    // carrier
    input  logic [Width-1:0]    count_i,
    input  logic                up_i,
    input  logic                load_i,
    // registers
    input  logic [1:0]          mode_i,       // 0, 3: off, 1: brake, all low gates on, 2: run
    input  logic [DeadBits-1:0] dead_time_i,
    // values
    input  logic                write_i,
    input  logic [1:0]          phase_i,      // 0, 1, 2
    input  logic [Width-1:0]    value_i,
    input  logic                commit_i,
    // faults
    input  logic                fault_i,      // of the power stage, asynchronous
    input  logic                alarm_i,      // from this clock
    input  logic                clear_i,
    output logic                trip_o,
    // gates
    output logic [2:0]          high_o,
    output logic [2:0]          low_o,
    output logic [2:0]          ordered_o
);

  localparam logic [1:0] MoBrake = 2'd1;
  localparam logic [1:0] MoRun = 2'd2;

  logic [Width-1:0] written_q[0:2];
  logic [Width-1:0] shadow_q[0:2];
  logic [1:0] fault_q;  // synchroniser; its first register only ever turns gates off
  logic [DeadBits-1:0] dead_time_q;
  logic alarm_q, trip_q, off;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      fault_q     <= '0;
      alarm_q     <= 1'b0;
      trip_q      <= 1'b0;
      dead_time_q <= DeadBits'(LeastDeadTime);
    end else begin
      fault_q     <= {fault_q[0], fault_i};
      alarm_q     <= alarm_i;
      trip_q      <= (trip_q && !clear_i) || (|fault_q) || alarm_q;
      dead_time_q <= (dead_time_i < DeadBits'(LeastDeadTime)) ? DeadBits'(LeastDeadTime)
                                                              : dead_time_i;
    end
  end

  assign off    = (|fault_q) || alarm_q || trip_q;
  assign trip_o = trip_q;

  genvar i;
  generate
    for (i = 0; i < 3; i++) begin : gen_phase
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          written_q[i] <= '0;
          shadow_q[i]  <= '0;
        end else begin
          if (write_i && phase_i == 2'(i)) written_q[i] <= value_i;
          if (commit_i) shadow_q[i] <= written_q[i];
        end
      end

      pwm_phase #(
          .Width   (Width),
          .DeadBits(DeadBits)
      ) u_phase (
          .clk_i,
          .rst_ni,
          .count_i,
          .up_i,
          .load_i,
          .compare_i  (shadow_q[i]),
          .dead_time_i(dead_time_q),
          .run_i      (mode_i == MoRun),
          .brake_i    (mode_i == MoBrake),
          .off_i      (off),
          .ordered_o  (ordered_o[i]),
          .high_o     (high_o[i]),
          .low_o      (low_o[i])
      );
    end
  endgenerate

endmodule
