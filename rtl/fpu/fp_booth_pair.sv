// SPDX-License-Identifier: Apache-2.0
// fp_booth_pair: the product of a signed number and four bits of a factor, for a serial multiplier.
// Contract: combinational. Radix-4 Booth rows -2x .. 2x of the digits y_i[2:0] and y_i[4:2], whose lowest
// bit is the top bit of the bits before; sum_o + carry_o = x_i (digit 0 + 4 digit 1). The caller adds carry_o.
// Source: O. L. MacSorley, High-speed arithmetic in binary computers, Proc. IRE 49, 1961.
module fp_booth_pair #(
    parameter int unsigned Width = 34
) (
    input  logic [Width-1:0] x_i,      // signed
    input  logic [4:0]       y_i,
    output logic [Width+3:0] sum_o,    // signed
    output logic             carry_o
);

  function automatic logic [Width:0] booth_row(input logic [2:0] digit, input logic [Width-1:0] x);
    case (digit)
      3'b000, 3'b111: booth_row = '0;
      3'b001, 3'b010: booth_row = {x[Width-1], x};
      3'b011:         booth_row = {x, 1'b0};
      3'b100:         booth_row = ~{x, 1'b0};
      default:        booth_row = ~{x[Width-1], x};
    endcase
  endfunction

  function automatic logic booth_negative(input logic [2:0] digit);
    booth_negative = digit[2] && !(digit[1] && digit[0]);
  endfunction

  logic [Width:0] row0, row1;
  logic unused_low;

  assign row0    = booth_row(y_i[2:0], x_i);
  assign row1    = booth_row(y_i[4:2], x_i);
  assign carry_o = booth_negative(y_i[2:0]);

  // The bit appended below carries a one for a negative row 1.
  assign sum_o[1:0] = row0[1:0];
  assign {sum_o[Width+3:2], unused_low} = {{3{row0[Width]}}, row0[Width:2], 1'b1}
                                        + {row1[Width], row1, booth_negative(y_i[4:2])};

endmodule
