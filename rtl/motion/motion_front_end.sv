// SPDX-License-Identifier: Apache-2.0
// motion_front_end: five axes of velocity control, pulse generation and step output as an Avalon-MM agent.
// Contract: register map docs/motion_regmap.md, 32-bit word accesses, writes one cycle, reads two; one tick
// every ClocksPerTick clocks, a microsecond.
module motion_front_end #(
    parameter int unsigned Axes          = 5,    // 1..8
    parameter int unsigned ClocksPerTick = 100,  // clock frequency in MHz
    parameter logic [31:0] Modulus       = 32'd1_600_000_000
) (
    input  logic            clk_i,
    input  logic            rst_ni,
    // Avalon-MM
    input  logic [motion_regmap_pkg::ADDRESS_WIDTH-1:0] address_i,
    input  logic            read_i,
    input  logic            write_i,
    input  logic [31:0]     writedata_i,
    output logic [31:0]     readdata_o,
    output logic            waitrequest_o,
    output logic            irq_o,
    // drives
    output logic [Axes-1:0] step_o,
    output logic [Axes-1:0] direction_o
);

  localparam int unsigned TimeBits = motion_regmap_pkg::STEP_TIMING_LENGTH_WIDTH;
  localparam int unsigned TickBits = $clog2(ClocksPerTick);
  localparam logic [TickBits-1:0] LAST_CLOCK = TickBits'(ClocksPerTick - 1);

  logic [TickBits-1:0] clock_q;
  logic        tick, csr_write, head_write, read_q;
  logic [4:0]  register_index;
  logic [31:0] ticks_q, read_data, readdata_q;
  logic [TimeBits-1:0] length_q, space_q, setup_q, hold_q;
  logic [1:0]  irq_enable_q;
  logic [Axes-1:0] abort, running, underrun, overrun, waiting, request, load;
  logic [2:0]  load_word;
  logic [31:0] load_data;
  logic [4*Axes-1:0] head, tail;
  logic [32*Axes-1:0] position;

  assign register_index = address_i[4:0];
  assign csr_write  = write_i && address_i[9:5] == 5'd0;
  assign head_write = csr_write && register_index == motion_regmap_pkg::REG_HEAD;
  assign abort      = (csr_write && register_index == motion_regmap_pkg::REG_CONTROL)
                      ? writedata_i[Axes-1:0] : '0;
  assign tick       = clock_q == LAST_CLOCK;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      clock_q      <= '0;
      ticks_q      <= '0;
      length_q     <= motion_regmap_pkg::RESET_STEP_TIMING[TimeBits-1:0];
      space_q      <= motion_regmap_pkg::RESET_STEP_TIMING[16+:TimeBits];
      setup_q      <= motion_regmap_pkg::RESET_DIRECTION_TIMING[TimeBits-1:0];
      hold_q       <= motion_regmap_pkg::RESET_DIRECTION_TIMING[16+:TimeBits];
      irq_enable_q <= '0;
      read_q       <= 1'b0;
    end else begin
      clock_q <= tick ? '0 : clock_q + 1'b1;
      if (tick) ticks_q <= ticks_q + 32'd1;
      if (csr_write && register_index == motion_regmap_pkg::REG_STEP_TIMING) begin
        length_q <= writedata_i[TimeBits-1:0];
        space_q  <= writedata_i[16+:TimeBits];
      end
      if (csr_write && register_index == motion_regmap_pkg::REG_DIRECTION_TIMING) begin
        setup_q <= writedata_i[TimeBits-1:0];
        hold_q  <= writedata_i[16+:TimeBits];
      end
      if (csr_write && register_index == motion_regmap_pkg::REG_IRQ_ENABLE)
        irq_enable_q <= writedata_i[1:0];
      read_q <= read_i && !read_q;
    end
  end

  always_comb begin
    read_data = 32'd0;
    case (register_index)
      motion_regmap_pkg::REG_ID: read_data = motion_regmap_pkg::RESET_ID;
      motion_regmap_pkg::REG_CONFIG: read_data = {16'd0, 8'(ClocksPerTick), 4'd8, 4'(Axes)};
      motion_regmap_pkg::REG_STATUS:
      read_data = {8'd0, 8'(overrun), 8'(underrun), 8'(running)};
      motion_regmap_pkg::REG_HEAD: read_data = 32'(head);
      motion_regmap_pkg::REG_TAIL: read_data = 32'(tail);
      motion_regmap_pkg::REG_STEP_TIMING: read_data = {6'd0, space_q, 6'd0, length_q};
      motion_regmap_pkg::REG_DIRECTION_TIMING: read_data = {6'd0, hold_q, 6'd0, setup_q};
      motion_regmap_pkg::REG_IRQ_ENABLE: read_data = {30'd0, irq_enable_q};
      motion_regmap_pkg::REG_TICKS: read_data = ticks_q;
      default:
      for (int unsigned i = 0; i < Axes; i++)
        if (register_index == motion_regmap_pkg::REG_POSITION0 + 5'(i))
          read_data = position[32*i+:32];
    endcase
    if (address_i[9:5] != 5'd0) read_data = 32'd0;
  end

  always_ff @(posedge clk_i) readdata_q <= read_data;

  profile_memory #(
      .Axes(Axes)
  ) u_profiles (
      .clk_i,
      .rst_ni,
      .tick_i      (tick),
      .abort_i     (abort),
      .write_i     (write_i && address_i[9]),
      .address_i   (address_i[8:0]),
      .data_i      (writedata_i),
      .head_write_i(head_write),
      .head_i      (writedata_i[4*Axes-1:0]),
      .head_o      (head),
      .tail_o      (tail),
      .waiting_o   (waiting),
      .request_i   (request),
      .load_o      (load),
      .load_word_o (load_word),
      .load_data_o (load_data)
  );

  for (genvar i = 0; i < Axes; i++) begin : gen_axis
    motion_axis #(
        .Modulus (Modulus),
        .TimeBits(TimeBits)
    ) u_axis (
        .clk_i,
        .rst_ni,
        .abort_i    (abort[i]),
        .tick_i     (tick),
        .load_i     (load[i]),
        .load_word_i(load_word),
        .load_data_i(load_data),
        .request_o  (request[i]),
        .length_i   (length_q),
        .space_i    (space_q),
        .setup_i    (setup_q),
        .hold_i     (hold_q),
        .running_o  (running[i]),
        .underrun_o (underrun[i]),
        .overrun_o  (overrun[i]),
        .position_o (position[32*i+:32]),
        .step_o     (step_o[i]),
        .direction_o(direction_o[i])
    );
  end

  assign readdata_o    = readdata_q;
  assign waitrequest_o = read_i && !read_q;
  assign irq_o = (irq_enable_q[0] && (running | waiting) == '0)
                 || (irq_enable_q[1] && (underrun | overrun) != '0);

endmodule
