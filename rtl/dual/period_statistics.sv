// SPDX-License-Identifier: Apache-2.0
// period_statistics: last and extreme clocks of the parts of a period.
// Contract: all values since clear_i; elapsed_i counts clocks from the start of the period. late_i: a period
// starts while work of the one before is under way; that one has used all its clocks_i and left none.
module period_statistics (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        clear_i,
    input  logic        waiting_i,      // the work of a period that has begun comes after clear_i
    input  logic [1:0]  cycles_i,       // data_i holds the cycles of core n's run
    input  logic [31:0] data_i,
    input  logic        start_i,
    input  logic        late_i,
    input  logic        commit_i,
    input  logic        finished_i,
    input  logic        copying_i,
    input  logic [15:0] elapsed_i,
    input  logic [15:0] clocks_i,
    output logic [31:0] periods_o,
    output logic [31:0] overruns_o,
    output logic [63:0] core_last_o,    // core n in bits 32n+31..32n
    output logic [63:0] core_min_o,
    output logic [63:0] core_max_o,
    output logic [15:0] command_last_o,
    output logic [15:0] command_max_o,
    output logic [15:0] copy_last_o,
    output logic [15:0] copy_max_o,
    output logic [15:0] used_last_o,
    output logic [15:0] used_max_o,
    output logic [31:0] left_min_o
);

  logic [15:0] copy_q, used, left;
  logic over;

  assign over = finished_i || late_i;
  assign used = late_i ? clocks_i : elapsed_i;
  assign left = clocks_i - used;

  genvar n;
  generate
    for (n = 0; n < 2; n++) begin : gen_core
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          core_last_o[32*n+:32] <= 32'd0;
          core_min_o[32*n+:32]  <= 32'hffff_ffff;
          core_max_o[32*n+:32]  <= 32'd0;
        end else if (clear_i) begin
          core_min_o[32*n+:32] <= 32'hffff_ffff;
          core_max_o[32*n+:32] <= 32'd0;
        end else if (cycles_i[n]) begin
          core_last_o[32*n+:32] <= data_i;
          if (data_i < core_min_o[32*n+:32]) core_min_o[32*n+:32] <= data_i;
          if (data_i > core_max_o[32*n+:32]) core_max_o[32*n+:32] <= data_i;
        end
      end
    end
  endgenerate

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      periods_o      <= 32'd0;
      overruns_o     <= 32'd0;
      command_last_o <= 16'd0;
      command_max_o  <= 16'd0;
      copy_q         <= 16'd0;
      copy_last_o    <= 16'd0;
      copy_max_o     <= 16'd0;
      used_last_o    <= 16'd0;
      used_max_o     <= 16'd0;
      left_min_o     <= 32'hffff_ffff;
    end else begin
      if (start_i) begin
        periods_o <= periods_o + 32'd1;
        copy_q    <= 16'd0;
      end else if (copying_i) begin
        copy_q <= copy_q + 16'd1;
      end
      if (late_i) overruns_o <= overruns_o + 32'd1;
      if (commit_i) begin
        command_last_o <= elapsed_i;
        if (elapsed_i > command_max_o) command_max_o <= elapsed_i;
      end
      if (over) begin
        copy_last_o <= copy_q;
        used_last_o <= used;
        if (copy_q > copy_max_o) copy_max_o <= copy_q;
        if (used > used_max_o) used_max_o <= used;
        if (32'(left) < left_min_o) left_min_o <= 32'(left);
      end
      if (clear_i) begin
        periods_o     <= {31'd0, waiting_i};
        overruns_o    <= 32'd0;
        command_max_o <= 16'd0;
        copy_max_o    <= 16'd0;
        used_max_o    <= 16'd0;
        left_min_o    <= 32'hffff_ffff;
      end
    end
  end

endmodule
