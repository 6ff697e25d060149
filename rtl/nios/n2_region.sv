// SPDX-License-Identifier: Apache-2.0
// n2_region: whether base_i + offset_i lies in a memory of 2^Bits bytes at Base. Combinational.
// Contract: the sum is modulo 2^32, the offset signed, Base a multiple of the size. The upper part of
// base_i is compared while the lower part is added: the sum's is that, one more or one less.
module n2_region #(
    parameter logic [31:0] Base = 32'h1000_0000,
    parameter int unsigned Bits = 16
) (
    input  logic [31:0] base_i,
    input  logic [15:0] offset_i,
    output logic        inside_o
);

  localparam int unsigned Cut = Bits > 16 ? Bits : 16;  // the upper part begins here
  localparam logic [Cut-1:0] Middle = Cut'(32'hffff_ffff << Bits);  // above a small memory
  localparam logic [31:Cut] Same = Base[31:Cut];
  localparam logic [31:Cut] Below = Same - 1'b1;
  localparam logic [31:Cut] Above = Same + 1'b1;

  logic [Cut:0] sum;
  logic carry, negative, upper, middle;

  assign negative = offset_i[15];
  assign sum = {1'b0, base_i[Cut-1:0]} + {1'b0, Cut'($signed(offset_i))};
  assign carry = sum[Cut];
  always_comb begin
    if (carry == negative) upper = base_i[31:Cut] == Same;
    else if (carry) upper = base_i[31:Cut] == Below;
    else upper = base_i[31:Cut] == Above;
  end
  assign middle = ((sum[Cut-1:0] ^ Base[Cut-1:0]) & Middle) == '0;
  assign inside_o = upper && middle;

endmodule
