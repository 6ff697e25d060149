// SPDX-License-Identifier: Apache-2.0
// ethercat_nios: the device on the bus: the slave controller with the Nios II system FPGA2 as its application.
// Contract: the controller is at EscBase of the core's address space (nios_sw/ethercat/esc_nios.h), irq_o of it is not
// used. A reset that the master asks for (ESC_RESET) resets the core too: reset_no is low then, and the program
// restarts with its data memory unchanged. Ports host_*, run_i, tick_i and pending_o are those of n2_system, all MII ports those of ethercat_slave.
// due_o asks for a control tick each Period clocks, with SYNC0 if that is on (ecat_tick): the machine then writes the inputs and
// gives tick_i.
module ethercat_nios #(
    parameter logic [31:0] EscBase = 32'h2100_0000,
    parameter int unsigned Period  = 10000,
    parameter int unsigned Trace   = 0
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // MII, port n at bit n (nibble n)
    input  logic        mii_tick_i,
    input  logic [1:0]  link_i,
    input  logic [1:0]  mii_rx_clk_i,
    input  logic [1:0]  mii_rx_dv_i,
    input  logic [1:0]  mii_rx_er_i,
    input  logic [7:0]  mii_rxd_i,
    output logic [1:0]  mii_tx_en_o,
    output logic [7:0]  mii_txd_o,
    // host of the Nios II system: the machine
    input  logic        run_i,
    input  logic [31:0] host_address_i,
    input  logic        host_write_i,
    input  logic [31:0] host_wdata_i,
    output logic [31:0] host_rdata_o,
    output logic        due_o,
    input  logic        tick_i,
    output logic        pending_o,
    output logic        overrun_o,
    output logic [31:0] tick_cycles_o,
    // console and end of the program
    output logic        console_valid_o,
    output logic [7:0]  console_data_o,
    output logic        exit_valid_o,
    output logic [31:0] exit_status_o,
    output logic        reset_no,
    // distributed clocks
    input  logic [1:0]  latch_i,
    output logic [1:0]  sync_o,
    output logic [63:0] time_o
);

  logic [31:0] address, writedata, readdata, esc_readdata;
  logic [3:0] byteenable;
  logic read, write, waitrequest, esc_waitrequest, select;

  assign select      = address[31:16] == EscBase[31:16];
  assign readdata    = select ? esc_readdata : 32'd0;
  assign waitrequest = select && esc_waitrequest;

  logic unused_halted, unused_valid, unused_write, unused_exception, unused_debug, unused_irq;
  logic [31:0] unused_cycles, unused_retired, unused_pc, unused_instruction, unused_value, unused_read;
  logic [4:0] unused_dst, unused_cause;

  n2_system #(
      .Platform(2),
      .Trace   (Trace),
      .External(1)
  ) u_system (
      .clk_i,
      .rst_ni             (reset_no),
      .run_i,
      .host_address_i,
      .host_write_i,
      .host_wdata_i,
      .host_rdata_o,
      .enable_i           (1'b1),
      .tick_i,
      .pending_o,
      .overrun_o,
      .tick_cycles_o,
      .console_valid_o,
      .console_data_o,
      .exit_valid_o,
      .exit_status_o,
      .ext_address_o      (address),
      .ext_read_o         (read),
      .ext_write_o        (write),
      .ext_byteenable_o   (byteenable),
      .ext_writedata_o    (writedata),
      .ext_readdata_i     (readdata),
      .ext_waitrequest_i  (waitrequest),
      .debug_address_i    ('0),
      .debug_read_i       (1'b0),
      .debug_write_i      (1'b0),
      .debug_writedata_i  ('0),
      .debug_readdata_o   (unused_read),
      .debug_waitrequest_o(unused_debug),
      .debug_halted_o     (unused_halted),
      .cycles_o           (unused_cycles),
      .retired_o          (unused_retired),
      .trace_valid_o      (unused_valid),
      .trace_pc_o         (unused_pc),
      .trace_instruction_o(unused_instruction),
      .trace_write_o      (unused_write),
      .trace_dst_o        (unused_dst),
      .trace_value_o      (unused_value),
      .trace_exception_o  (unused_exception),
      .trace_cause_o      (unused_cause)
  );

  ethercat_slave u_slave (
      .clk_i,
      .rst_ni,
      .mii_tick_i,
      .link_i,
      .mii_rx_clk_i,
      .mii_rx_dv_i,
      .mii_rx_er_i,
      .mii_rxd_i,
      .mii_tx_en_o,
      .mii_txd_o,
      .avs_address_i    (address[15:2]),
      .avs_read_i       (read && select),
      .avs_write_i      (write && select),
      .avs_byteenable_i (byteenable),
      .avs_writedata_i  (writedata),
      .avs_readdata_o   (esc_readdata),
      .avs_waitrequest_o(esc_waitrequest),
      .irq_o            (unused_irq),
      .reset_no,
      .latch_i,
      .sync_o,
      .time_o
  );

  ecat_tick #(
      .Period(Period)
  ) u_tick (
      .clk_i,
      .rst_ni(reset_no),
      .run_i,
      .sync_i(sync_o[0]),
      .tick_o(due_o)
  );

  logic unused;
  assign unused = &{address[1:0], unused_halted, unused_valid, unused_write, unused_exception, unused_debug, unused_irq,
                    unused_cycles, unused_retired, unused_pc, unused_instruction, unused_value, unused_read,
                    unused_dst, unused_cause};

endmodule
