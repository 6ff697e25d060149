// SPDX-License-Identifier: Apache-2.0
// n2_shift: shifts and rotates over stages E and M.
// Contract: operands in E, result_m_o combinational in M. A shift right by n is a rotation left by -n
// with the upper n bits replaced: E negates the count and rotates by its multiples of 8, M does the
// rest and the replacement.
module n2_shift (
    input  logic        clk_i,
    input  logic        en_i,
    input  logic [31:0] value_i,
    input  logic [4:0]  count_i,
    input  logic        right_i,
    input  logic        rotate_i,
    input  logic        sign_i,
    output logic [31:0] result_m_o
);

  logic [4:0] left, left_m_q;
  logic [31:0] coarse, coarse_m_q, middle, fine, below;
  logic replace_m_q, upper_m_q, fill_m_q;

  assign left = right_i ? -count_i : count_i;

  always_comb begin
    case (left[4:3])
      2'd0:    coarse = value_i;
      2'd1:    coarse = {value_i[23:0], value_i[31:24]};
      2'd2:    coarse = {value_i[15:0], value_i[31:16]};
      default: coarse = {value_i[7:0], value_i[31:8]};
    endcase
  end

  always_ff @(posedge clk_i) begin
    if (en_i) begin
      coarse_m_q  <= coarse;
      left_m_q    <= left;
      replace_m_q <= !rotate_i && count_i != 5'd0;
      upper_m_q   <= right_i;
      fill_m_q    <= sign_i && value_i[31];
    end
  end

  always_comb begin
    case (left_m_q[2:1])
      2'd0:    middle = coarse_m_q;
      2'd1:    middle = {coarse_m_q[29:0], coarse_m_q[31:30]};
      2'd2:    middle = {coarse_m_q[27:0], coarse_m_q[31:28]};
      default: middle = {coarse_m_q[25:0], coarse_m_q[31:26]};
    endcase
    fine = left_m_q[0] ? {middle[30:0], middle[31]} : middle;
    for (int unsigned i = 0; i < 32; i++) begin
      below[i] = (5'(i) < left_m_q) != upper_m_q;
      result_m_o[i] = replace_m_q && below[i] ? fill_m_q : fine[i];
    end
  end

endmodule
