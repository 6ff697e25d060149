// SPDX-License-Identifier: Apache-2.0
// aux_compare: asip_aux as its issue logic drives it for one operation of fp_cmp. For proofs only.
// Contract: valid_i issues operation op_i of fp_cmp; the other units are never started here.
module aux_compare (
    input  logic           clk_i,
    input  logic           rst_ni,
    input  logic           valid_i,
    input  logic [3:0]     op_i,
    input  logic [31:0]    a_i,
    input  logic [31:0]    b_i,
    input  logic [31:0]    c_i,
    output logic [31:0]    result_o,
    output fp_pkg::flags_t flags_o
);

  asip_pkg::decoded_t decoded;
  logic unused_fault;
  logic [31:0] unused_read;

  always_comb begin
    decoded        = '0;
    decoded.cmp    = 1'b1;
    decoded.cmp_op = op_i;
  end

  asip_aux #(
      .DataWords(4)
  ) aux (
      .clk_i,
      .rst_ni,
      .valid_i,
      .op_i           (decoded),
      .a_i,
      .b_i,
      .c_i,
      .address_fault_o(unused_fault),
      .result_o,
      .flags_o,
      .host_select_i  (1'b0),
      .host_write_i   (1'b0),
      .host_address_i (16'd0),
      .host_data_i    (32'd0),
      .host_read_o    (unused_read)
  );

endmodule
