// SPDX-License-Identifier: Apache-2.0
// ecat_latch: system times of the edges of two inputs.
// Contract: an input passes two registers and is compared with itself a clock before; its edge takes the time_i of two clocks
// after the clock in which it came, so the time is 10 to 20 ns late. An input must hold a level for two clocks.
// Continuous: each edge takes its time. Single: an edge takes its time and sets the event; no further one takes any until
// the owner of the input has read the first byte of the time, which clears the event; for the master, after its frame.
// Reading the first byte keeps the other seven for the reads of that side that follow. live_* as in ecat_control;
// live_read_i: the access is a read that is allowed.
module ecat_latch (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic [11:0] live_address_i,
    input  logic        live_application_i,
    input  logic        live_read_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    input  logic [63:0] time_i,
    input  logic [1:0]  latch_i,
    output logic        event_o             // one is set
);

  localparam logic [11:0] First = esc_regmap_pkg::REG_LATCH_TIME_0_RISING;
  localparam logic [11:0] Last = esc_regmap_pkg::REG_LATCH_TIME_1_FALLING;

  // Of four: input 0 rising, falling, input 1 rising, falling.
  logic [255:0] times_q;
  logic [63:0] chosen;
  logic [55:0] for_frame_q, for_application_q, later;
  logic [1:0] meta_q, level_q, before_q, owner_q, rises, falls, index, read_index;
  logic [3:0] single_q, event_q, edges, take, cleared;
  logic [2:0] place;
  logic is_time, is_status;

  assign index     = live_address_i[4:3] ^ First[4:3];
  assign place     = live_address_i[2:0];
  assign is_time   = live_address_i[11:3] >= First[11:3] && live_address_i[11:3] <= Last[11:3];
  assign is_status = live_address_i[11:1] == esc_regmap_pkg::REG_LATCH_STATUS_0[11:1];
  assign chosen    = times_q[64*index+:64];
  assign later     = live_application_i ? for_application_q : for_frame_q;

  // Reads that clear.
  assign read_index = register_i.address[4:3] ^ First[4:3];
  always_comb begin
    cleared = '0;
    if (register_i.read && register_i.address >= First && register_i.address <= Last && register_i.address[2:0] == '0)
      cleared[read_index] = register_i.application == owner_q[read_index[1]];
  end

  assign rises = level_q & ~before_q;
  assign falls = before_q & ~level_q;
  assign edges = {falls[1], rises[1], falls[0], rises[0]};
  assign take = edges & ~event_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      meta_q   <= '0;
      level_q  <= '0;
      before_q <= '0;
      owner_q  <= '0;
      single_q <= '0;
      event_q  <= '0;
    end else begin
      meta_q   <= latch_i;
      level_q  <= meta_q;
      before_q <= level_q;
      event_q  <= ((event_q & ~cleared) | edges) & single_q;
      if (register_i.write) begin
        case (register_i.address)
          esc_regmap_pkg::REG_SYNC_CONTROL:
          owner_q <= {register_i.data[esc_regmap_pkg::SYNC_CONTROL_LATCH1_LSB],
                      register_i.data[esc_regmap_pkg::SYNC_CONTROL_LATCH0_LSB]};
          esc_regmap_pkg::REG_LATCH_CONTROL_0:
          single_q[1:0] <= {register_i.data[esc_regmap_pkg::LATCH_CONTROL_0_FALLING_LSB],
                            register_i.data[esc_regmap_pkg::LATCH_CONTROL_0_RISING_LSB]};
          esc_regmap_pkg::REG_LATCH_CONTROL_1:
          single_q[3:2] <= {register_i.data[esc_regmap_pkg::LATCH_CONTROL_1_FALLING_LSB],
                            register_i.data[esc_regmap_pkg::LATCH_CONTROL_1_RISING_LSB]};
          default: ;
        endcase
      end
    end
  end

  genvar n;
  generate
    for (n = 0; n < 4; n++) begin : gen_time
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) times_q[64*n+:64] <= '0;
        else if (take[n]) times_q[64*n+:64] <= time_i;
      end
    end
  endgenerate

  always_ff @(posedge clk_i) begin
    if (live_read_i && is_time && place == '0) begin
      if (live_application_i) for_application_q <= chosen[63:8];
      else for_frame_q <= chosen[63:8];
    end
  end

  always_comb begin
    live_hit_o  = is_time || is_status;
    live_data_o = '0;
    if (is_status) begin
      live_data_o[esc_regmap_pkg::LATCH_STATUS_0_RISING_LSB]  = event_q[{live_address_i[0], 1'b0}];
      live_data_o[esc_regmap_pkg::LATCH_STATUS_0_FALLING_LSB] = event_q[{live_address_i[0], 1'b1}];
      live_data_o[esc_regmap_pkg::LATCH_STATUS_0_HIGH_LSB]   = level_q[live_address_i[0]];
    end else if (place == '0) begin
      live_data_o = chosen[7:0];
    end else begin
      for (int i = 1; i < 8; i++) if (place == 3'(i)) live_data_o = later[8*i-8+:8];
    end
  end

  assign event_o = event_q != '0;

endmodule
