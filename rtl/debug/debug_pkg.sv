// SPDX-License-Identifier: Apache-2.0
// debug_pkg: packets of the debug block (docs/debug_block.md).
package debug_pkg;

  localparam logic [7:0] TYPE_READ = 8'h01;
  localparam logic [7:0] TYPE_WRITE = 8'h02;
  localparam logic [7:0] TYPE_SAMPLES = 8'hc0;
  localparam logic [7:0] TYPE_EVENT = 8'hc1;
  localparam logic [7:0] TYPE_ERROR = 8'hff;
  localparam logic [7:0] ERROR_TYPE = 8'd1;
  localparam logic [7:0] ERROR_LENGTH = 8'd2;
  localparam int unsigned READ_WORDS = 60;
  localparam int unsigned WRITE_WORDS = 8;

  localparam logic [15:0] CRC_START = 16'hffff;

  // CRC-16, polynomial x^16 + x^12 + x^5 + 1, of one byte more, its highest bit first.
  function automatic logic [15:0] crc(input logic [15:0] start, input logic [7:0] data);
    crc = start;
    for (int i = 7; i >= 0; i--) begin
      crc = {crc[14:0], 1'b0} ^ ({16{crc[15] ^ data[i]}} & 16'h1021);
    end
  endfunction

endpackage
