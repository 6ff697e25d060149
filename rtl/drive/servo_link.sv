// SPDX-License-Identifier: Apache-2.0
// servo_link: runs a processor once per trigger, without a host: samples in, a run, compare values out.
// Contract: a trigger_i while enable_i and nothing goes on writes word n of the samples, n = 0 .. 4 Axes, to
// constants + n of the asip (asip_regmap), one a clock, with orders_i Axes words more, which go as
// they are (order_i), starts a run, waits for irq_i (its IRQ_ENABLE
// has done and fault), reads STATUS, and of a good run outputs n = 0 .. 3 Axes - 1, each to value_o with index
// n. done_o is high for a clock after the last of them. Words are binary32 numbers 1.5 * 2^23 + value,
// value of 23 bits with sign, which wires make; of an output its lowest bits are the value, as the program adds
// 1.5 * 2^23 too. A trigger_i while busy_o is late_o; a run with a fault is fault_o; neither starts a run.
// The bus is Avalon-MM.
module servo_link #(
    parameter int unsigned Axes  = 5,
    parameter int unsigned Width = 12  // of a compare value
) (
    input  logic             clk_i,
    input  logic             rst_ni,
    input  logic             enable_i,
    input  logic             trigger_i,
    input  logic             orders_i,     // steady while busy_o
    // samples: word 4 axis + 0, 1, 2: position, currents a, b; 3: clocks since the last edge; 4 Axes: bus;
    // 4 Axes + 1 + axis: its order
    output logic [$clog2(5*Axes+1)-1:0] word_o,
    input  logic signed [22:0] sample_i,   // of word_o, in the same clock
    input  logic [31:0]        order_i,    // the same
    // compare values
    output logic             value_valid_o,
    output logic [2:0]       axis_o,
    output logic [1:0]       phase_o,
    output logic [Width-1:0] value_o,
    output logic             done_o,
    // processor
    output logic [13:0]      address_o,
    output logic             read_o,
    output logic             write_o,
    output logic [31:0]      writedata_o,
    input  logic [31:0]      readdata_i,
    input  logic             waitrequest_i,
    input  logic             irq_i,
    // state
    output logic             busy_o,
    output logic             late_o,
    output logic             fault_o
);

  typedef enum logic [2:0] {
    StIdle    = 3'd0,
    StInputs  = 3'd1,
    StStart   = 3'd2,
    StRun     = 3'd3,
    StStatus  = 3'd4,
    StOutputs = 3'd5,
    StDone    = 3'd6
  } state_e;

  localparam logic [13:0] CONSTANTS = 14'(asip_regmap_pkg::BASE_CONSTANTS);
  localparam logic [13:0] OUTPUTS = 14'(asip_regmap_pkg::BASE_OUTPUTS);
  localparam logic [13:0] CONTROL = 14'(asip_regmap_pkg::BASE_CSR) + 14'(asip_regmap_pkg::REG_CONTROL);
  localparam logic [13:0] STATUS = 14'(asip_regmap_pkg::BASE_CSR) + 14'(asip_regmap_pkg::REG_STATUS);
  localparam logic [31:0] CLEAR = 32'd1 << asip_regmap_pkg::CONTROL_CLEAR_LSB;
  localparam logic [31:0] START = CLEAR | 32'd1 << asip_regmap_pkg::CONTROL_START_LSB;
  localparam int unsigned WordBits = $clog2(5 * Axes + 1);
  localparam int unsigned LastSample = 4 * Axes;
  localparam int unsigned LastOrder = 5 * Axes;
  localparam int unsigned LastOutput = 3 * Axes - 1;

  state_e state_q;
  logic [2:0] axis_q;
  logic [WordBits-1:0] word_q;
  logic [1:0] phase_q;
  logic accepted, run_failed, is_order, last_input, last_output;

  assign accepted    = (read_o || write_o) && !waitrequest_i;
  assign is_order    = word_q > WordBits'(LastSample);
  assign last_input  = word_q == WordBits'(orders_i ? LastOrder : LastSample);
  assign last_output = word_q == WordBits'(LastOutput);
  assign run_failed  = readdata_i[asip_regmap_pkg::STATUS_FAULT_LSB];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= StIdle;
      word_q  <= '0;
      axis_q  <= '0;
      phase_q <= '0;
    end else begin
      case (state_q)
        StIdle:    if (trigger_i && enable_i) state_q <= StInputs;
        StInputs:  if (accepted && last_input) state_q <= StStart;
        StStart:   if (accepted) state_q <= StRun;
        StRun:     if (irq_i) state_q <= StStatus;
        StStatus:  if (accepted) state_q <= run_failed ? StIdle : StOutputs;
        StOutputs: if (accepted && last_output) state_q <= StDone;
        default:   state_q <= StIdle;
      endcase
      if (state_q == StInputs || state_q == StOutputs) begin
        if (accepted) word_q <= word_q + 1'b1;
      end else word_q <= '0;
      if (state_q != StOutputs) begin
        axis_q  <= '0;
        phase_q <= '0;
      end else if (accepted) begin
        axis_q  <= axis_q + 3'(phase_q[1]);
        phase_q <= phase_q[1] ? 2'd0 : phase_q + 2'd1;
      end
    end
  end

  always_comb begin
    address_o   = CONTROL;
    writedata_o = START;
    if (state_q == StInputs) begin
      address_o   = CONSTANTS + 14'(word_q);
      writedata_o = is_order ? order_i : {9'h096, !sample_i[22], sample_i[21:0]};
    end
    if (state_q == StStatus) address_o = STATUS;
    if (state_q == StOutputs) address_o = OUTPUTS + 14'(word_q);
  end

  assign write_o       = state_q == StInputs || state_q == StStart;
  assign read_o        = state_q == StStatus || state_q == StOutputs;
  assign word_o        = word_q;
  assign value_valid_o = state_q == StOutputs && accepted;
  assign axis_o        = axis_q;
  assign phase_o       = phase_q;
  assign value_o       = readdata_i[Width-1:0];
  assign done_o        = state_q == StDone;
  assign busy_o        = state_q != StIdle;
  assign late_o        = trigger_i && enable_i && busy_o;
  assign fault_o       = state_q == StStatus && accepted && run_failed;

endmodule
