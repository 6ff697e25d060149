// SPDX-License-Identifier: Apache-2.0
// debug_stage: words staged for bank K; a commit writes them all between two runs.
// Contract: from the first to the last of its writes it is the only one on the core's bus, and the core is
// idle, so that no run starts between. A word that is written waits one clock at least, and commit comes
// three clocks after a word at the earliest. A word staged twice is written twice, in order.
// More words than there is room for: overflow, and nothing is committed before a discard.
module debug_stage #(
    parameter int unsigned WordsLog2 = 6
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // writes of registers and of block `stage`
    input  logic        csr_write_i,
    input  logic [5:0]  csr_index_i,
    input  logic [31:0] csr_data_i,
    input  logic        stage_write_i,
    input  logic [6:0]  stage_index_i,
    input  logic [31:0] stage_data_i,
    // from and to the core's bus
    input  logic        core_busy_i,
    input  logic        run_start_i,
    output logic        write_o,
    output logic [13:0] address_o,
    output logic [31:0] data_o,
    input  logic        wait_i,
    // to the registers
    output logic [7:0]  count_o,
    output logic        committing_o,
    output logic        overflow_o,
    output logic [15:0] version_o,
    output logic [15:0] run_version_o
);

  localparam int unsigned Room = 1 << WordsLog2;

  logic commit, discard, last, stored, full;
  logic committing_q, overflow_q;
  logic [WordsLog2:0] count_q, next_q;
  logic [15:0] version_q, run_version_q;
  logic [WordsLog2:0] next;
  logic [WordsLog2-1:0] ahead;
  logic [38:0] entry_q;  // of next_q
  logic [38:0] ahead_q;  // the one after it
  logic [38:0] memory[0:Room-1];

  assign commit  = csr_write_i && csr_index_i == debug_regmap_pkg::REG_CONTROL &&
                   csr_data_i[debug_regmap_pkg::CONTROL_COMMIT_LSB];
  assign discard = csr_write_i && csr_index_i == debug_regmap_pkg::REG_CONTROL &&
                   csr_data_i[debug_regmap_pkg::CONTROL_DISCARD_LSB];
  assign full    = count_q[WordsLog2];
  assign stored  = stage_write_i && !full && !committing_q;
  assign last    = write_o && !wait_i && next_q + 1'b1 == count_q;
  assign next    = write_o && !wait_i ? next_q + 1'b1 : next_q;

  // What becomes of a write is known late: it only moves the word that was read before.
  assign ahead = next_q[WordsLog2-1:0] + WordsLog2'(committing_q);

  always_ff @(posedge clk_i) begin
    ahead_q <= memory[ahead];
    if (!committing_q || (write_o && !wait_i)) entry_q <= ahead_q;
    if (stored) memory[count_q[WordsLog2-1:0]] <= {stage_index_i, stage_data_i};
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      committing_q  <= 1'b0;
      overflow_q    <= 1'b0;
      count_q       <= '0;
      next_q        <= '0;
      version_q     <= 16'd0;
      run_version_q <= 16'd0;
    end else begin
      if (stored) count_q <= count_q + 1'b1;
      // What comes while a commit waits would belong to the next one: it is refused as well.
      if (stage_write_i && !stored) overflow_q <= 1'b1;
      if (commit && !overflow_q && |count_q) committing_q <= 1'b1;
      next_q <= next;
      if (last) begin
        committing_q <= 1'b0;
        count_q      <= '0;
        next_q       <= '0;
        version_q    <= version_q + 1'b1;
      end
      if (discard && (!committing_q || next_q == '0) && !(write_o && !wait_i)) begin
        committing_q <= 1'b0;
        overflow_q   <= 1'b0;
        count_q      <= '0;
      end
      if (run_start_i) run_version_q <= version_q;
    end
  end

  assign write_o       = committing_q && !core_busy_i;
  assign address_o     = 14'(asip_regmap_pkg::BASE_CONSTANTS) + 14'(entry_q[38:32]);
  assign data_o        = entry_q[31:0];
  assign count_o       = 8'(count_q);
  assign committing_o  = committing_q;
  assign overflow_o    = overflow_q;
  assign version_o     = version_q;
  assign run_version_o = run_version_q;

endmodule
