// SPDX-License-Identifier: Apache-2.0
// ecat_counters: error counters of 8 bits that stop at 255.
// Contract: bit n of count_i counts in place n of the list below; a write to a counter clears it, of a port's
// first two the pair. live_* as in ecat_control.
module ecat_counters (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic [11:0] live_address_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    input  logic [9:0]  count_i
);

  localparam int unsigned N = 10;

  function automatic logic [11:0] address_of(input int unsigned place);
    case (place)
      0: address_of = esc_regmap_pkg::REG_INVALID_FRAMES_0;
      1: address_of = esc_regmap_pkg::REG_RX_ERRORS_0;
      2: address_of = esc_regmap_pkg::REG_INVALID_FRAMES_1;
      3: address_of = esc_regmap_pkg::REG_RX_ERRORS_1;
      4: address_of = esc_regmap_pkg::REG_FORWARDED_ERRORS_0;
      5: address_of = esc_regmap_pkg::REG_FORWARDED_ERRORS_1;
      6: address_of = esc_regmap_pkg::REG_PROCESSING_ERRORS;
      7: address_of = esc_regmap_pkg::REG_PDI_ERRORS;
      8: address_of = esc_regmap_pkg::REG_LOST_LINKS_0;
      default: address_of = esc_regmap_pkg::REG_LOST_LINKS_1;
    endcase
  endfunction

  logic [8*N-1:0] counters;
  logic [N-1:0] here, asked;

  genvar index;
  generate
    for (index = 0; index < N; index++) begin : gen_counter
      localparam logic [11:0] Address = address_of(index);
      logic [7:0] counter_q;
      assign asked[index] = live_address_i == Address;
      assign here[index]  = register_i.write && (index < 4 ? register_i.address[11:1] == Address[11:1]
                                                 : register_i.address == Address);
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) counter_q <= '0;
        else if (here[index]) counter_q <= '0;
        else if (count_i[index] && counter_q != '1) counter_q <= counter_q + 1'b1;
      end
      assign counters[8*index+:8] = counter_q;
    end
  endgenerate

  assign live_hit_o = live_address_i[11:5] == esc_regmap_pkg::REG_INVALID_FRAMES_0[11:5];
  always_comb begin
    live_data_o = '0;
    for (int n = 0; n < N; n++) live_data_o = live_data_o | (counters[8*n+:8] & {8{asked[n]}});
  end

  logic unused;
  assign unused = &{register_i.read, register_i.application, register_i.data};

endmodule
