// SPDX-License-Identifier: Apache-2.0
// asip_lockstep: two cores, the second one Delay clocks after the first; what they do is compared.
// Contract: protocol and cycles of `asip`, of whose first core the answers are. mismatch_o, which belongs to
// the power stage, rises Delay + 2 clocks after the cores differ in a write-back, a bundle issued, an answer
// on the bus or irq, and falls with CONTROL.clear. While it is high both cores are in reset, every access is
// answered at once: STATUS reports the fault DISAGREE, outputs read their safe values, all else reads 0. After
// the clear the memories count as wrong: load them again. What was read in the last Delay + 2 clocks before may be wrong.
module asip_lockstep #(
    parameter int unsigned FmaPipes  = 2,
    parameter int unsigned Slots     = 3,
    parameter int unsigned Bundles   = asip_isa_pkg::PROGRAM_BUNDLES,
    parameter int unsigned DataWords = asip_isa_pkg::DATA_WORDS,
    parameter int unsigned Delay     = 2  // clocks, 1 or more: one disturbance does not change both in the same way
) (
    input  logic                                      clk_i,
    input  logic                                      rst_ni,
    // Avalon-MM agent
    input  logic [asip_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic                                      read_i,
    input  logic                                      write_i,
    input  logic [31:0]                               writedata_i,
    output logic [31:0]                               readdata_o,
    output logic                                      waitrequest_o,
    output logic                                      irq_o,
    // to the power stage
    output logic                                      mismatch_o,
    // trace of the first core, as of `asip`
    output logic                                      trace_issue_o,
    output logic [15:0]                               trace_pc_o,
    output logic [3:0]                                trace_write_o,
    output logic [2:0][5:0]                           trace_index_o,
    output logic [2:0][31:0]                          trace_data_o
);

  localparam int unsigned AddressWidth = asip_regmap_pkg::ADDRESS_WIDTH;
  localparam logic [AddressWidth-1:0] Control =
      AddressWidth'(asip_regmap_pkg::BASE_CSR) + AddressWidth'(asip_regmap_pkg::REG_CONTROL);
  localparam logic [AddressWidth-1:0] Status =
      AddressWidth'(asip_regmap_pkg::BASE_CSR) + AddressWidth'(asip_regmap_pkg::REG_STATUS);
  localparam logic [31:0] Disagree =
      (32'd1 << asip_regmap_pkg::STATUS_FAULT_LSB) |
      (32'(asip_regmap_pkg::FAULT_DISAGREE) << asip_regmap_pkg::STATUS_CAUSE_LSB);

  localparam int unsigned OutputBits = $clog2(asip_regmap_pkg::WORDS_OUTPUTS);
  localparam int unsigned AskedWidth = AddressWidth + 34;
  localparam int unsigned DoneWidth = 170;

  typedef struct packed {  // AskedWidth bits
    logic                    read;
    logic                    write;
    logic [AddressWidth-1:0] address;
    logic [31:0]             writedata;
  } request_t;

  typedef struct packed {  // DoneWidth bits
    logic             answers;        // readdata counts
    logic [31:0]      readdata;
    logic             waitrequest;
    logic             irq;
    logic             issue;
    logic [15:0]      pc;
    logic [3:0]       write;
    logic [2:0][5:0]  index;
    logic [2:0][31:0] data;
  } done_t;

  request_t asked, asked_late;  // of the first core, of the second one
  logic [Delay:1][AskedWidth-1:0] asked_q;
  done_t done, first, second;  // first: what the first core did Delay clocks ago
  logic [Delay:1][DoneWidth-1:0] done_q;
  logic [Delay:0] up_q;  // the first core is out of reset, .. the second one
  logic [1:0] core_rst_nq;
  logic [5:0] differs_q;
  logic ready, mismatch_q, at_safe, at_outputs;
  logic [31:0] safe[0:asip_regmap_pkg::WORDS_OUTPUTS-1];  // as the host wrote them

  assign ready = up_q[Delay];

  assign asked      = {read_i && ready, write_i && ready, address_i, writedata_i};
  assign asked_late = asked_q[Delay];
  assign first      = done_q[Delay];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      up_q        <= '0;
      core_rst_nq <= '0;
      asked_q     <= '0;
      done_q      <= '0;
    end else begin
      up_q        <= mismatch_q ? '0 : {up_q[Delay-1:0], 1'b1};
      core_rst_nq <= {up_q[Delay-1] && !mismatch_q, !mismatch_q};
      asked_q[1]  <= asked;
      done_q[1]   <= done;
      for (int unsigned n = 2; n <= Delay; n++) begin
        asked_q[n] <= asked_q[n-1];
        done_q[n]  <= done_q[n-1];
      end
    end
  end

  // ---- the cores
  logic [1:0] waits, irq, issue;
  logic [1:0][31:0] readdata;
  logic [1:0][15:0] pc;
  logic [1:0][3:0] write;
  logic [1:0][2:0][5:0] index;
  logic [1:0][2:0][31:0] data;

  genvar c;
  generate
    for (c = 0; c < 2; c++) begin : gen_core
      asip_pkg::hook_out_t unused_hook;

      asip #(
          .FmaPipes (FmaPipes),
          .Slots    (Slots),
          .Bundles  (Bundles),
          .DataWords(DataWords)
      ) u_core (
          .clk_i,
          .rst_ni       (core_rst_nq[c]),
          .address_i    (c == 0 ? asked.address : asked_late.address),
          .read_i       (c == 0 ? asked.read : asked_late.read),
          .write_i      (c == 0 ? asked.write : asked_late.write),
          .writedata_i  (c == 0 ? asked.writedata : asked_late.writedata),
          .readdata_o   (readdata[c]),
          .waitrequest_o(waits[c]),
          .irq_o        (irq[c]),
          .trace_issue_o(issue[c]),
          .trace_pc_o   (pc[c]),
          .trace_write_o(write[c]),
          .trace_index_o(index[c]),
          .trace_data_o (data[c]),
          .hook_i       ('0),
          .hook_o       (unused_hook)
      );
    end
  endgenerate

  assign done   = {asked.read && !waits[0], readdata[0], waits[0], irq[0], issue[0], pc[0],
                   write[0], index[0], data[0]};
  assign second = {asked_late.read && !waits[1], readdata[1], waits[1], irq[1], issue[1], pc[1],
                   write[1], index[1], data[1]};

  // ---- comparison: of data only where they count
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      differs_q  <= '0;
      mismatch_q <= 1'b0;
    end else begin
      differs_q[0] <= {first.answers, first.waitrequest, first.irq, first.issue, first.write} !=
                      {second.answers, second.waitrequest, second.irq, second.issue, second.write};
      differs_q[1] <= second.answers && first.readdata != second.readdata;
      differs_q[2] <= second.issue && first.pc != second.pc;
      for (int unsigned b = 0; b < 3; b++) begin
        differs_q[3+b] <= (second.write[b] || (b == 2 && second.write[3])) &&
                          {first.index[b], first.data[b]} != {second.index[b], second.data[b]};
      end
      if (!ready) differs_q <= '0;
      if (|differs_q) begin
        mismatch_q <= 1'b1;
      end else if (write_i && address_i == Control && writedata_i[asip_regmap_pkg::CONTROL_CLEAR_LSB]) begin
        mismatch_q <= 1'b0;
      end
    end
  end

  assign at_safe    = 32'(address_i) / asip_regmap_pkg::WORDS_SAFE ==
                      asip_regmap_pkg::BASE_SAFE / asip_regmap_pkg::WORDS_SAFE;
  assign at_outputs = 32'(address_i) / asip_regmap_pkg::WORDS_OUTPUTS ==
                      asip_regmap_pkg::BASE_OUTPUTS / asip_regmap_pkg::WORDS_OUTPUTS;

  always_ff @(posedge clk_i) begin
    if (write_i && at_safe && !waitrequest_o) safe[address_i[OutputBits-1:0]] <= writedata_i;
  end

  always_comb begin
    readdata_o    = readdata[0];
    waitrequest_o = waits[0] || !ready;
    if (mismatch_q) begin
      readdata_o = 32'd0;
      if (address_i == Status) readdata_o = Disagree;
      if (at_outputs) readdata_o = safe[address_i[OutputBits-1:0]];
      waitrequest_o = 1'b0;
    end
  end

  assign irq_o         = irq[0] || mismatch_q;
  assign mismatch_o    = mismatch_q;
  assign trace_issue_o = issue[0];
  assign trace_pc_o    = pc[0];
  assign trace_write_o = write[0];
  assign trace_index_o = index[0];
  assign trace_data_o  = data[0];

`ifndef SYNTHESIS
  generate
    if (Delay < 1) begin : gen_check_delay
      $error("asip_lockstep: Delay=%0d, must be 1 or more", Delay);
    end
  endgenerate
`endif

endmodule
