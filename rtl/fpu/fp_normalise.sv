// SPDX-License-Identifier: Apache-2.0
// fp_normalise: shift a 24-bit significand left until its top bit is one. Combinational.
// Contract: count_o is the number of places; value_o and count_o are meaningful only if value_i is
// not zero. Every group of four bits counts its own zeros while the first group that is not zero is
// sought: shallower than one count.
module fp_normalise (
    input  logic [23:0] value_i,
    output logic [23:0] value_o,
    output logic [4:0]  count_o,
    output logic        zero_o
);

  logic [5:0] nonzero;  // per group, bit 5 is the upper one
  logic [2:0] groups;  // leading groups that are zero
  logic [5:0][1:0] leading;  // per group, its leading zeros
  logic [1:0] bits;  // of the first other group
  logic [23:0] coarse;

  always_comb begin
    for (int g = 0; g < 6; g++) begin
      nonzero[g] = |value_i[4*g+:4];
      casez (value_i[4*g+:4])
        4'b1???: leading[g] = 2'd0;
        4'b01??: leading[g] = 2'd1;
        4'b001?: leading[g] = 2'd2;
        default: leading[g] = 2'd3;
      endcase
    end
    casez (nonzero)
      6'b1?????: groups = 3'd0;
      6'b01????: groups = 3'd1;
      6'b001???: groups = 3'd2;
      6'b0001??: groups = 3'd3;
      6'b00001?: groups = 3'd4;
      default:   groups = 3'd5;
    endcase
    coarse = value_i << {groups, 2'b00};
    bits   = 2'd0;
    for (int g = 0; g < 6; g++) if (groups == 3'(5 - g)) bits = leading[g];
  end

  assign value_o = coarse << bits;
  assign count_o = {groups, bits};
  assign zero_o  = !(|nonzero);

endmodule
