// SPDX-License-Identifier: Apache-2.0
// ecat_pkg: what the modules of the EtherCAT-compatible slave controller share. Commands and layout
// as published in IEC 61158-4-12 and ETG.1000.4.
package ecat_pkg;

  localparam int unsigned FMMUS = 8;
  localparam int unsigned SYNC_MANAGERS = 8;

  localparam logic [7:0] CMD_APRD = 8'd1;
  localparam logic [7:0] CMD_APWR = 8'd2;
  localparam logic [7:0] CMD_APRW = 8'd3;
  localparam logic [7:0] CMD_FPRD = 8'd4;
  localparam logic [7:0] CMD_FPWR = 8'd5;
  localparam logic [7:0] CMD_FPRW = 8'd6;
  localparam logic [7:0] CMD_BRD = 8'd7;
  localparam logic [7:0] CMD_BWR = 8'd8;
  localparam logic [7:0] CMD_BRW = 8'd9;
  localparam logic [7:0] CMD_LRD = 8'd10;
  localparam logic [7:0] CMD_LWR = 8'd11;
  localparam logic [7:0] CMD_LRW = 8'd12;
  localparam logic [7:0] CMD_ARMW = 8'd13;
  localparam logic [7:0] CMD_FRMW = 8'd14;

  // Register of the check sequence, least significant bit first, after four more bits.
  function automatic logic [31:0] check_sequence(input logic [31:0] state, input logic [3:0] nibble);
    check_sequence = state;
    for (int i = 0; i < 4; i++) begin
      check_sequence = (check_sequence[0] ^ nibble[i])
          ? {1'b0, check_sequence[31:1]} ^ 32'hEDB88320 : {1'b0, check_sequence[31:1]};
    end
  endfunction

  localparam logic [31:0] RESIDUE_GOOD = 32'hDEBB20E3;
  localparam logic [31:0] RESIDUE_MARKED = 32'h00000000;  // the sequence was inverted on the way

  // A stream of nibbles, one a tick; a frame is a run of valid ones from the preamble on.
  typedef struct packed {
    logic       valid;
    logic       error;  // RX_ER
    logic [3:0] data;
  } nibble_t;

  // A window of one or two bytes: `mask` are the bits of a byte as a datagram has it that are accessed;
  // that byte is shifted up by `shift` at `address`, or, if `high`, only its upper part does, at bit
  // `shift` - 8, and `address` is the byte after.
  typedef struct packed {
    logic [15:0] address;
    logic [7:0]  mask;
    logic [2:0]  shift;
    logic        high;
  } window_t;

  // Who accesses: a frame as it passes (reads; writes only ask), a good frame's writes after its
  // end (and what its reads cause), the application.
  typedef struct packed {
    logic       valid;
    logic       frame;
    logic       commit;
    logic       application;
    logic       read;
    logic       write;
    logic [7:0] data;
  } access_t;

  // A frame's write, or read with consequences, until the check sequence was seen. partial: writes some bits of a byte;
  // ends: the last byte of a sync manager's area.
  typedef struct packed {
    logic       read;
    logic       write;
    logic       partial;
    logic       ends;
    logic [7:0] data;
    window_t    window;
  } log_t;
  localparam int unsigned LOG_WIDTH = 40;

  // A write to a register, or a read with consequences.
  typedef struct packed {
    logic        write;
    logic        read;
    logic        application;
    logic [11:0] address;
    logic [7:0]  data;
  } register_access_t;

endpackage
